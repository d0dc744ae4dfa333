#include "tests/studies/latency/captures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "engine/core/index.h"
#include "latency/estimation/analysis.h"
#include "latency/estimation/delay_trend.h"
#include "latency/probe/probe.h"
#include "tests/studies/latency/backgrounds.h"
#include "tests/studies/latency/in_parallel.h"
#include "tests/support/simulated_loop.h"

namespace tactus::study {
namespace {

constexpr double kLevel = 0.25;
constexpr double kGross = 0.5;      // frames
constexpr double kWithin = 5.0;     // standard errors
constexpr double kAudible = -40.0;  // dB beside the probe: a background that may be named instead

enum class Kind { Nothing, Clocks, Lost, Distorted, TwoPaths, NoCable };
constexpr std::array kKinds{"nothing else", "two clocks",  "lost frames",
                            "distortion",   "second path", "no cable"};

struct Capture {
  int number = 0;
  Kind kind = Kind::Nothing;
  Background background = Background::Noise;
  double below_db = 0.0;  ///< the background, of a probe at full level
  double delay = 0.0, size = 0.0;
  std::int64_t place = 0;
  std::string what;
  LoopRecording recording;
};

/// What became of it.
struct Outcome {
  Kind kind = Kind::Nothing;
  Background background = Background::Noise;
  double below_db = 0.0, z = 0.0, error = 0.0;
  bool ok = false, right = false, gross = false, silent = false;
  std::string verdict;
};

class Maker {
 public:
  Maker(const Backgrounds& sounds, int number) : sounds_(sounds), random_(index(number) * 7919 + 17) {
    made_.number = number;
  }

  Capture make() {
    constexpr std::array kOrder{Kind::Nothing, Kind::Lost,    Kind::Nothing,   Kind::Clocks,
                                Kind::Lost,    Kind::Nothing, Kind::Distorted, Kind::TwoPaths};
    made_.kind = kOrder[index(made_.number % 8)];
    if (made_.kind == Kind::Nothing && one_of(8) == 0) made_.kind = Kind::NoCable;
    made_.background = static_cast<Background>(made_.number / 8 % 4);
    made_.below_db = between(0.0, made_.kind == Kind::Nothing ? 60.0 : 80.0);
    loop_.delay_frames = between(0.0, one_of(4) == 0 ? 30000.0 : 3000.0);
    loop_.gain = (one_of(2) == 0 ? 1.0 : -1.0) * std::pow(10.0, between(-30.0, 0.0) / 20.0);
    if (one_of(3) == 0) loop_.high_pass_hz = {between(1.0, 30.0)};
    made_.recording = loop_.record(stimulus(rate_, kLevel), rate_, 24000);
    made_.delay = loop_.delay_frames;
    happen();
    add_background();
    return std::move(made_);
  }

 private:
  double between(double low, double high) { return std::uniform_real_distribution{low, high}(random_); }
  double ratio(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }
  int one_of(int count) { return std::uniform_int_distribution{0, count - 1}(random_); }
  std::vector<double>& captured() { return made_.recording.captured[0]; }

  void happen() {
    switch (made_.kind) {
      case Kind::Nothing:
        return;
      case Kind::NoCable:
        std::fill(captured().begin(), captured().end(), 0.0);
        return;
      case Kind::Clocks:
        return clocks();
      case Kind::Lost:
        return lost();
      case Kind::Distorted:
        return distorted();
      case Kind::TwoPaths:
        return second_path();
    }
  }

  void clocks() {
    made_.size = (one_of(2) == 0 ? 1.0 : -1.0) * ratio(0.02, 500.0);
    captured() = at_speed(captured(), 1.0 / (1.0 + 1e-6 * made_.size));
    const auto probes = find_bursts(made_.recording.played, rate_)->repeated;
    const double middle = 0.5 * static_cast<double>(probes.front().at + probes.back().end());
    made_.delay = (middle + loop_.delay_frames) * (1.0 + 1e-6 * made_.size) - middle;
    made_.what = fmt::format("{:+.3f} ppm", made_.size);
  }

  void lost() {
    const auto begin = static_cast<std::int64_t>(loop_.delay_frames);
    const auto length = static_cast<std::int64_t>(stimulus(rate_, 1.0).size());
    made_.place = std::uniform_int_distribution<std::int64_t>{begin, begin + length - 1}(random_);
    const auto count = std::llround(ratio(1.0, 2000.0));
    const auto at = captured().begin() + made_.place;
    const int how = one_of(5);
    made_.size = static_cast<double>(count);
    made_.what = fmt::format("{} {} frames at {} ({:.3f} s of the probe)",
                             how < 2   ? "lost"
                             : how < 4 ? "doubled"
                                       : "silenced",
                             count, made_.place, static_cast<double>(made_.place - begin) / rate_.value);
    if (how < 2) {
      captured().erase(at, std::min(captured().end(), at + count));
    } else if (how < 4) {
      const auto back = std::min<std::int64_t>(count, made_.place);
      const std::vector<double> again(at - back, at);
      captured().insert(at, again.begin(), again.end());
    } else {
      std::fill(at, std::min(captured().end(), at + count), 0.0);
      made_.size = 0.0;
    }
    captured().resize(made_.recording.played.size(), 0.0);
  }

  void distorted() {
    const double top = kLevel * std::abs(loop_.gain);
    const int how = one_of(5);
    const double much = how == 0   ? between(0.3, 0.95)
                        : how == 1 ? ratio(0.1, 4.0)
                        : how == 2 ? ratio(1e-4, 0.1)
                                   : ratio(0.003, 0.5);
    constexpr std::array kHow{"clip at", "tanh", "dead zone", "square", "cube"};
    made_.what = fmt::format("{} {:.3g}", kHow[index(how)], much);
    for (auto& sample : captured()) {
      const double x = sample / top;
      const double y = how == 0   ? std::clamp(x, -much, much)
                       : how == 1 ? std::tanh(much * x) / much
                       : how == 2 ? (std::abs(x) < much ? 0.0 : x - std::copysign(much, x))
                       : how == 3 ? x + much * x * x
                                  : x - 0.5 * much * x * x * x;
      sample = top * y;
    }
  }

  void second_path() {
    const double distance = (one_of(5) == 0 ? -1.0 : 1.0) * ratio(1.0, 20000.0);
    const double level = std::pow(10.0, between(-40.0, -6.0) / 20.0);
    made_.what = fmt::format("{:+.1f} frames at {:.1f} dB", distance, 20.0 * std::log10(level));
    made_.size = distance;
    auto other = loop_;
    other.delay_frames = loop_.delay_frames + distance;
    if (other.delay_frames < 0.0) {
      loop_.delay_frames -= distance;
      other.delay_frames -= distance;
      made_.recording = loop_.record(stimulus(rate_, kLevel), rate_, 24000);
      made_.delay = loop_.delay_frames;
    }
    other.gain *= level;
    const auto more = other.record(stimulus(rate_, kLevel), rate_, 24000).captured[0];
    for (std::size_t n = 0; n < std::min(more.size(), captured().size()); ++n) captured()[n] += more[n];
  }

  void add_background() {
    const auto sound = sounds_.samples(made_.background, captured().size(), random_);
    const double probe = kLevel * std::abs(loop_.gain) / std::numbers::sqrt2;
    const double level = probe * std::pow(10.0, -made_.below_db / 20.0);
    double peak = 0.0;
    for (std::size_t n = 0; n < sound.size(); ++n)
      peak = std::max(peak, std::abs(captured()[n] += level * sound[n]));
    const double fits = peak > 0.9 ? 0.9 / peak : 1.0;
    const double steps = std::exp2(one_of(2) == 0 ? 15 : 23);
    for (auto& sample : captured()) sample = std::round(fits * sample * steps) / steps;
  }

  const Backgrounds& sounds_;
  std::mt19937_64 random_;
  Hertz rate_ = 48_kHz;
  test::SimulatedLoop loop_;
  Capture made_;
};

/// Is the name of the verdict that of what happened? A background that is audible may be named instead of
/// what it hides.
bool right_name(const Capture& capture, const Analysis& analysis, bool within) {
  const auto verdict = analysis.finding.verdict;
  const bool ok = verdict == Verdict::Ok;
  const bool hidden =
      (verdict == Verdict::BackgroundSound || verdict == Verdict::LowSnr) && -capture.below_db > kAudible;
  if (hidden && capture.kind != Kind::NoCable) return true;
  switch (capture.kind) {
    case Kind::Nothing:
      return ok && within;
    case Kind::NoCable:
      return verdict == Verdict::NoSignal;
    case Kind::Clocks:
      return verdict == Verdict::ClocksDiffer ||
             (ok && within &&
              std::abs(analysis.drift_ppm - capture.size) < kWithin * analysis.drift_standard_error_ppm);
    case Kind::Lost:
      return verdict == Verdict::LostFrames || (ok && within);
    case Kind::Distorted:
      // Where the harmonics are hidden, a gain that depends on the level is all that is seen.
      return verdict == Verdict::Clipping || (ok && within) ||
             (verdict == Verdict::Agc && -capture.below_db > kAudible);
    case Kind::TwoPaths:
      // Within a few frames it is the path's shape.
      return verdict == Verdict::DirectMonitoring || (ok && within) ||
             (verdict == Verdict::NotFlat && std::abs(capture.size) < 40.0);
  }
  return false;
}

Outcome outcome_of(const Capture& capture) {
  const auto analysis = analyze(capture.recording).value();
  Outcome outcome;
  outcome.kind = capture.kind;
  outcome.background = capture.background;
  outcome.below_db = capture.below_db;
  outcome.verdict = code(analysis.finding.verdict);
  outcome.ok = analysis.finding.verdict == Verdict::Ok;
  outcome.error = analysis.delay_frames - capture.delay;
  outcome.z = outcome.error / analysis.standard_error_frames;
  double error = std::abs(outcome.error);
  // Lost or doubled: before the place it is one delay, behind it the other.
  if (capture.kind == Kind::Lost) error = std::max(error, capture.size);
  const bool within = error < kWithin * analysis.standard_error_frames;
  outcome.right = right_name(capture, analysis, within);
  outcome.gross = outcome.ok && (std::abs(outcome.error) > kGross && capture.kind != Kind::Lost);
  if (capture.kind == Kind::NoCable) outcome.gross = outcome.ok;
  outcome.silent = outcome.ok && capture.kind == Kind::Lost && !within;
  if (!outcome.right || outcome.gross || outcome.silent || (outcome.ok && std::abs(outcome.z) > 4.0))
    fmt::print(stderr,
               "{}: {} {}; {} {:.1f} dB below: {} ({}), error {:.5f} +- {:.5f}, drift {:.4f} +- {:.4f}\n",
               capture.number, kKinds[index(static_cast<int>(capture.kind))], capture.what,
               kBackgroundNames[static_cast<int>(capture.background)], capture.below_db, outcome.verdict,
               analysis.finding.what, outcome.error, analysis.standard_error_frames, analysis.drift_ppm,
               analysis.drift_standard_error_ppm);
  return outcome;
}

struct Row {
  int captures = 0, ok = 0, right = 0, gross = 0, silent = 0, beyond = 0;
  double squares = 0.0, worst = 0.0;
  std::map<std::string, int> verdicts;

  void add(const Outcome& outcome) {
    ++captures;
    ok += outcome.ok;
    right += outcome.right;
    gross += outcome.gross;
    silent += outcome.silent;
    ++verdicts[outcome.verdict];
    if (!outcome.ok) return;
    squares += outcome.z * outcome.z;
    beyond += std::abs(outcome.z) > 3.0;
    worst = std::max(worst, std::abs(outcome.z));
  }
};

std::string listed(const std::map<std::string, int>& verdicts) {
  std::string text;
  for (const auto& [verdict, count] : verdicts)
    if (verdict != "ok") text += fmt::format("{}{} {}", text.empty() ? "" : ", ", verdict, count);
  return text;
}

void print_kinds(const std::vector<Outcome>& outcomes) {
  fmt::print(
      "| what happened | captures | right verdict | gross errors | frames lost without a word | ok | refused "
      "as |\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  const auto line = [](const char* name, const Row& row) {
    fmt::print("| {} | {} | {:.1f} % | {} | {} | {} | {} |\n", name, row.captures,
               100.0 * row.right / row.captures, row.gross, row.silent, row.ok, listed(row.verdicts));
  };
  Row all;
  for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
    Row row;
    for (const auto& outcome : outcomes)
      if (static_cast<std::size_t>(outcome.kind) == kind) row.add(outcome), all.add(outcome);
    if (row.captures > 0) line(kKinds[kind], row);
  }
  line("all", all);
}

void print_errors(const std::vector<Outcome>& outcomes) {
  fmt::print(
      "\n| background | below the probe | captures | ok | rms of error / standard error | beyond 3 | largest "
      "|\n");
  fmt::print("|---|---|---|---|---|---|---|\n");
  for (int background = 0; background < 4; ++background)
    for (const double low : {0.0, 15.0, 30.0, 45.0}) {
      Row row;
      for (const auto& outcome : outcomes)
        if (outcome.kind == Kind::Nothing && static_cast<int>(outcome.background) == background &&
            outcome.below_db >= low && outcome.below_db < low + 15.0)
          row.add(outcome);
      if (row.ok == 0) continue;
      fmt::print("| {} | {:.0f} … {:.0f} dB | {} | {} | {:.2f} | {:.1f} % | {:.1f} |\n",
                 kBackgroundNames[background], low, low + 15.0, row.captures, row.ok,
                 std::sqrt(row.squares / row.ok), 100.0 * row.beyond / row.ok, row.worst);
    }
}

}  // namespace

int captures(int first, int count, bool held_out, const std::string& speech) {
  const Backgrounds sounds{held_out ? Backgrounds::Part::HeldOut : Backgrounds::Part::Chosen, speech};
  if (sounds.music() == 0 || sounds.speech() == 0) {
    fmt::print(stderr,
               "no recorded backgrounds: install sonic-pi-samples, hydrogen-drumkits and espeak-ng\n");
    return 77;
  }
  std::vector<Outcome> outcomes(index(count));
  in_parallel(count, [&](int n) { outcomes[index(n)] = outcome_of(Maker{sounds, first + n}.make()); });
  print_kinds(outcomes);
  print_errors(outcomes);
  const auto bad = std::any_of(outcomes.begin(), outcomes.end(),
                               [](const Outcome& one) { return one.gross || one.silent; });
  return bad ? 1 : 0;
}

}  // namespace tactus::study
