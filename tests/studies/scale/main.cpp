#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"

// How many masses a core runs at 48 kHz, by solver and kind of network, from graph files. Prints Markdown;
// with arguments (network, solver, masses) the nanoseconds per mass and frame of that one alone.

using namespace tactus;
using Clock = std::chrono::steady_clock;

namespace {

constexpr double kRate = 48e3, kBudget_ns = 1e9 / kRate;
constexpr int kBlock = 64;

// Short runs, so that most are not interrupted by other programs.
constexpr double kRun_s = 0.002;
constexpr int kRuns = 101;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Of this program alone, whatever else the machine does.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// The numbers of each mass and link: k / (m fs^2) between neighbours, z / (m fs) between them and to the
/// ground.
std::string numbers(double stiffness) {
  return fmt::format("mass = 1, stiffness = {}, damping = {}, ground_damping = {}", stiffness * kRate * kRate,
                     0.01 * kRate, 0.0005 * kRate);
}

std::string chain(int masses) {
  return fmt::format("net = {{ type = \"chain\", masses = {}, {} }}\n", masses, numbers(0.25));
}

std::string grid(int masses) {
  const int side = std::max(2, static_cast<int>(std::lround(std::sqrt(masses))));
  return fmt::format("net = {{ type = \"grid\", rows = {0}, columns = {0}, {1} }}\n", side, numbers(0.1));
}

/// Masses on the ground and as many springs from anywhere to anywhere.
std::string tangle(int masses) {
  std::mt19937 generator(1);
  std::uniform_int_distribution<int> any(1, masses);
  auto text = fmt::format(
      "net = {{ type = \"chain\", masses = {}, ends = \"free\", mass = 1, stiffness = 0, ground_stiffness = "
      "{} }}\n",
      masses, 0.05 * kRate * kRate);
  for (int i = 1; i <= masses; ++i) {
    int to = any(generator);
    if (to == i) to = to % masses + 1;
    text +=
        fmt::format("s{0} = {{ type = \"spring\", between = [\"net.{0}\", \"net.{1}\"], stiffness = {2} }}\n",
                    i, to, 0.02 * kRate * kRate);
  }
  return text;
}

struct Kind {
  const char* name;
  std::function<std::string(int)> elements;
  std::function<std::string(int, int)> place;  ///< a part in a hundred of the way along the masses
};

std::string along(int masses, int percent) { return fmt::format("net.{}", 1 + (masses - 1) * percent / 100); }
std::string across(int masses, int percent) {
  const int side = std::max(2, static_cast<int>(std::lround(std::sqrt(masses))));
  const int at = 1 + (side - 1) * percent / 100;
  return fmt::format("net.{0}.{0}", at);
}

struct Measured {
  double ns = 0, load_s = 0;
  std::string refused;
};

Measured measure(const std::string& text) {
  Measured result;
  const auto start = Clock::now();
  CompileOptions options;
  options.most_bytes = std::size_t{4} << 30;
  auto schedule = compile(parse_graph_leniently(text, "scale.toml"), standard_nodes(), options);
  result.load_s = seconds_since(start);
  if (!schedule) {
    result.refused = schedule.error().front().what;
    return result;
  }
  const NoDenormals no_denormals;
  Player engine{std::move(*schedule)};
  if (!engine.prepare({Hertz{kRate}, 1, 1, kBlock})) return result;
  std::vector<double> in(kBlock), out(kBlock);
  for (std::size_t i = 0; i < in.size(); ++i) in[i] = std::sin(0.1 * static_cast<double>(i));
  const double* from[] = {in.data()};
  double* to[] = {out.data()};
  const auto play = [&](int blocks) {
    const double before_s = cpu_seconds();
    for (int i = 0; i < blocks; ++i) engine.process({from, to, kBlock});
    return cpu_seconds() - before_s;
  };
  int blocks = 1;
  while (play(blocks) < kRun_s) blocks *= 2;
  std::vector<double> runs;
  for (int run = 0; run < kRuns; ++run) runs.push_back(1e9 * play(blocks) / (blocks * kBlock));
  std::nth_element(runs.begin(), runs.begin() + kRuns / 2, runs.end());
  result.ns = runs[kRuns / 2];
  return result;
}

std::string graph(const Kind& kind, const char* solver, int masses) {
  return fmt::format(
      "format = 1\nname = \"scale\"\n[inputs]\nin = {{}}\n[networks.n]\nsolver = \"{}\"\n{}push = {{ type = "
      "\"force\", "
      "on = \"{}\", force = \"in * 1 N\" }}\near = {{ type = \"probe\", on = \"{}\" }}\n[outputs]\nout = {{ "
      "from = "
      "\"n.ear / 1 m\" }}\n",
      solver, kind.elements(masses), kind.place(masses, 33), kind.place(masses, 67));
}

void measure_all(const Kind& kind, const char* solver, int most) {
  double before_masses = 0, before_ns = 0, fits = 0;
  for (const int masses : {10, 100, 1000, 10'000, 90'000}) {
    if (masses > most) break;
    const auto found = measure(graph(kind, solver, masses));
    if (!found.refused.empty()) {
      fmt::print("| {} | {} | {} | refused: {} | | | |\n", kind.name, solver, masses, found.refused);
      fits = std::min(fits, before_masses);
      break;
    }
    fmt::print("| {} | {} | {} | {:.0f} | {:.2f} | {:.1f} % | {:.0f} |\n", kind.name, solver, masses,
               found.ns, found.ns / masses, 100 * found.ns / kBudget_ns, 1000 * found.load_s);
    std::fflush(stdout);
    if (found.ns < kBudget_ns)
      fits = masses * kBudget_ns / found.ns;
    else if (before_ns > 0 && before_ns < kBudget_ns)
      fits = before_masses * std::pow(kBudget_ns / before_ns,
                                      std::log(masses / before_masses) / std::log(found.ns / before_ns));
    before_masses = masses, before_ns = found.ns;
    if (found.ns > 20 * kBudget_ns) break;
  }
  fmt::print("| {} | {} | **{:.2g}** | a core at 48 kHz | | | |\n", kind.name, solver, fits);
}

}  // namespace

int main(int count, char** arguments) {
  const Kind kinds[] = {{"chain", chain, along}, {"grid", grid, across}, {"random", tangle, along}};
  if (count == 4) {
    const int masses = std::stoi(arguments[3]);
    for (const auto& kind : kinds)
      if (arguments[1] == std::string(kind.name))
        fmt::print("{:.4f}\n", measure(graph(kind, arguments[2], masses)).ns / masses);
    return 0;
  }
  fmt::print(
      "| network | solver | masses | ns per frame | ns a mass | of a core | load, ms "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const auto& kind : kinds) {
    measure_all(kind, "explicit", 90'000);
    measure_all(kind, "passive", 90'000);
    measure_all(kind, "implicit", 90'000);
    measure_all(kind, "exact", 1000);
  }
}
