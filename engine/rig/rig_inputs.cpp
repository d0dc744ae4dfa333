#include "engine/rig/rig_inputs.h"

#include <algorithm>
#include <utility>

namespace tactus {

RigInputs::RigInputs(BlockProcessor& inner, std::vector<double> scales, int padding_frames)
    : inner_(inner), scales_(std::move(scales)), padding_frames_(padding_frames) {}

bool RigInputs::needed(const std::vector<double>& scales, int padding_frames) {
  return padding_frames > 0 ||
         std::any_of(scales.begin(), scales.end(), [](double scale) { return scale != 1.0; });
}

Status RigInputs::prepare(const StreamFormat& format) {
  inputs_.assign(static_cast<std::size_t>(format.in_channels), {});
  in_.resize(format.in_channels, format.max_frames);
  place_ = 0;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    auto& input = inputs_[i];
    if (i < scales_.size()) input.scale = scales_[i];
    input.past.assign(static_cast<std::size_t>(padding_frames_), 0.0);
  }
  return inner_.prepare(format);
}

void RigInputs::process(const BlockIo& io) noexcept {
  for (int i = 0; i < in_.size(); ++i)
    read(inputs_[static_cast<std::size_t>(i)], io.in[i], in_[i], io.frames);
  if (padding_frames_ > 0)
    place_ = (place_ + static_cast<std::size_t>(io.frames)) % static_cast<std::size_t>(padding_frames_);
  inner_.process({in_.data(), io.out, io.frames});
}

void RigInputs::read(Input& input, const double* samples, double* values, int frames) const noexcept {
  for (int f = 0; f < frames; ++f) values[f] = input.scale * samples[f];
  if (input.past.empty()) return;
  auto place = place_;
  for (int f = 0; f < frames; ++f) {
    std::swap(values[f], input.past[place]);
    if (++place == input.past.size()) place = 0;
  }
}

}  // namespace tactus
