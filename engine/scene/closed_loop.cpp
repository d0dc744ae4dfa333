#include "engine/scene/closed_loop.h"

#include <algorithm>
#include <cmath>

namespace tactus {

/// With no delay at all the plant runs first and calls the instrument from within its frame.
class ClosedLoop::Answer final : public BlockProcessor {
 public:
  explicit Answer(ClosedLoop& loop) : loop_(loop) {}
  Status prepare(const StreamFormat&) override { return {}; }

  void process(const BlockIo& io) noexcept override {
    for (std::size_t c = 0; c < loop_.sensors_.size(); ++c)
      std::copy_n(io.in[c], io.frames, loop_.sensors_[c].data());
    loop_.answer(io.frames);
    for (std::size_t c = 0; c < loop_.drives_.size(); ++c)
      std::copy_n(loop_.drives_[c].data(), io.frames, io.out[c]);
  }

 private:
  ClosedLoop& loop_;
};

ClosedLoop::ClosedLoop(BlockProcessor& instrument, Player& plant, int instrument_outputs, int delay_frames,
                       Converters converters)
    : instrument_(instrument),
      plant_(plant),
      delay_(delay_frames),
      converters_(converters),
      steps_(std::ldexp(1.0, converters.bits - 1)),
      sensors_(static_cast<std::size_t>(plant.out_channels())),
      drives_(static_cast<std::size_t>(instrument_outputs)),
      delayed_(static_cast<std::size_t>(instrument_outputs)),
      ring_(static_cast<std::size_t>(instrument_outputs)),
      answer_(std::make_unique<Answer>(*this)) {
  if (delay_ == 0) plant_.set_outside(*answer_);
}

ClosedLoop::~ClosedLoop() = default;

Status ClosedLoop::prepare(Hertz sample_rate, int max_block) {
  block_ = std::min(max_block, std::max(1, delay_));
  const auto size = static_cast<std::size_t>(block_);
  sensor_in_.clear();
  sensor_out_.clear();
  drive_view_.clear();
  drive_out_.clear();
  delayed_in_.clear();
  spare_out_.clear();
  for (auto& channel : sensors_) {
    channel.assign(size, 0.0);
    sensor_in_.push_back(channel.data());
    sensor_out_.push_back(channel.data());
  }
  spare_.assign(sensors_.size(), std::vector<double>(size, 0.0));
  for (auto& channel : spare_) spare_out_.push_back(channel.data());
  for (std::size_t c = 0; c < drives_.size(); ++c) {
    drives_[c].assign(size, 0.0);
    delayed_[c].assign(size, 0.0);
    ring_[c].assign(static_cast<std::size_t>(delay_) + size, 0.0);
    drive_view_.push_back(drives_[c].data());
    drive_out_.push_back(drives_[c].data());
    delayed_in_.push_back(delayed_[c].data());
  }
  written_ = 0;
  const auto sensors = static_cast<int>(sensors_.size());
  const auto drives = static_cast<int>(drives_.size());
  if (auto status = plant_.prepare({sample_rate, drives, sensors, block_}); !status) return status;
  return instrument_.prepare({sample_rate, sensors, drives, block_});
}

void ClosedLoop::run(int frames, const Listener& listener) {
  for (int done = 0; done < frames;) {
    const int piece = std::min(block_, frames - done);
    run_piece(piece);
    if (listener) listener({piece, sensor_in_, drive_view_});
    done += piece;
  }
}

void ClosedLoop::run_piece(int frames) noexcept {
  // With no delay `sensors_` is filled on the way, and holds what the converters made of it.
  if (delay_ == 0) return plant_.process({delayed_in_.data(), spare_out_.data(), frames});
  for (std::size_t c = 0; c < ring_.size(); ++c) {
    const auto& ring = ring_[c];
    const std::size_t first = written_ + ring.size() - static_cast<std::size_t>(delay_);
    for (int n = 0; n < frames; ++n)
      delayed_[c][static_cast<std::size_t>(n)] = ring[(first + static_cast<std::size_t>(n)) % ring.size()];
  }
  plant_.process({delayed_in_.data(), sensor_out_.data(), frames});
  answer(frames);
  for (std::size_t c = 0; c < ring_.size(); ++c)
    for (int n = 0; n < frames; ++n)
      ring_[c][(written_ + static_cast<std::size_t>(n)) % ring_[c].size()] =
          drives_[c][static_cast<std::size_t>(n)];
  written_ += static_cast<std::size_t>(frames);
}

void ClosedLoop::answer(int frames) noexcept {
  for (auto& channel : sensors_) convert(channel.data(), frames);
  instrument_.process({sensor_in_.data(), drive_out_.data(), frames});
  for (auto& channel : drives_) convert(channel.data(), frames);
}

void ClosedLoop::convert(double* samples, int frames) const noexcept {
  if (!converters_.on) return;
  for (int n = 0; n < frames; ++n)
    samples[n] = std::clamp(std::nearbyint(samples[n] * steps_), -steps_, steps_ - 1) / steps_;
}

}  // namespace tactus
