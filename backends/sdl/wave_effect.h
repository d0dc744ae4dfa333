#pragma once
// Thread: [any, one thread]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <span>

#include "backends/sdl/effect_timer.h"

namespace tactus {

/// A periodic effect as a device gets it: offset + magnitude w(t / period + phase), of which an envelope
/// rises from 0 in its attack and falls to 0 in its fade, at the end of its length.
struct Wave {
  int magnitude = 0;  ///< 32767 is the full force
  int offset = 0;     ///< mean of the wave, as `magnitude`
  int phase = 0;      ///< [0.01 degrees]
  int period_ms = 10;
  int attack_ms = 0, fade_ms = 0;
  int attack_level = 0;  ///< where the attack begins, as `magnitude`
  int length_ms = static_cast<int>(EffectTimer::kLength.count());

  bool operator==(const Wave&) const = default;
  /// Parts of a USB PID device's report "set periodic" and "set envelope"; the length is of a third one.
  bool same_wave(const Wave& other) const {
    return magnitude == other.magnitude && offset == other.offset && phase == other.phase &&
           period_ms == other.period_ms;
  }
  bool same_envelope(const Wave& other) const {
    return attack_ms == other.attack_ms && fade_ms == other.fade_ms && attack_level == other.attack_level;
  }
};

/// An output that sets a field of a periodic effect: full_scale * level, rounded, from `low` to `high`. At
/// level 0 the field has its default.
struct WaveSetting {
  const char* name;
  int Wave::*field;
  double full_scale;
  int low, high;
};

/// In the order of the outputs. An effect is started again after at least 200 ms, and ends by itself after
/// 500 ms: a whole number of periods has to fit between, and the attack into the first of them.
inline constexpr std::array<WaveSetting, 5> kWaveSettings{{{"period", &Wave::period_ms, 1000, 1, 200},
                                                           {"offset", &Wave::offset, 32767, -32767, 32767},
                                                           {"phase", &Wave::phase, 36000, -36000, 36000},
                                                           {"attack", &Wave::attack_ms, 1000, 0, 200},
                                                           {"fade", &Wave::fade_ms, 1000, 0, 200}}};

/// The wave of a strength and of the levels of its settings.
inline Wave wave_of(double strength, std::span<const double> settings) {
  Wave wave;
  wave.magnitude = static_cast<int>(std::lround(32767 * std::min(std::abs(strength), 1.0)));
  for (std::size_t s = 0; s < kWaveSettings.size(); ++s) {
    const auto& setting = kWaveSettings[s];
    const double value = std::round(setting.full_scale * std::clamp(settings[s], -1.0, 1.0));
    if (value != 0) wave.*setting.field = std::clamp(static_cast<int>(value), setting.low, setting.high);
  }
  wave.phase = (wave.phase + 36000) % 36000;
  return wave;
}

/// When a periodic effect is sent, and how. It is started with its attack, and again after a whole number of
/// periods without one; at strength 0 it is stopped, or it is started from where its wave is, for as long as
/// its fade lasts.
class WaveEffect {
 public:
  using Clock = EffectTimer::Clock;

  struct Step {
    bool uploads = false, runs = false, stops = false;
    Wave wave;        ///< that is in the device from now on
    int reports = 0;  ///< of an upload to a USB PID device that has the effect already
  };

  /// See EffectTimer::next; `wanted` is the wave that the outputs ask for.
  Step next(const Wave& wanted, Clock::time_point now, bool allowed) {
    const bool changes = !wanted.same_wave(wanted_) || wanted.attack_ms != wanted_.attack_ms;
    const auto order =
        timer_.next(wanted.magnitude / 32767.0, now, allowed, changes, restart_after(wanted.period_ms));
    if (order == EffectTimer::Order::None) return {};
    if (order == EffectTimer::Order::Stop) return stop(wanted.fade_ms, now);
    wanted_ = wanted;
    auto wave = wanted;
    wave.fade_ms = 0;
    const bool runs = order != EffectTimer::Order::Change;
    if (order != EffectTimer::Order::Start) wave.attack_ms = runs ? 0 : sent_.attack_ms;
    if (runs) started_ = now;
    return send(wave, runs);
  }
  /// The device has none of it: it will be sent as a whole.
  void forget() { sent_.length_ms = 0; }

  /// The shortest whole number of periods of at least EffectTimer::kRestart.
  static std::chrono::milliseconds restart_after(int period_ms) {
    const auto least = static_cast<int>(EffectTimer::kRestart.count());
    return std::chrono::milliseconds{(least + period_ms - 1) / period_ms * period_ms};
  }

 private:
  Step stop(int fade_ms, Clock::time_point now) {
    if (fade_ms == 0 || sent_.length_ms == 0)
      return {.uploads = false, .runs = false, .stops = true, .wave = sent_, .reports = 0};
    auto wave = sent_;
    const auto played = std::chrono::duration_cast<std::chrono::milliseconds>(now - started_).count();
    wave.phase = static_cast<int>((wave.phase + 36000 * (played % wave.period_ms) / wave.period_ms) % 36000);
    wave.attack_ms = 0;
    wave.fade_ms = wave.length_ms = fade_ms;
    return send(wave, true);
  }
  Step send(Wave wave, bool runs) {
    // Linux' driver of USB PID devices does not send an envelope of zeros (hid-pidff.c, since 6.15), so that
    // an attack would stay.
    const bool had_envelope = sent_.attack_ms != 0 || sent_.fade_ms != 0 || sent_.attack_level != 0;
    if (had_envelope && wave.attack_ms == 0) wave.attack_level = 32767;
    const int reports =
        !wave.same_wave(sent_) + !wave.same_envelope(sent_) + (wave.length_ms != sent_.length_ms);
    sent_ = wave;
    return {.uploads = reports > 0, .runs = runs, .stops = false, .wave = wave, .reports = reports};
  }

  EffectTimer timer_;
  Wave wanted_;                ///< that was sent for
  Wave sent_{.length_ms = 0};  ///< in the device; 0: none
  Clock::time_point started_;  ///< with its phase
};

}  // namespace tactus
