#include "engine/rig/rig_inputs.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"

namespace tactus {

RigInputs::RigInputs(BlockProcessor& inner, std::vector<double> scales, int padding_frames)
    : inner_(inner), scales_(std::move(scales)), padding_frames_(padding_frames) {}

bool RigInputs::needed(const std::vector<double>& scales, int padding_frames) {
  return padding_frames > 0 ||
         std::any_of(scales.begin(), scales.end(), [](double scale) { return scale != 1.0; });
}

Status RigInputs::prepare(const StreamFormat& format) {
  past_.resize(format.in_channels, padding_frames_);
  in_.resize(format.in_channels, format.max_frames);
  place_ = 0;
  return inner_.prepare(format);
}

void RigInputs::process(const BlockIo& io) noexcept {
  for (int i = 0; i < in_.size(); ++i) {
    const double scale = index(i) < scales_.size() ? scales_[index(i)] : 1.0;
    for (int f = 0; f < io.frames; ++f) in_[i][f] = scale * io.in[i][f];
    for (int f = 0, place = place_; f < io.frames && padding_frames_ > 0; ++f) {
      std::swap(in_[i][f], past_[i][place]);
      if (++place == padding_frames_) place = 0;
    }
  }
  if (padding_frames_ > 0) place_ = (place_ + io.frames) % padding_frames_;
  inner_.process({in_.data(), io.out, io.frames});
}

}  // namespace tactus
