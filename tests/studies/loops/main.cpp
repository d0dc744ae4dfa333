#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <mutex>
#include <string>

#include "engine/nodes/table.h"
#include "engine/scene/closed_loop.h"
#include "engine/study/stability/stability_check.h"
#include "engine/study/sweep/evaluate_runs.h"
#include "tests/studies/loops/random_loops.h"
#include "tests/support/temporary_folder.h"

// Is `tactus check` right? `loops_study LOOPS [FIRST] [KIND]` writes random closed loops as files, decides by
// equations of its own whether they grow, and asks `check_stability`, with the runs and without. Prints a
// table, and on stderr each loop of which the answer is wrong or missing. `loops_study --write NUMBER FOLDER`
// writes the files of one. Exit code 1: a loop that grows was passed, or more was refused or left undecided
// than may be.

using namespace tactus;
using namespace tactus::study;

namespace {

constexpr double kMostRefused = 0.01, kMostUndecided = 0.05;

/// Answers to loops of one kind.
struct Tally {
  int stable = 0, stable_passed = 0, growing = 0, growing_refused = 0, false_pass = 0, false_refusal = 0,
      undecided = 0;

  void add(bool grows, Stability said) {
    (grows ? growing : stable) += 1;
    undecided += said == Stability::Undecided;
    stable_passed += !grows && said == Stability::Stable;
    growing_refused += grows && said == Stability::Unstable;
    false_pass += grows && said == Stability::Stable;
    false_refusal += !grows && said == Stability::Unstable;
  }
  void add(const Tally& other) {
    stable += other.stable, stable_passed += other.stable_passed, growing += other.growing;
    growing_refused += other.growing_refused, false_pass += other.false_pass;
    false_refusal += other.false_refusal, undecided += other.undecided;
  }
  bool good() const {
    const double all = stable + growing;
    return false_pass == 0 && false_refusal <= kMostRefused * all && undecided <= kMostUndecided * all;
  }
};

/// A loop as the program reads it.
struct Subject {
  std::optional<LoadedScene> scene;
  std::optional<LoadedGraph> instrument;
  StabilityOptions options;

  explicit Subject(const LoopFiles& loop, const test::TemporaryFolder& folder) {
    for (const auto& [name, text] : loop.files) folder.write(name, text);
    if (loop.files.contains("scene.toml"))
      scene = load_scene_leniently(folder.path() / "scene.toml");
    else
      instrument = load_graph_leniently(folder.path() / "i.toml");
    options.world.rate = Hertz{loop.rate};
    options.world.delay = Seconds{loop.delay_s};
    options.world.device = {loop.device_mass, loop.device_damping};
  }
  StabilitySubject subject() const {
    return {scene ? &*scene : nullptr, instrument ? &*instrument : nullptr, &standard_nodes()};
  }
};

/// An instrument whose first sensor is pushed.
class Pushed final : public BlockProcessor {
 public:
  explicit Pushed(BlockProcessor& inner) : inner_(inner) {}
  Status prepare(const StreamFormat& format) override {
    sensors_.resize(format.in_channels, format.max_frames);
    return inner_.prepare(format);
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < sensors_.size(); ++c)
      for (int n = 0; n < io.frames; ++n)
        sensors_[c][n] = io.in[c][n] + (c == 0 && pushed(frame_ + n) ? 1.0 : 0.0);
    inner_.process({sensors_.data(), io.out, io.frames});
    for (int n = 0; n < io.frames; ++n) first.push_back(io.out[0][n]);
    frame_ += io.frames;
  }
  std::vector<double> first;

 private:
  BlockProcessor& inner_;
  ChannelBuffers sensors_;
  long frame_ = 0;
};

/// How far the loop's own equations are from what the engine plays, relative to the largest value.
double distance_from_engine(const Subject& subject, const std::vector<double>& expected) {
  auto built = build_world(subject.subject(), subject.options.world);
  if (!built) return std::numeric_limits<double>::infinity();
  Pushed pushed{*built->instrument};
  ClosedLoop loop{
      pushed, *built->plant, built->instrument->out_channels(), built->delay_frames, {.on = false}};
  if (!loop.prepare(*subject.options.world.rate, 32)) return std::numeric_limits<double>::infinity();
  loop.run(static_cast<int>(expected.size()));
  double most = 1e-300, apart = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    most = std::max(most, std::abs(expected[i]));
    apart = std::max(apart, std::abs(expected[i] - pushed.first[i]));
  }
  return apart / most;
}

class Study {
 public:
  void add(long number) {
    const auto loop = random_loop(number);
    const test::TemporaryFolder folder;
    const Subject subject(loop.loop, folder);
    if (!loop.response.empty())
      if (const double apart = distance_from_engine(subject, loop.response); !(apart < 1e-6))
        note(number, loop, fmt::format("the study's equations are {:.1e} off what the engine plays", apart),
             true);
    for (const bool quick : {false, true}) {
      const auto report = check_stability(subject.subject(), subject.options, quick, {}, 1);
      if (!report) {
        note(number, loop, "not read: " + to_string(report.error()), true);
        continue;
      }
      judge(number, loop, quick, *report);
    }
  }

  int print() const {
    fmt::print(
        "| kind | mode | stable / said stable | growing / said growing | false pass | false refusal | "
        "undecided |\n"
        "|---|---|---|---|---|---|---|\n");
    bool good = true;
    for (const bool quick : {false, true}) {
      Tally all;
      for (const auto& kind : loop_kinds())
        if (const auto found = tallies_.find({kind, quick}); found != tallies_.end()) {
          print_row(kind, quick, found->second);
          all.add(found->second);
        }
      print_row("all", quick, all);
      good = good && all.good();
    }
    return good && broken_ == 0 ? 0 : 1;
  }

 private:
  static void print_row(const std::string& kind, bool quick, const Tally& t) {
    fmt::print("| {} | {} | {} / {} | {} / {} | {} | {} | {} |\n", kind, quick ? "quick" : "full", t.stable,
               t.stable_passed, t.growing, t.growing_refused, t.false_pass, t.false_refusal, t.undecided);
  }

  void judge(long number, const RandomLoop& loop, bool quick, const StabilityReport& report) {
    const auto said = report.stability();
    const bool grows = loop.truth.grows();
    {
      const std::lock_guard lock(mutex_);
      tallies_[{loop.kind, quick}].add(grows, said);
    }
    const auto right = grows ? Stability::Unstable : Stability::Stable;
    if (said == right) return;
    std::string why;
    for (const auto& sentence : describe(report.verdict)) why += (why.empty() ? "" : "; ") + sentence;
    for (const auto& run : report.runs)
      if (!run.as_expected()) why += "; not as predicted: " + run.what;
    const char* what = said == Stability::Undecided ? "undecided" : grows ? "FALSE PASS" : "false refusal";
    note(number, loop,
         fmt::format("{} ({}), grows by {:.3g} per second: {}", what, quick ? "quick" : "full",
                     loop.truth.growth, why),
         false);
  }

  void note(long number, const RandomLoop& loop, const std::string& text, bool broken) {
    const std::lock_guard lock(mutex_);
    broken_ += broken;
    fmt::print(stderr, "loop {} ({}, {:g} kHz, {:.4g} of its border): {}\n", number, loop.kind,
               loop.loop.rate / 1e3, loop.of_border, text);
  }

  std::mutex mutex_;
  std::map<std::pair<std::string, bool>, Tally> tallies_;
  int broken_ = 0;
};

int write_files(long number, const std::filesystem::path& folder) {
  const auto made = random_loop(number);
  std::filesystem::create_directories(folder);
  for (const auto& [name, text] : made.loop.files) std::ofstream{folder / name} << text;
  fmt::print("{}, {:.4g} of its border, grows by {:.4g} per second\n", made.kind, made.of_border,
             made.truth.growth);
  const bool alone = !made.loop.files.contains("scene.toml");
  fmt::print("tactus check {}", (folder / (alone ? "i.toml" : "scene.toml")).string());
  if (alone)
    fmt::print(
        " --rate '{:.17g} Hz' --delay '{:.17g} s' --device-mass '{:.17g} kg' --device-damping '{:.17g} N "
        "s/m'",
        made.loop.rate, made.loop.delay_s, made.loop.device_mass, made.loop.device_damping);
  fmt::print("\n");
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> words(arguments + 1, arguments + count);
  if (words.size() == 3 && words[0] == "--write") return write_files(std::stol(words[1]), words[2]);
  const long loops = words.empty() ? 1000 : std::stol(words[0]),
             first = words.size() > 1 ? std::stol(words[1]) : 1;
  const auto kinds = static_cast<long>(loop_kinds().size());
  std::vector<long> numbers;
  for (long number = first; number < first + loops; ++number)
    if (words.size() < 3 || loop_kinds()[static_cast<std::size_t>(number % kinds)] == words[2])
      numbers.push_back(number);
  Study study;
  int shown = 0;
  parallel_for(
      static_cast<int>(numbers.size()), [&](int i) { study.add(numbers[static_cast<std::size_t>(i)]); },
      [&](double share) {
        if (const int percent = static_cast<int>(10 * share);
            percent > std::exchange(shown, std::max(shown, percent)))
          fmt::print(stderr, "{} %\n", 10 * percent);
      },
      2);
  return study.print();
}
