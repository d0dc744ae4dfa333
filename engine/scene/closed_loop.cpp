#include "engine/scene/closed_loop.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"

namespace tactus {

ClosedLoop::ClosedLoop(BlockProcessor& instrument, Player& plant, int instrument_outputs, int delay_frames,
                       Converters converters)
    : instrument_(instrument),
      plant_(plant),
      delay_(delay_frames),
      converters_(converters),
      steps_(std::ldexp(1.0, converters.bits - 1)),
      sensor_count_(plant.out_channels()),
      drive_count_(instrument_outputs),
      ring_(static_cast<std::size_t>(instrument_outputs)) {
  for (const auto& channel : plant.plan().channels)
    if (channel.use != OutputUse::Tap) clips_.push_back(to_string(channel.dimension).empty());
  if (delay_ == 0) plant_.set_outside(*this);
}

bool ClosedLoop::has_units() const { return std::ranges::find(clips_, 0) != clips_.end(); }

Status ClosedLoop::prepare(Hertz sample_rate, int max_block) {
  block_ = std::min(max_block, std::max(1, delay_));
  for (auto* channels : {&sensors_, &unused_}) channels->resize(sensor_count_, block_);
  for (auto* channels : {&drives_, &delayed_}) channels->resize(drive_count_, block_);
  for (auto& ring : ring_) ring.assign(static_cast<std::size_t>(delay_ + block_), 0.0);
  written_ = 0;
  if (auto status = plant_.prepare({sample_rate, drive_count_, sensor_count_, block_}); !status)
    return status;
  return instrument_.prepare({sample_rate, sensor_count_, drive_count_, block_});
}

void ClosedLoop::run(int frames, const Listener& listener) {
  for (int done = 0; done < frames;) {
    const int block = std::min(block_, frames - done);
    run_block(block);
    if (listener) listener({block, sensors_, drives_});
    done += block;
  }
}

void ClosedLoop::run_block(int frames) noexcept {
  const auto run_plant = [&](const ChannelBuffers& sensors) {
    const NoDenormals no_denormals;  // no guard lies around the plant
    plant_.process({delayed_.data(), sensors.data(), frames});
  };
  // With no delay `sensors_` is filled by `process`, converted.
  if (delay_ == 0) return run_plant(unused_);
  for (std::size_t c = 0; c < ring_.size(); ++c) {
    const auto& ring = ring_[c];
    const std::size_t first = written_ + ring.size() - static_cast<std::size_t>(delay_);
    double* const delayed = delayed_[static_cast<int>(c)];
    for (int n = 0; n < frames; ++n) delayed[n] = ring[(first + static_cast<std::size_t>(n)) % ring.size()];
  }
  run_plant(sensors_);
  answer(frames);
  for (std::size_t c = 0; c < ring_.size(); ++c)
    for (int n = 0; n < frames; ++n)
      ring_[c][(written_ + static_cast<std::size_t>(n)) % ring_[c].size()] = drives_[static_cast<int>(c)][n];
  written_ += static_cast<std::size_t>(frames);
}

void ClosedLoop::process(const BlockIo& io) noexcept {
  for (int c = 0; c < sensors_.size(); ++c) std::copy_n(io.in[c], io.frames, sensors_[c]);
  answer(io.frames);
  for (int c = 0; c < drives_.size(); ++c) std::copy_n(drives_[c], io.frames, io.out[c]);
}

void ClosedLoop::answer(int frames) noexcept {
  for (int c = 0; c < sensors_.size(); ++c) convert(sensors_[c], frames, clips_[index(c)] != 0);
  instrument_.process({sensors_.data(), drives_.data(), frames});
  for (double* const samples : drives_) convert(samples, frames, true);
}

void ClosedLoop::convert(double* samples, int frames, bool clips) const noexcept {
  if (!converters_.on) return;
  for (int n = 0; n < frames; ++n) {
    const double steps = std::nearbyint(samples[n] * steps_);
    samples[n] = (clips ? std::clamp(steps, -steps_, steps_ - 1) : steps) / steps_;
  }
}

}  // namespace tactus
