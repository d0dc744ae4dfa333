#include "latency/path/level.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

constexpr int windows_in(Seconds time) {
  return static_cast<int>(time / LevelSearch::kWindow + 0.999);  // whole ones
}

constexpr double kStep = 2.0;            // from one knock to the next
constexpr double kEnough = 1000.0;       // power over that of the noise: 30 dB
constexpr double kStandsOut = 10.0;      // the same for being heard at all
constexpr double kLeastNoise = 1e-10;    // power; a converter of 16 bits has no less in motion
constexpr Seconds kLevelPatience{0.15};  // for a knock to come back
constexpr Seconds kGone{0.25};           // longer than the pause between two knocks
constexpr Seconds kSettling{0.1};        // inputs drift when a stream begins
constexpr Seconds kLevelShortestQuiet{0.4}, kShortQuiet{0.25};
constexpr double kHowlPower = 0.01;  // 17 dB under a sine at full scale
constexpr Seconds kHowlTime{0.3};

int quiet_windows(const LevelSearch::Settings& settings) {
  return windows_in(std::max(settings.known ? kShortQuiet : kLevelShortestQuiet, settings.quiet));
}

int knocks_in(const LevelSearch::Settings& settings) {
  const double steps = std::log2(std::max(1.0, settings.loudest / settings.softest));
  return std::min(static_cast<int>(LevelSearch::kMostKnocks), static_cast<int>(std::ceil(steps)) + 1);
}

constexpr int kPeriod = LevelSearch::kKnockWindows + windows_in(kLevelPatience);

}  // namespace

Aftermath::Aftermath(Seconds outstanding) : outstanding_(windows_in(outstanding)) {}

Aftermath::Says Aftermath::hear(const LevelWindow& window) noexcept {
  if (++windows_ <= outstanding_) return Says::Nothing;
  const bool loud = window.power > kHowlPower;
  loud_ = loud ? loud_ + 1 : 0;
  quiet_ = loud ? 0 : quiet_ + 1;
  if (loud_ >= windows_in(kHowlTime) || windows_ - outstanding_ > windows_in(LevelSearch::kLongestDelay))
    return Says::Howl;
  return quiet_ >= windows_in(kGone) ? Says::Quiet : Says::Nothing;
}

LevelSearch::LevelSearch(const Settings& settings)
    : settings_(settings),
      most_windows_(quiet_windows(settings) + knocks_in(settings) * kPeriod + 2 * windows_in(kLongestDelay) +
                    windows_in(kGone)) {
  windows_.reserve(static_cast<std::size_t>(most_windows_));
  sorted_.reserve(static_cast<std::size_t>(quiet_windows(settings)));
}

LevelSearch::Step LevelSearch::hear(const LevelWindow& window) noexcept {
  if (now() == most_windows_) return judge();
  windows_.push_back(window);
  if (window.power > kStandsOut * found_.noise_power) last_heard_ = now();
  switch (stage_) {
    case Stage::Quiet:
      return after_quiet();
    case Stage::Knocking:
      return after_knock();
    case Stage::Echoes:
      return after_echoes();
    case Stage::Overloaded:
      break;
  }
  const auto says = aftermath_.hear(window);
  if (says == Aftermath::Says::Howl) return Step::Howl;
  return says == Aftermath::Says::Quiet ? judge() : Step::Listen;
}

void LevelSearch::overload() noexcept {
  if (stage_ == Stage::Overloaded) return;
  stage_ = Stage::Overloaded;
  aftermath_ = Aftermath{};
}

LevelSearch::Step LevelSearch::knock(double level) noexcept {
  knocks_[knock_count_++] = {now(), std::min(level, settings_.loudest)};
  stage_ = Stage::Knocking;
  return Step::Knock;
}

LevelSearch::Step LevelSearch::after_quiet() noexcept {
  if (now() < quiet_windows(settings_)) return Step::Listen;
  found_.noise_power = settings_.known ? settings_.known->noise_power : noise();
  return knock(settings_.known ? settings_.known->level : settings_.softest);
}

LevelSearch::Step LevelSearch::after_knock() noexcept {
  const Knock& last = knocks_[knock_count_ - 1];
  const int since = now() - last.window;
  if (since < kPeriod) return Step::Listen;
  if (settings_.known) {
    found_ = *settings_.known;
    return Step::Ready;
  }
  double power = 0.0, peak = 0.0;
  for (int w = last.window; w < now() - kKnockWindows; ++w) {
    power = std::max(power, power_at(w));
    peak = std::max(peak, peak_at(w));
  }
  const bool louder = last.level < settings_.loudest && knock_count_ < kMostKnocks;
  if (louder && power < kEnough * found_.noise_power && kStep * peak <= kLoudEnough)
    return knock(kStep * last.level);
  stage_ = Stage::Echoes;
  return Step::Listen;
}

/// Everything has come back when nothing came for longer than the pause between two knocks.
LevelSearch::Step LevelSearch::after_echoes() noexcept {
  const int first = knocks_[0].window, last = knocks_[knock_count_ - 1].window;
  const int since = now() - last - kKnockWindows;
  const bool heard = last_heard_ > first;
  const bool gone = heard && now() - last_heard_ >= windows_in(kGone) && since >= windows_in(kGone);
  return gone || since >= windows_in(kLongestDelay) ? judge() : Step::Listen;
}

/// Which of the knocks is loud enough to be heard, and soft enough for the input?
LevelSearch::Step LevelSearch::judge() noexcept {
  if (knock_count_ == 0) return Step::TooLoud;
  const int lag = best_lag();
  const Knock& last = knocks_[knock_count_ - 1];
  if (power_at(last.window + lag) < kStandsOut * found_.noise_power) {
    found_.level = last.level;
    return Step::Ready;
  }
  found_.delay = kWindow * lag;
  const double softest_peak = peak_at(knocks_[0].window + lag);
  found_.level = knocks_[0].level;
  if (softest_peak > kTooLoud) return Step::TooLoud;
  for (std::size_t k = 0; k < knock_count_; ++k) {
    const int at = knocks_[k].window + lag;
    if (peak_at(at) > kLoudEnough) break;
    found_.level = knocks_[k].level;
    if (power_at(at) >= kEnough * found_.noise_power) break;
  }
  return Step::Ready;
}

/// Where what was heard is most like what was played.
int LevelSearch::best_lag() const noexcept {
  const int most = now() - knocks_[knock_count_ - 1].window - kKnockWindows;
  int best = 0;
  double best_match = -1.0;
  for (int lag = 0; lag <= most; ++lag) {
    double match = 0.0;
    for (std::size_t k = 0; k < knock_count_; ++k)
      match += knocks_[k].level * knocks_[k].level * power_at(knocks_[k].window + lag);
    if (match <= best_match) continue;
    best_match = match;
    best = lag;
  }
  return best;
}

/// Mean over as many windows as a knock lasts.
double LevelSearch::power_at(int window) const noexcept {
  double sum = 0.0;
  for (int w = window; w < std::min(window + kKnockWindows, now()); ++w)
    sum += windows_[static_cast<std::size_t>(w)].power;
  return sum / kKnockWindows;
}

double LevelSearch::peak_at(int window) const noexcept {
  double peak = 0.0;
  for (int w = std::max(0, window - 1); w < std::min(window + kKnockWindows + 1, now()); ++w)
    peak = std::max(peak, windows_[static_cast<std::size_t>(w)].peak);
  return peak;
}

/// The median: a click in the silence is no noise.
double LevelSearch::noise() noexcept {
  const auto from = static_cast<std::size_t>(std::min(windows_in(kSettling), now() - 1));
  sorted_.clear();
  for (std::size_t w = from; w < windows_.size(); ++w) sorted_.push_back(windows_[w].power);
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return std::max(kLeastNoise, *middle);
}

}  // namespace tactus
