#pragma once
// Thread: [realtime] unless stated otherwise

#include <array>
#include <optional>
#include <vector>

#include "engine/core/units.h"

namespace tactus {

/// What came in during one window, without what is slower than 100 Hz.
struct LevelWindow {
  double power = 0.0;
  double peak = 0.0;  ///< of the input as it is
};

/// What has been found out about a path before it is measured.
struct PathLevel {
  double level = 0.0;            ///< to play at; full scale = 1
  std::optional<Seconds> delay;  ///< within two windows; nothing: it was not captured
  double noise_power = 0.0;      ///< per sample

  /// Nothing was captured, and the noise would hide what is played at `level` even if all of it came back.
  bool hidden_by_noise() const noexcept;
};

/// Has the sound gone when nothing more is played? Fed with the windows after the output was muted.
class RingOutMonitor {
 public:
  enum class Result { Nothing, Feedback, Quiet };

  /// [any] Before `outstanding` is over, what was played is still on its way.
  explicit RingOutMonitor(Seconds outstanding = Seconds{0.0});
  /// [realtime]
  Result observe(const LevelWindow& window) noexcept;

 private:
  int outstanding_;
  int windows_ = 0, loud_ = 0, quiet_ = 0;
};

/// Finds the level at which a path is measured: the noise is captured first, then short probes ("level
/// probes") that become louder by 6 dB each, until one is captured 30 dB above the noise, or near the input's
/// end, or as loud as allowed. How long a level probe takes to come back is not known, and may be seconds, so
/// it goes on when none is captured after 150 ms; once everything has come back, each is found by the pattern
/// of their loudness, and the softest that does is taken. If none was captured, `softest` is taken: that is
/// enough to find the sound on another input. It decides by what it captured, window by window, and never by
/// a clock.
class LevelSearch {
 public:
  static constexpr Seconds kWindow{0.01};
  static constexpr int kLevelProbeWindows = 4;
  static constexpr Seconds kLongestDelay{5.0};
  static constexpr double kTooLoud = 0.7079;  ///< of the input's full scale: -3 dB
  static constexpr std::size_t kMaxLevelProbes = 24;
  static constexpr double kLoudEnough = 0.5;  ///< what is played may come back up to that

  struct Settings {
    double softest = 0.0, loudest = 0.0;  ///< full scale = 1
    Seconds quiet{0.0};                   ///< before the first level probe, at least
    std::optional<PathLevel> known;       ///< of an earlier opening: one level probe must do
  };
  enum class Step {
    Wait,
    Probe,    ///< begins with the next window, at `level`
    Ready,    ///< `found`
    TooLoud,  ///< the softest level probe already was
    Feedback,
  };

  /// [control] Allocates.
  explicit LevelSearch(const Settings& settings);

  /// [realtime] What the next window is for.
  Step observe(const LevelWindow& window) noexcept;
  /// [realtime] The input came to its end, and what was being played has been muted. Goes on with what is
  /// captured.
  void overload() noexcept;

  bool was_overloaded() const noexcept { return stage_ == Stage::Overloaded; }
  double level() const noexcept { return probes_[probe_count_ - 1].level; }
  const PathLevel& found() const noexcept { return found_; }
  /// [any] Windows after which it has answered, whatever is captured.
  int max_windows() const noexcept { return max_windows_; }

 private:
  enum class Stage { Quiet, Probing, Echoes, Overloaded };
  struct Probe {
    int window = 0;
    double level = 0.0;
  };

  Step start_probe(double level) noexcept;
  Step after_quiet() noexcept;
  Step after_probe() noexcept;
  Step after_echoes() noexcept;
  Step decide() noexcept;
  int best_lag() const noexcept;
  double power_at(int window) const noexcept;
  double peak_at(int window) const noexcept;
  double noise() noexcept;
  int now() const noexcept { return static_cast<int>(windows_.size()); }

  Settings settings_;
  int max_windows_;
  Stage stage_ = Stage::Quiet;
  std::vector<LevelWindow> windows_;
  std::vector<double> sorted_;
  std::array<Probe, kMaxLevelProbes> probes_{};
  std::size_t probe_count_ = 0;
  int last_above_noise_ = 0;  ///< window that stood out of the noise
  RingOutMonitor ring_out_;
  PathLevel found_;
};

}  // namespace tactus
