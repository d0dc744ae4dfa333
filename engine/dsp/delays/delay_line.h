#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>
#include <vector>

#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// The last samples of a signal, contiguous: the first ones of the ring stand behind its end once
/// more, so that up to `longest_run` samples never wrap.
class DelayLine {
 public:
  /// [control] Remembers at least `longest` samples.
  DelayLine(int longest, int longest_run)
      : capacity_(std::bit_ceil(static_cast<std::size_t>(longest + longest_run))),
        mirrored_(static_cast<std::size_t>(longest_run)),
        samples_(capacity_ + mirrored_, 0.0) {}

  /// [realtime]
  void reset() noexcept { std::fill(samples_.begin(), samples_.end(), 0.0); }

  /// [realtime] At most `longest_run` samples.
  void write(const double* x, int count) noexcept {
    while (count > 0) {
      const int run = std::min(count, static_cast<int>(capacity_ - next_));
      copy_samples(x, run, samples_.data() + next_);
      if (next_ < mirrored_)
        copy_samples(x, std::min(run, static_cast<int>(mirrored_ - next_)),
                     samples_.data() + capacity_ + next_);
      next_ = (next_ + static_cast<std::size_t>(run)) & (capacity_ - 1);
      x += run;
      count -= run;
    }
  }

  /// [realtime] Remembers what `other` did, as far as there is room: the memory itself changes hands if it
  /// fits, else it takes about a nanosecond a sample.
  void adopt(DelayLine& other) noexcept {
    if (capacity_ == other.capacity_ && mirrored_ == other.mirrored_) {
      samples_.swap(other.samples_);
      std::swap(next_, other.next_);
      return;
    }
    for (auto back = std::min(capacity_, other.capacity_); back > 0; --back)
      put(*other.behind(static_cast<int>(back)));
  }

  /// [realtime] Points at the sample written `back` ago (1: the last one); later ones follow it.
  const double* behind(int back) const noexcept {
    return samples_.data() + ((next_ - static_cast<std::size_t>(back)) & (capacity_ - 1));
  }

 private:
  void put(double x) noexcept {
    samples_[next_] = x;
    if (next_ < mirrored_) samples_[capacity_ + next_] = x;
    next_ = (next_ + 1) & (capacity_ - 1);
  }

  std::size_t capacity_, mirrored_;
  std::vector<double> samples_;
  std::size_t next_ = 0;
};

}  // namespace tactus
