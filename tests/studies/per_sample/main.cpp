#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "backends/acquisition_backends.h"
#include "backends/loop/loop.h"
#include "backends/paced/paced_stream.h"
#include "backends/realtime_thread.h"
#include "engine/core/named.h"
#include "engine/graph/file/load.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "tests/studies/per_sample/stk_works.h"

// A loop of one frame a call: how late it is, how fast it can be, what a frame costs beside the Synthesis
// Toolkit (STK), and its delay by the phase of a closed loop. Prints Markdown.
//   per_sample_study lateness INSTRUMENT SECONDS [DEVICE]
//   per_sample_study phase SECONDS
//   per_sample_study cost

using namespace tactus;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kRates_hz[] = {1000, 3000, 10'000};

[[noreturn]] void stop_with(const std::string& why) {
  fmt::print(stderr, "{}\n", why);
  std::exit(2);
}

template <class Value>
Value or_end(Result<Value> value) {
  if (!value) stop_with(to_string(value.error()));
  return std::move(*value);
}

std::unique_ptr<Player> player_of(const LoadedGraph& graph, double rate_hz) {
  CompileOptions options;
  options.sample_rate = Hertz{rate_hz};
  auto plan = compile(graph, standard_nodes(), options);
  if (!plan) stop_with(plan.error().front().what);
  return std::make_unique<Player>(std::move(*plan));
}

/// [us] What the histogram does not resolve is named.
std::string quantile(const LatenessHistogram& times, double q) {
  const auto time = times.quantile(q).count() / 1000;
  return time > LatenessHistogram::kBins ? fmt::format("above {}", LatenessHistogram::kBins)
                                         : fmt::format("{}", time);
}

double us(LatenessHistogram::Time time) { return 1e-3 * static_cast<double>(time.count()); }

void print_loop(const std::string& name, const PacedLoop& loop, int priority) {
  const auto& late = loop.lateness();
  const auto& answer = loop.answer();
  fmt::print("| {} | {} | {} | {} | {} | {} | {} | {:.0f} | {} | {:.0f} |{}\n", name, loop.frames(),
             loop.overruns(), loop.skipped(), quantile(late, 0.5), quantile(late, 0.99),
             quantile(late, 0.999), us(late.longest()), quantile(answer, 0.5), us(answer.longest()),
             priority > 0 ? "" : " without real-time priority |");
}

void play(const std::string& name, const std::string& file, const std::string& device, int rate_hz,
          int seconds) {
  auto player = player_of(load_graph_leniently(file), rate_hz);
  Guarded guarded{*player, std::vector<GuardedChannel>{{DriveGuard::Kind::Drive, {}}}};
  std::unique_ptr<Backend> backend;
  if (device.starts_with("loop:")) {
    backend = std::make_unique<LoopBackend>();
  } else {
    const auto* comedi = find_named(acquisition_backends(), "comedi");
    if (comedi == nullptr) stop_with("this program was built without Comedi");
    backend = comedi->make();
  }
  if (auto* described = dynamic_cast<DescribedDevices*>(backend.get()))
    if (auto status = described->add(device); !status) stop_with(to_string(status.error()));
  StreamRequest request;
  request.device = device;
  request.in_channels = request.out_channels = 1;
  request.sample_rate = Hertz{static_cast<double>(rate_hz)};
  auto stream = or_end(backend->open(request, guarded));
  if (auto status = stream->start(); !status) stop_with(to_string(status.error()));
  std::this_thread::sleep_for(std::chrono::seconds{seconds});
  const auto health = stream->health();
  if (auto status = stream->stop(); !status) stop_with(to_string(status.error()));
  print_loop(fmt::format("{}, {} kHz", name, rate_hz / 1000), dynamic_cast<PacedStream&>(*stream).loop(),
             health.realtime_priority);
}

/// Time goes on only as frames are waited for.
class FreeTimer final : public FrameTimer {
 public:
  Time now() noexcept override { return now_; }
  void wait_until(Time time) noexcept override { now_ = std::max(now_, time); }

 private:
  Time now_{0};
};

/// Nothing is converted.
class NoDevice final : public FrameDevice {
 public:
  int in_channels() const override { return 1; }
  int out_channels() const override { return 1; }
  bool read(std::int64_t frame, float* in) noexcept override {
    *in = static_cast<float>(0.001 * static_cast<double>(frame % 100));
    return true;
  }
  bool write(std::int64_t, const float*) noexcept override { return true; }
  void to_zero() noexcept override {}
};

/// Frames a second without waiting: instrument, guard and callback.
double fastest_hz(const std::string& file, int seconds) {
  auto player = player_of(load_graph_leniently(file), 10'000);
  Guarded guarded{*player, std::vector<GuardedChannel>{{DriveGuard::Kind::Drive, {}}}};
  if (auto status = guarded.prepare({Hertz{10e3}, 1, 1, 1}); !status) stop_with(to_string(status.error()));
  NoDevice device;
  PacedLoop loop{device, 10'000};
  FreeTimer timer;
  std::atomic<bool> stops{false};
  const auto start = Clock::now();
  std::int64_t frames = 0;
  loop.run(timer, stops, [&](const float* in, float* out, const PacedFrame&) {
    const double input = static_cast<double>(*in);
    double output = 0.0;
    const double* from[] = {&input};
    double* to[] = {&output};
    guarded.process({from, to, 1});
    *out = static_cast<float>(output);
    stops = ++frames % 1024 == 0 && Clock::now() - start > std::chrono::seconds{seconds};
  });
  return static_cast<double>(frames) / std::chrono::duration<double>(Clock::now() - start).count();
}

int lateness(const std::string& file, int seconds, const std::string& device) {
  fmt::print(
      "| loop | frames | overruns | frames skipped | late, half, us | 99 % | 99.9 % | most | answer, half, "
      "us | most |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n");
  const bool simulated = device.starts_with("loop:");
  for (const int rate_hz : kRates_hz)
    for (const bool busy : {false, true}) {
      const auto settings = !busy ? "" : simulated ? ",busy=1" : ",wait=busy";
      play(busy ? "busy" : "timer", file, device + settings, rate_hz, seconds);
      std::fflush(stdout);
    }
  if (!simulated) return 0;
  const double rate_hz = fastest_hz(file, std::min(seconds, 5));
  fmt::print("\nWithout waiting: {:.0f} frames a second, {:.2f} us a frame.\n", rate_hz, 1e6 / rate_hz);
  return 0;
}

/// x' = u in continuous time: read and written when it happens.
class Integrator final : public FrameDevice {
 public:
  explicit Integrator(std::int64_t frames) : positions(static_cast<std::size_t>(frames), std::nan("")) {}
  int in_channels() const override { return 1; }
  int out_channels() const override { return 1; }
  bool read(std::int64_t frame, float* in) noexcept override {
    go_on();
    *in = static_cast<float>(x_);
    if (frame != now + 1) settled_ = frame + kSettles;
    now = frame;
    if (frame >= settled_ && frame < std::ssize(positions)) positions[index(frame)] = x_;
    return true;
  }
  bool write(std::int64_t, const float* out) noexcept override {
    go_on();
    u_ = static_cast<double>(*out);
    return true;
  }
  void to_zero() noexcept override {}
  std::int64_t now = 0;
  std::vector<double> positions;  ///< by frame; not a number where frames before it were skipped

 private:
  static constexpr int kSettles = 60;  ///< frames; what a skipped one leaves is then 0.7^60

  void go_on() {
    const auto time = Clock::now();
    if (last_ != Clock::time_point{}) x_ += u_ * std::chrono::duration<double>(time - last_).count();
    last_ = time;
  }
  Clock::time_point last_;
  std::int64_t settled_ = 0;
  double x_ = 0.0, u_ = 0.0;
};

/// The complex amplitude at w of what is known from `first` on, by least squares.
std::complex<double> amplitude(const std::vector<double>& signal, double w, std::size_t first) {
  double cc = 0, cs = 0, ss = 0, xc = 0, xs = 0;
  for (std::size_t n = first; n < signal.size(); ++n) {
    if (std::isnan(signal[n])) continue;
    const double c = std::cos(w * static_cast<double>(n)), s = -std::sin(w * static_cast<double>(n));
    cc += c * c, cs += c * s, ss += s * s, xc += signal[n] * c, xs += signal[n] * s;
  }
  const double determinant = cc * ss - cs * cs;
  return {(xc * ss - xs * cs) / determinant, (xs * cc - xc * cs) / determinant};
}

/// The delay from input to output by the phase of a closed loop: see
/// tests/backends/paced/paced_loop_test.cpp. `work`: what each frame takes besides.
void phase(int rate_hz, int seconds, std::chrono::microseconds work) {
  constexpr int kCycle = 20;
  const std::int64_t frames = std::int64_t{rate_hz} * seconds;
  const double period_s = 1.0 / rate_hz, gain = 0.3 * rate_hz, w = 2 * std::numbers::pi / kCycle;
  Integrator plant{frames};
  PacedLoop loop{plant, rate_hz};
  SystemTimer timer{SystemTimer::Wait::Timer};
  std::atomic<bool> stops{false};
  std::thread{[&] {
    (void)become_realtime(80);
    use_stack();
    loop.run(timer, stops, [&](const float* in, float* out, const PacedFrame&) {
      const auto start = Clock::now();
      *out = static_cast<float>(gain *
                                (std::cos(w * static_cast<double>(plant.now)) - static_cast<double>(*in)));
      while (Clock::now() - start < work) continue;
      stops = plant.now >= frames;
    });
  }}.join();
  using Complex = std::complex<double>;
  const Complex response = amplitude(plant.positions, w, plant.positions.size() / 2);
  const Complex z = std::polar(1.0, w), open = response / (1.0 - response);
  const Complex delay_s = (period_s - open * (z - 1.0) / gain) / (1.0 - 1.0 / z);
  fmt::print("| {} kHz | {} us | {:.1f} us | {:.1f} us | {:.0f} us | {:.3f} | {} |\n", rate_hz / 1000,
             work.count(), 1e6 * delay_s.real(), 1e6 * delay_s.imag(), us(loop.answer().quantile(0.5)),
             delay_s.real() / period_s, loop.skipped());
  std::fflush(stdout);
}

int phases(int seconds) {
  fmt::print(
      "| rate | work in each frame | delay by the phase | imaginary part (0 in theory) | by the clock, half "
      "| "
      "in frames | frames skipped |\n|---|---|---|---|---|---|---|\n");
  for (const int rate_hz : kRates_hz)
    for (const double share : {0.0, 0.5})
      phase(rate_hz, seconds, std::chrono::microseconds{std::llround(share * 1e6 / rate_hz)});
  return 0;
}

/// Nanoseconds a frame of this thread, whatever else the machine does.
class Stopwatch {
 public:
  static double seconds() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
};

struct Subject {
  std::string name;
  std::function<void(int)> run;  ///< so many frames
};

const std::pair<const char*, const char*> kGraphs[] = {{"spring on a mass", R"(format = 1
[inputs]
x = { unit = "N" }
[networks.n]
solver = "explicit"
m = { type = "mass", mass = "9 g", at = "0 m" }
s = { type = "spring", between = ["ground", "m"], stiffness = "200 N/m", damping = "0.05 N s/m" }
ground = { type = "ground" }
f = { type = "force", on = "m", force = "x" }
p = { type = "probe", on = "m" }
[outputs]
out = { from = "n.p / 1 m" }
)"},
                                                       {"wall", R"(format = 1
[inputs]
x = { unit = "m" }
[nodes]
v = { type = "velocity", in = "x", cutoff = "300 Hz" }
f = { type = "wall", position = "x", velocity = "v", stiffness = "400 N/m", damping = "1 N s/m" }
[outputs]
out = { from = "f / 6.37 N" }
)"},
                                                       {"friction", R"(format = 1
[inputs]
x = { unit = "m" }
[nodes]
a = { type = "hysteresis", in = "x", width = "1 mm" }
[outputs]
out = { from = "2 kN/m * (a - x) / 6.37 N" }
)"},
                                                       {"string", R"(format = 1
[inputs]
x = {}
[nodes]
s = { type = "string", in = "x", pitch = "220 Hz", gain = 0.99, loss = 0.5 }
[outputs]
out = { from = "s" }
)"}};

/// Medians of interleaved runs: each round runs all subjects once.
int cost() {
  constexpr int kFrames = 20'000, kRounds = 41;
  constexpr double kRate_hz = 48e3;
  std::vector<Subject> subjects;
  std::vector<double> input(1000);
  for (std::size_t n = 0; n < input.size(); ++n) input[n] = 0.01 * std::sin(0.0628 * static_cast<double>(n));
  std::vector<std::unique_ptr<Player>> players;
  std::vector<std::unique_ptr<Guarded>> guards;
  const auto blocks_of_one = [&input](BlockProcessor& processor) {
    return [&input, &processor](int frames) {
      double out = 0.0;
      double* to[] = {&out};
      for (int n = 0; n < frames; ++n) {
        const double* from[] = {&input[index(n % 1000)]};
        processor.process({from, to, 1});
      }
    };
  };
  for (const auto& [name, text] : kGraphs) {
    players.push_back(player_of(parse_graph_leniently(text, "cost.toml"), kRate_hz));
    auto& alone = *players.back();
    if (auto status = alone.prepare({Hertz{kRate_hz}, 1, 1, 1}); !status)
      stop_with(to_string(status.error()));
    subjects.push_back({name, blocks_of_one(alone)});
    players.push_back(player_of(parse_graph_leniently(text, "cost.toml"), kRate_hz));
    guards.push_back(std::make_unique<Guarded>(*players.back(),
                                               std::vector<GuardedChannel>{{DriveGuard::Kind::Drive, {}}}));
    if (auto status = guards.back()->prepare({Hertz{kRate_hz}, 1, 1, 1}); !status)
      stop_with(to_string(status.error()));
    subjects.push_back({name, blocks_of_one(*guards.back())});
    players.push_back(player_of(parse_graph_leniently(text, "cost.toml"), kRate_hz));
    auto& longer = *players.back();
    if (auto status = longer.prepare({Hertz{kRate_hz}, 1, 1, 50}); !status)
      stop_with(to_string(status.error()));
    subjects.push_back({name, [&input, &longer](int frames) {
                          std::vector<double> out(50);
                          double* to[] = {out.data()};
                          for (int n = 0; n < frames; n += 50) {
                            const double* from[] = {&input[index(n % 1000)]};
                            longer.process({from, to, 50});
                          }
                        }});
    subjects.push_back(
        {name, [&input, stk = std::shared_ptr{bench::make_stk_work(name, kRate_hz)}](int frames) {
           double sum = 0.0;
           for (int n = 0; n < frames; ++n) sum += stk->tick(input[index(n % 1000)]);
           static volatile double kept;
           kept = sum;
           (void)kept;
         }});
  }
  const NoDenormals no_denormals;
  std::vector<std::vector<double>> ns(subjects.size());
  for (int round = 0; round < kRounds; ++round)
    for (std::size_t s = 0; s < subjects.size(); ++s) {
      const double start = Stopwatch::seconds();
      subjects[s].run(kFrames);
      ns[s].push_back(1e9 * (Stopwatch::seconds() - start) / kFrames);
    }
  const auto median = [&](std::size_t s) {
    auto& runs = ns[s];
    std::nth_element(runs.begin(), runs.begin() + kRounds / 2, runs.end());
    return runs[kRounds / 2];
  };
  fmt::print(
      "| law | graph, blocks of one frame | with the drive guard | graph, blocks of 50 | STK | STK's classes "
      "|\n"
      "|---|---|---|---|---|---|\n");
  for (std::size_t s = 0; s < subjects.size(); s += 4)
    fmt::print("| {} | {:.0f} | {:.0f} | {:.1f} | {:.1f} | {} |\n", subjects[s].name, median(s),
               median(s + 1), median(s + 2), median(s + 3), bench::stk_classes(subjects[s].name));
  return 0;
}

}  // namespace

int main(int count, char** arguments) {
  const std::string mode = count > 1 ? arguments[1] : "";
  (void)lock_memory();
  if (mode == "lateness" && count >= 4)
    return lateness(arguments[2], std::stoi(arguments[3]), count > 4 ? arguments[4] : "loop:per_sample");
  if (mode == "phase" && count == 3) return phases(std::stoi(arguments[2]));
  if (mode == "cost") return cost();
  stop_with("per_sample_study lateness INSTRUMENT SECONDS [DEVICE] | phase SECONDS | cost");
}
