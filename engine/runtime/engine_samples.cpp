// How samples come into the engine and go out.
#include <algorithm>
#include <array>

#include "engine/core/transpose.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/runtime/engine.h"
#include "engine/runtime/operations.h"

namespace tactus {

void Engine::load_inputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept {
  for (std::size_t c = 0; c < plan_->input_buffers.size(); ++c) {
    double* buffer = plan_->input_buffers[c];
    if (buffer == nullptr) continue;
    buffer += piece_offset;
    if (static_cast<int>(c) >= format_.in_channels) {
      std::fill_n(buffer, frames, 0.0);
      continue;
    }
    copy_samples(io.in[c] + block_offset + piece_offset, frames, buffer);
    make_finite(buffer, frames);
  }
}

void Engine::make_finite(double* samples, int frames) noexcept {
  if (!all_finite(samples, frames))
    bad_inputs_.fetch_add(clear_nonfinite(samples, frames), std::memory_order_relaxed);
  // Denormals are 0 to arithmetic, but not to what only copies or chooses: nodes must not see any.
  for (int n = 0; n < frames; ++n)
    samples[n] = std::abs(samples[n]) < std::numeric_limits<double>::min() ? 0.0 : samples[n];
}

void Engine::store_outputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept {
  const auto channels = std::min(static_cast<std::size_t>(format_.out_channels), running_->outputs.size());
  const int to = block_offset + piece_offset;
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& signal = plan_->channels[static_cast<std::size_t>(running_->outputs[c])].signal;
    if (signal.stride == 1) {
      copy_samples(signal.data + piece_offset, frames, io.out[c] + to);
    } else if (running_->side_by_side[c] && c + kWide <= channels) {
      std::array<double*, kWide> rows;
      for (std::size_t lane = 0; lane < kWide; ++lane) rows[lane] = io.out[c + lane] + to;
      Transpose::unpack(signal.data + piece_offset * kWide, rows, frames);
      c += kWide - 1;
    } else {
      for (int n = 0; n < frames; ++n) io.out[c][to + n] = signal[piece_offset + n];
    }
  }
  if (now_ + piece_offset >= fading_until_) return;
  for (std::size_t c = 0; c < channels; ++c) fades_[c].process(io.out[c] + to, frames, now_ + piece_offset);
}

void Engine::answer_outside(const BlockIo& io, int block_offset, int offset, int frames) noexcept {
  if (outside_ == nullptr) return;  // nobody there: the channels were loaded like any others
  for (std::size_t c = 0; c < running_->outputs.size(); ++c) {
    const auto& signal = plan_->channels[static_cast<std::size_t>(running_->outputs[c])].signal;
    double* samples = outside_buffers_[c].data();
    for (int n = 0; n < frames; ++n) samples[n] = signal[offset + n];
    if (now_ + offset < fading_until_) fades_[c].process(samples, frames, now_ + offset);
    if (static_cast<int>(c) < format_.out_channels)
      std::copy_n(samples, frames, io.out[c] + block_offset + offset);
  }
  outside_->process({outside_in_.data(), outside_out_.data(), frames});
  for (std::size_t c = 0; c < plan_->input_buffers.size(); ++c) {
    double* buffer = plan_->input_buffers[c];
    if (buffer == nullptr) continue;
    std::copy_n(outside_out_[c], frames, buffer + offset);
    make_finite(buffer + offset, frames);
  }
}

}  // namespace tactus
