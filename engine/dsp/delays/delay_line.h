#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

#include "engine/dsp/delays/taps_kernel.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// The memory of a `tactus_line`: up to `longest_run` samples in a row never wrap.
class DelayLine {
 public:
  /// [control] Remembers at least `longest` samples.
  DelayLine(int longest, int longest_run)
      : line_{nullptr, static_cast<int>(std::bit_ceil(static_cast<unsigned>(longest + longest_run))),
              longest_run, 0},
        samples_(static_cast<std::size_t>(line_.capacity + longest_run), 0.0) {
    line_.samples = samples_.data();
  }
  DelayLine(const DelayLine&) = delete;
  /// [realtime] `other` is of the same size.
  DelayLine& operator=(const DelayLine& other) noexcept {
    samples_ = other.samples_;
    line_ = other.line_;
    line_.samples = samples_.data();
    return *this;
  }

  /// [realtime]
  void reset() noexcept { std::fill(samples_.begin(), samples_.end(), 0.0); }

  /// [realtime] At most `longest_run` samples.
  void write(const double* x, int count) noexcept {
    while (count > 0) {
      const int run = std::min(count, line_.capacity - line_.next);
      copy_samples(x, run, line_.samples + line_.next);
      if (line_.next < line_.mirrored)
        copy_samples(x, std::min(run, line_.mirrored - line_.next),
                     line_.samples + line_.capacity + line_.next);
      line_.next = (line_.next + run) & (line_.capacity - 1);
      x += run;
      count -= run;
    }
  }

  /// [realtime] Remembers what `other` did, as far as there is room; about a nanosecond a sample, a tenth of
  /// that if both are of the same size.
  void adopt(const DelayLine& other) noexcept {
    if (line_.capacity == other.line_.capacity && line_.mirrored == other.line_.mirrored) {
      *this = other;
      return;
    }
    for (int back = std::min(line_.capacity, other.line_.capacity); back > 0; --back)
      tactus_line_write(&line_, *other.tap(back));
  }

  /// [realtime] See `tactus_line_tap`.
  const double* tap(int back, int older = 0) const noexcept { return tactus_line_tap(&line_, back, older); }
  /// [realtime] For kernels.
  tactus_line* line() noexcept { return &line_; }

 private:
  tactus_line line_;
  std::vector<double> samples_;
};

}  // namespace tactus
