#pragma once
// Thread: [control] unless stated otherwise

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <vector>

#include "engine/core/index.h"
#include "engine/guard/guarded.h"

namespace tactus::app {

/// The highest sample of each channel since the last look, and another tap behind it.
class LevelMeter final : public BlockTap {
 public:
  LevelMeter(int inputs, int outputs) : inputs_(index(inputs)), outputs_(index(outputs)) {}

  /// [control & stopped] It observes everything too, and outlives this or is removed with nullptr.
  void set_next(BlockTap* next) { next_ = next; }

  void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING override {
    if (next_ != nullptr) next_->applied(entry);
  }
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override {
    for (std::size_t c = 0; c < inputs_.size(); ++c) raise(inputs_[c], io.in[c], io.frames);
    for (std::size_t c = 0; c < outputs_.size(); ++c) raise(outputs_[c], io.out[c], io.frames);
    if (next_ != nullptr) next_->observe(io, first_frame);
  }

  /// [control, one thread] Full scale = 1; the next look starts anew.
  std::vector<double> take_inputs() { return take(inputs_); }
  std::vector<double> take_outputs() { return take(outputs_); }

 private:
  using Peaks = std::vector<std::atomic<double>>;

  static void raise(std::atomic<double>& peak, const double* samples, int frames) noexcept {
    double highest = peak.load(std::memory_order_relaxed);
    for (int n = 0; n < frames; ++n) highest = std::max(highest, std::abs(samples[n]));
    peak.store(highest, std::memory_order_relaxed);
  }
  static std::vector<double> take(Peaks& peaks) {
    std::vector<double> levels;
    for (auto& peak : peaks) levels.push_back(peak.exchange(0.0, std::memory_order_relaxed));
    return levels;
  }

  Peaks inputs_, outputs_;
  BlockTap* next_ = nullptr;
};

}  // namespace tactus::app
