#include "engine/runtime/step_times.h"

#include <algorithm>
#include <chrono>

#include "engine/core/channels.h"
#include "engine/core/median.h"

namespace tactus {

StepTimes::StepTimes(Player& player, int every) : player_(player), every_(std::max(1, every)) { start(); }

void StepTimes::start() {
  plan_ = &player_.plan();
  blocks_ = 0;
  before_ = player_.step_nanoseconds();
  taken_.assign(before_.size(), {});
  player_.time_steps(true);
}

void StepTimes::add(int frames) {
  if (&player_.plan() != plan_) return start();
  if (blocks_++ % every_ == 0) {
    const auto& now = player_.step_nanoseconds();
    for (std::size_t s = 0; s < now.size(); ++s)
      taken_[s].push_back(std::max(0.0, now[s] - before_[s]) / frames);
    before_ = now;
  }
  player_.time_steps(blocks_ % every_ == 0);
}

std::vector<double> StepTimes::ns_per_frame() const {
  std::vector<double> medians;
  if (taken_.empty() || taken_.front().empty()) return medians;
  for (const auto& times : taken_) medians.push_back(median(times));
  return medians;
}

void repeat_block(Seconds duration, const std::function<void()>& run_block) {
  constexpr int kMostBlocks = 3000;
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>{duration.value};
  const NoDenormals no_denormals;
  int blocks = 0;
  do run_block();
  while (++blocks < kMostBlocks && Clock::now() < end);
}

std::vector<double> time_steps(Player& player, int block, Seconds duration) {
  const ChannelBuffers in{player.in_channels(), block}, out{player.out_channels(), block};
  for (double* channel : in) std::fill_n(channel, block, 1e-3);
  player.process({in.data(), out.data(), block});  // what is called for the first time is slow
  StepTimes times{player};
  repeat_block(duration, [&] {
    player.process({in.data(), out.data(), block});
    times.add(block);
  });
  return times.ns_per_frame();
}

}  // namespace tactus
