#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <algorithm>
#include <memory>
#include <vector>

#include "engine/dsp/delays/wide_delay_line.h"
#include "engine/nodes/delays/delay_taps.h"
#include "engine/nodes/wide_signal.h"

namespace tactus {

/// Eight DelayNodes side by side. Gives the same bits as they do.
template <int Order>
class WideDelayNode final : public Node {
 public:
  using AllTaps = std::vector<DelayTaps<Order>>;

  /// What lanes that are not `used` refuse is not counted.
  WideDelayNode(AllTaps taps, const std::array<bool, kVectorWidth>& used)
      : taps_(std::move(taps)), used_(used), line_(longest(taps_) + kMaxSubBlock, kMaxSubBlock + Order) {
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) aim(lane, taps_[lane].range().low_s);
  }

  void process(const NodeBlock& block) noexcept override {
    absorb(block);
    read(block, block.frames);
  }
  void emit(const NodeBlock& block) noexcept override { read(block, 0); }
  void absorb(const NodeBlock& block) noexcept override {
    if (block.in[0].stride == kVectorWidth) return line_.write(block.in[0].data, block.frames);
    const WideSignal x{block.in[0]};
    std::array<double, kVectorWidth> frame;
    for (int n = 0; n < block.frames; ++n) {
      x[n].store(frame.data());
      line_.write(frame.data(), 1);
    }
  }
  void adopt(Node& before) noexcept override {
    if (auto* other = dynamic_cast<WideDelayNode*>(&before)) line_.adopt(other->line_);
  }
  void reset() noexcept override {
    line_.reset();
    clamped_ = 0;
  }

  DelayRange delay(int input, int) const override {
    if (input != 0) return {};
    DelayRange all = taps_[0].delay();
    for (const auto& taps : taps_)
      all = {std::min(all.least, taps.delay().least), std::max(all.most, taps.delay().most)};
    return all;
  }

  std::int64_t clamped() const override { return clamped_; }

 private:
  static int longest(const AllTaps& all) {
    int frames = 0;
    for (const auto& taps : all) frames = std::max(frames, taps.longest());
    return frames;
  }

  void aim(std::size_t lane, double seconds) noexcept {
    const auto aim = taps_[lane].at(seconds);
    aimed_at_[lane] = seconds;
    newest_[lane] = aim.newest;
    for (std::size_t k = 0; k <= Order; ++k) weights_[k][lane] = aim.weights[k];
  }

  void aim_all(const WideSignal& time, int frame, int frames) noexcept {
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane) {
      const double asked = time.lane(static_cast<int>(lane), frame);
      const double seconds = taps_[lane].inside(asked);
      if (seconds != asked && used_[lane]) clamped_ += frames;
      if (seconds != aimed_at_[lane]) aim(lane, seconds);
    }
  }

  /// `written`: how many of the frames to come the line has got already.
  WideDelayLine::Places oldest(int written) const noexcept {
    WideDelayLine::Places places;
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane)
      places[lane] = line_.behind(static_cast<int>(lane), newest_[lane] + Order + written);
    return places;
  }

  std::array<Lanes, Order + 1> weights() const noexcept {
    std::array<Lanes, Order + 1> all;
    for (std::size_t k = 0; k <= Order; ++k) all[k] = Lanes::load(weights_[k].data());
    return all;
  }

  void read(const NodeBlock& block, int written) noexcept {
    const WideSignal time{block.in[1]};
    double* const y = block.out[0];
    if (time.constant()) {
      aim_all(time, 0, block.frames);
      return read_row(y, block.frames, written);
    }
    for (int n = 0; n < block.frames; ++n) {
      aim_all(time, n, 1);
      read_row(y + n * kVectorWidth, 1, written - n);
    }
  }

  void read_row(double* y, int frames, int written) noexcept {
    const auto places = oldest(written);
    const auto weight = weights();
    WideTaps<Order + 1> taps{places};
    for (int n = 0; n < frames; ++n, y += kVectorWidth) {
      taps.next(places, n);
      (Order == 0 ? taps.newest() : taps.sum(weight, Lanes::broadcast(0))).store(y);
    }
  }

  AllTaps taps_;
  std::array<bool, kVectorWidth> used_;
  std::array<double, kVectorWidth> aimed_at_{};
  std::array<int, kVectorWidth> newest_{};
  alignas(64) std::array<std::array<double, kVectorWidth>, Order + 1> weights_{};
  WideDelayLine line_;
  std::int64_t clamped_ = 0;
};

}  // namespace tactus
