#pragma once

// Thread: [realtime]; constructors [control].

#include <algorithm>
#include <array>
#include <complex>

#include "engine/core/units.h"
#include "engine/dsp/delays/delay_line.h"
#include "engine/dsp/delays/taps.h"
#include "engine/dsp/filters/recurrence.h"
#include "engine/dsp/strings/string_kernel.h"

namespace tactus {

enum class LossFilter { OneZero, OnePole };

/// Parameters of a string. Out of range is clamped: pitch to [10 Hz, 0.3 fs], gain to [0, 0.9999] (on a
/// loop), loss to [0, 1] (one zero) or [0, 0.99] (one pole).
struct StringParameters {
  double pitch_hz = 220;
  double gain = 0.99;
  double loss = 0.5;
  bool operator==(const StringParameters&) const = default;
};

/// `tactus_string`: its loop, read through taps.
struct StringDesign : tactus_string_design {
  static constexpr int kTaps = TACTUS_STRING_TAPS;

  StringDesign() = default;
  StringDesign(const StringParameters& p, LossFilter filter, Hertz sample_rate)
      : StringDesign(tactus_string({filter == LossFilter::OnePole, 0.9999, 0}, p.pitch_hz, p.gain, p.loss,
                                   sample_rate.value)) {}
  explicit StringDesign(const tactus_string_design& design) : tactus_string_design(design) {}
  /// Once around the loop, at any z^-1: the string rings where this is 1.
  std::complex<double> loop(std::complex<double> delay) const {
    std::complex<double> sum = 0;
    for (std::size_t k = kTaps; k-- > 0;) sum = sum * delay + taps[k];
    return std::pow(delay, newest) * sum / (1.0 - pole * delay);
  }
  /// From x to y, at any z^-1.
  std::complex<double> response(std::complex<double> delay) const { return 1.0 / (1.0 - loop(delay)); }
};

/// What a string and one end of a waveguide have in common: a line that is read through a design.
class DesignedLine {
 public:
  void reset() noexcept {
    line_.reset();
    losses_.reset();
  }
  /// [realtime] Continues from the state of `other`.
  void adopt(const DesignedLine& other) noexcept {
    line_.adopt(other.line_);
    if (filter_ == other.filter_) losses_.adopt(other.losses_);
  }

 protected:
  DesignedLine(LossFilter filter, int longest)
      : filter_(filter), line_(longest, kMostFrames + StringDesign::kTaps) {}
  /// Whether the parameters are new.
  bool changed(const StringParameters& parameters) noexcept {
    if (parameters == parameters_) return false;
    parameters_ = parameters;
    return true;
  }
  void set(const StringDesign& design) noexcept {
    design_ = design;
    losses_.design(&design_.pole);
  }
  /// Where the newest tap lies, `written` frames before the last that was written.
  const double* newest_tap(int written = 0) const noexcept {
    return line_.tap(design_.newest + written, StringDesign::kTaps - 1);
  }

  static constexpr int kMostFrames = 64;  ///< written or read at once

  LossFilter filter_;
  StringParameters parameters_;
  StringDesign design_;
  DelayLine line_;
  Recurrence<1> losses_;
};

class StringLoop : public DesignedLine {
 public:
  /// [control] Allocates for `lowest_pitch`, below which it is never tuned.
  StringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch = kLowestPitch);

  /// [realtime] At the start of a group only (see Recurrence). Does nothing when nothing changed.
  void tune(const StringParameters& parameters, int lane = 0) noexcept;
  /// [realtime] `position` is the group_position of the first frame; `x` and `y` do not overlap.
  void run(const double* x, double* y, int frames, int position) noexcept;
  /// [realtime] `run` for one frame.
  double run_single(double x, int position) noexcept;

  static constexpr double kLowestPitch = 10, kHighestPitch = 20000;
  /// Frames that a string of this pitch remembers.
  static int longest_delay(Hertz sample_rate, double lowest_pitch);

 private:
  int sub_block(int frames, int position) const noexcept;

  Hertz sample_rate_;
};

/// Termination of the far end of a line. Waves of force come back from a fixed end as they went, from a free
/// end upside down.
enum class FarEnd { Fixed, Free };

/// `tactus_waveguide_step` for many frames.
class WaveLine : public DesignedLine {
 public:
  /// The range of its pitch.
  struct Pitches {
    double lowest, highest;
  };
  using DesignedLine::kMostFrames;

  /// [control] Allocates for the lowest pitch.
  WaveLine(LossFilter filter, FarEnd end, Hertz sample_rate, Pitches pitches)
      : WaveLine(filter,
                 tactus_waveguide_between(pitches.lowest, pitches.highest, filter == LossFilter::OnePole,
                                          end == FarEnd::Fixed, sample_rate.value)) {}

  /// [realtime] At the start of a group only (see Recurrence). Does nothing when nothing changed.
  void tune(const StringParameters& parameters) noexcept {
    if (changed(parameters)) set(designed(parameters));
  }
  /// [realtime] What goes in.
  void write(const double* in, int frames) noexcept { line_.write(in, frames); }
  /// [realtime] What comes back, beginning `written` frames before the last that was written. `position` is
  /// the group_position of the first frame. Not before the line's delay: frames - written <= least_delay().
  void read(double* out, int frames, int written, int position) noexcept {
    tap_sums<StringDesign::kTaps>(newest_tap(written), design_.taps, nullptr, out, frames);
    if (filter_ == LossFilter::OnePole) losses_.run(out, out, frames, position);
  }
  int least_delay() const noexcept { return guide_.least; }
  int most_delay() const noexcept { return guide_.most; }
  /// [any] out / in at any z^-1.
  std::complex<double> response(const StringParameters& parameters, std::complex<double> delay) const {
    return designed(parameters).loop(delay);
  }

 private:
  WaveLine(LossFilter filter, const tactus_waveguide& guide)
      : DesignedLine(filter, guide.most + kMostFrames + StringDesign::kTaps), guide_(guide) {
    set(designed(parameters_));
  }
  StringDesign designed(const StringParameters& p) const {
    return StringDesign{tactus_waveguide_design(&guide_, p.pitch_hz, p.gain, p.loss)};
  }

  tactus_waveguide guide_;
};

/// Eight StringLoops in vector registers, each with its own parameters. The pole of the loss filter runs
/// frame by frame in all lanes at once; against StringLoop the output differs by rounding.
class VectorStringLoop {
 public:
  /// [control] Allocates for `lowest_pitch`.
  VectorStringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch);

  /// [realtime] From the next frame on. Does nothing when nothing changed.
  void tune(const StringParameters& parameters, int lane) noexcept;
  void reset() noexcept;
  /// [realtime] Continues from the state of `other`.
  void adopt(const VectorStringLoop& other) noexcept {
    line_.adopt(other.line_);
    if (filter_ == other.filter_) loss_ = other.loss_;
  }

  /// [realtime] `x` gives the Lanes of a frame (`x[n]`, `x + n`), `y` is interleaved.
  template <class Input>
  void run(const Input& x, double* y, int frames, int /*position*/) noexcept {
    for (int done = 0; done < frames;) {
      const int count = std::min({frames - done, kMostFrames, shortest_});
      run_frames(x + done, y + done * Lanes::kCount, count);
      line_.write(y + done * Lanes::kCount, count * Lanes::kCount);
      done += count;
    }
  }

 private:
  static constexpr std::size_t kTaps = StringDesign::kTaps;
  static constexpr int kMostFrames = 64;  ///< frames worked on at once
  using Row = std::array<double, Lanes::kCount>;

  void take(int lane, const StringDesign& design) noexcept;

  /// No longer than the newest tap is away.
  template <class Input>
  void run_frames(const Input& x, double* y, int frames) noexcept {
    LanePlaces oldest;
    for (std::size_t lane = 0; lane < oldest.size(); ++lane)
      oldest[lane] = line_.tap((newest_[lane] + static_cast<int>(kTaps) - 1) * Lanes::kCount) + lane;
    std::array<Lanes, kTaps> weights;
    for (std::size_t k = 0; k < kTaps; ++k) weights[k] = Lanes::load(weights_[k].data());
    const auto pole = Lanes::load(pole_.data());
    auto loss = Lanes::load(loss_.data());
    VectorTaps<kTaps> taps{oldest};
    for (int n = 0; n < frames; ++n, y += Lanes::kCount) {
      taps.next(oldest, n);
      if (filter_ == LossFilter::OneZero) {
        taps.sum(weights, x[n]).store(y);
      } else {
        loss = fused_multiply_add(pole, loss, taps.sum(weights, Lanes::broadcast(0)));
        (x[n] + loss).store(y);
      }
    }
    loss.store(loss_.data());
  }

  LossFilter filter_;
  Hertz sample_rate_;
  std::array<StringParameters, Lanes::kCount> parameters_{};
  std::array<int, Lanes::kCount> newest_{};
  int shortest_ = 0;  ///< of the newest taps
  alignas(64) std::array<Row, kTaps> weights_{};
  alignas(64) Row pole_{};
  alignas(64) Row loss_{};  ///< last output of the pole
  DelayLine line_;          ///< interleaved
};

}  // namespace tactus
