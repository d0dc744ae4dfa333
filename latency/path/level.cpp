#include "latency/path/level.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr int windows_in(Seconds time) {
  return static_cast<int>(time / LevelSearch::kWindow + 0.999);  // whole ones
}

constexpr double kStep = 2.0;            // from one level probe to the next
constexpr double kEnough = 1000.0;       // power over that of the noise: 30 dB
constexpr double kStandsOut = 10.0;      // the same for being captured at all
constexpr double kLeastNoise = 1e-10;    // power; a converter of 16 bits has no less in motion
constexpr Seconds kLevelPatience{0.15};  // for a level probe to come back
constexpr Seconds kGone{0.25};           // longer than the pause between two level probes
constexpr Seconds kSettling{0.1};        // inputs drift when a stream begins
constexpr Seconds kLevelShortestQuiet{0.4}, kShortQuiet{0.25};
constexpr double kFeedbackPower = 0.01;  // 17 dB under a sine at full scale
constexpr Seconds kFeedbackTime{0.3};

int quiet_windows(const LevelSearch::Settings& settings) {
  return windows_in(std::max(settings.known ? kShortQuiet : kLevelShortestQuiet, settings.quiet));
}

int probes_in(const LevelSearch::Settings& settings) {
  const double steps = std::log2(std::max(1.0, settings.loudest / settings.softest));
  return std::min(static_cast<int>(LevelSearch::kMaxLevelProbes), static_cast<int>(std::ceil(steps)) + 1);
}

constexpr int kPeriod = LevelSearch::kLevelProbeWindows + windows_in(kLevelPatience);

}  // namespace

bool PathLevel::hidden_by_noise() const noexcept {
  return !delay && level * level / 2.0 < kStandsOut * noise_power;
}

RingOutMonitor::RingOutMonitor(Seconds outstanding) : outstanding_(windows_in(outstanding)) {}

RingOutMonitor::Result RingOutMonitor::observe(const LevelWindow& window) noexcept {
  if (++windows_ <= outstanding_) return Result::Nothing;
  const bool loud = window.power > kFeedbackPower;
  loud_ = loud ? loud_ + 1 : 0;
  quiet_ = loud ? 0 : quiet_ + 1;
  if (loud_ >= windows_in(kFeedbackTime) || windows_ - outstanding_ > windows_in(LevelSearch::kLongestDelay))
    return Result::Feedback;
  return quiet_ >= windows_in(kGone) ? Result::Quiet : Result::Nothing;
}

LevelSearch::LevelSearch(const Settings& settings)
    : settings_(settings),
      max_windows_(quiet_windows(settings) + probes_in(settings) * kPeriod + 2 * windows_in(kLongestDelay) +
                   windows_in(kGone)) {
  windows_.reserve(index(max_windows_));
  sorted_.reserve(index(quiet_windows(settings)));
}

LevelSearch::Step LevelSearch::observe(const LevelWindow& window) noexcept {
  if (now() == max_windows_) return decide();
  windows_.push_back(window);
  if (window.power > kStandsOut * found_.noise_power) last_above_noise_ = now();
  switch (stage_) {
    case Stage::Quiet:
      return after_quiet();
    case Stage::Probing:
      return after_probe();
    case Stage::Echoes:
      return after_echoes();
    case Stage::Overloaded:
      break;
  }
  const auto result = ring_out_.observe(window);
  if (result == RingOutMonitor::Result::Feedback) return Step::Feedback;
  return result == RingOutMonitor::Result::Quiet ? decide() : Step::Wait;
}

void LevelSearch::overload() noexcept {
  if (stage_ == Stage::Overloaded) return;
  stage_ = Stage::Overloaded;
  ring_out_ = RingOutMonitor{};
}

LevelSearch::Step LevelSearch::start_probe(double level) noexcept {
  probes_[probe_count_++] = {now(), std::min(level, settings_.loudest)};
  stage_ = Stage::Probing;
  return Step::Probe;
}

LevelSearch::Step LevelSearch::after_quiet() noexcept {
  if (now() < quiet_windows(settings_)) return Step::Wait;
  found_.noise_power = settings_.known ? settings_.known->noise_power : noise();
  return start_probe(settings_.known ? settings_.known->level : settings_.softest);
}

LevelSearch::Step LevelSearch::after_probe() noexcept {
  const Probe& last = probes_[probe_count_ - 1];
  const int since = now() - last.window;
  if (since < kPeriod) return Step::Wait;
  if (settings_.known) {
    found_ = *settings_.known;
    return Step::Ready;
  }
  double power = 0.0, peak = 0.0;
  for (int w = last.window; w < now() - kLevelProbeWindows; ++w) {
    power = std::max(power, power_at(w));
    peak = std::max(peak, peak_at(w));
  }
  const bool louder = last.level < settings_.loudest && probe_count_ < kMaxLevelProbes;
  if (louder && power < kEnough * found_.noise_power && kStep * peak <= kLoudEnough)
    return start_probe(kStep * last.level);
  stage_ = Stage::Echoes;
  return Step::Wait;
}

/// Everything has come back when nothing came for longer than the pause between two level probes.
LevelSearch::Step LevelSearch::after_echoes() noexcept {
  const int first = probes_[0].window, last = probes_[probe_count_ - 1].window;
  const int since = now() - last - kLevelProbeWindows;
  const bool captured = last_above_noise_ > first;
  const bool gone = captured && now() - last_above_noise_ >= windows_in(kGone) && since >= windows_in(kGone);
  return gone || since >= windows_in(kLongestDelay) ? decide() : Step::Wait;
}

/// Which of the level probes is loud enough to be captured, and soft enough for the input?
LevelSearch::Step LevelSearch::decide() noexcept {
  if (probe_count_ == 0) return Step::TooLoud;
  const int lag = best_lag();
  const Probe& last = probes_[probe_count_ - 1];
  if (power_at(last.window + lag) < kStandsOut * found_.noise_power) {
    // Nobody knows where the sound goes: what else is played stays soft.
    found_.level = probes_[0].level;
    return Step::Ready;
  }
  found_.delay = kWindow * lag;
  const double softest_peak = peak_at(probes_[0].window + lag);
  found_.level = probes_[0].level;
  if (softest_peak > kTooLoud) return Step::TooLoud;
  for (std::size_t k = 0; k < probe_count_; ++k) {
    const int at = probes_[k].window + lag;
    if (peak_at(at) > kLoudEnough) break;
    found_.level = probes_[k].level;
    if (power_at(at) >= kEnough * found_.noise_power) break;
  }
  return Step::Ready;
}

/// Where what was captured is most like what was played.
int LevelSearch::best_lag() const noexcept {
  const int most = now() - probes_[probe_count_ - 1].window - kLevelProbeWindows;
  int best = 0;
  double best_match = -1.0;
  for (int lag = 0; lag <= most; ++lag) {
    double match = 0.0;
    for (std::size_t k = 0; k < probe_count_; ++k)
      match += probes_[k].level * probes_[k].level * power_at(probes_[k].window + lag);
    if (match <= best_match) continue;
    best_match = match;
    best = lag;
  }
  return best;
}

/// Mean over as many windows as a level probe lasts.
double LevelSearch::power_at(int window) const noexcept {
  double sum = 0.0;
  for (int w = window; w < std::min(window + kLevelProbeWindows, now()); ++w) sum += windows_[index(w)].power;
  return sum / kLevelProbeWindows;
}

double LevelSearch::peak_at(int window) const noexcept {
  double peak = 0.0;
  for (int w = std::max(0, window - 1); w < std::min(window + kLevelProbeWindows + 1, now()); ++w)
    peak = std::max(peak, windows_[index(w)].peak);
  return peak;
}

/// The median: a click in the silence is no noise.
double LevelSearch::noise() noexcept {
  const auto from = index(std::min(windows_in(kSettling), now() - 1));
  sorted_.clear();
  for (std::size_t w = from; w < windows_.size(); ++w) sorted_.push_back(windows_[w].power);
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return std::max(kLeastNoise, *middle);
}

}  // namespace tactus
