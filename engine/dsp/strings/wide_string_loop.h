#pragma once

// Thread: [realtime]; constructors [control].

#include <array>

#include "engine/dsp/delays/wide_delay_line.h"
#include "engine/dsp/strings/string_loop.h"

namespace tactus {

/// Eight StringLoops side by side, each with its own parameters. The pole of the loss filter runs frame by
/// frame in all lanes at once; against StringLoop the output differs by rounding.
class WideStringLoop {
 public:
  /// [control] Allocates for `lowest_pitch`.
  WideStringLoop(LossFilter filter, Hertz sample_rate, double lowest_pitch);

  /// [realtime] From the next frame on. Does nothing when nothing changed.
  void tune(int lane, const StringParameters& parameters) noexcept;
  void reset() noexcept;
  /// [realtime] Goes on sounding as `other` did.
  void adopt(WideStringLoop& other) noexcept {
    line_.adopt(other.line_);
    if (filter_ == other.filter_) loss_ = other.loss_;
  }

  /// [realtime] `x` gives the Lanes of a frame (`x[n]`, `x.from(n)`), `y` is interleaved.
  template <class Input>
  void run(const Input& x, double* y, int frames) noexcept {
    for (int done = 0; done < frames;) {
      const int count = std::min({frames - done, kLongest, shortest_});
      run_row(x.from(done), y + done * Lanes::kCount, count);
      line_.write(y + done * Lanes::kCount, count);
      done += count;
    }
  }

 private:
  static constexpr std::size_t kTaps = StringDesign::kTaps;
  static constexpr int kLongest = 64;  ///< frames worked on at once
  using Row = std::array<double, Lanes::kCount>;

  void take(int lane, const StringDesign& design) noexcept;

  /// No longer than the newest tap is away.
  template <class Input>
  void run_row(const Input& x, double* y, int frames) noexcept {
    WideDelayLine::Places oldest;
    for (std::size_t lane = 0; lane < oldest.size(); ++lane)
      oldest[lane] = line_.behind(static_cast<int>(lane), newest_[lane] + static_cast<int>(kTaps) - 1);
    std::array<Lanes, kTaps> weights;
    for (std::size_t k = 0; k < kTaps; ++k) weights[k] = Lanes::load(weights_[k].data());
    const auto pole = Lanes::load(pole_.data());
    auto loss = Lanes::load(loss_.data());
    WideTaps<kTaps> taps{oldest};
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
  WideDelayLine line_;
};

}  // namespace tactus
