#pragma once

#include <algorithm>

#include "engine/core/block_io.h"
#include "engine/core/error.h"

namespace tactus::test {

/// Outputs full scale on every channel.
class FullScale final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override {
    outputs_ = format.out_channels;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < outputs_; ++c) std::fill_n(io.out[c], io.frames, 1.0);
  }

 private:
  int outputs_ = 0;
};

}  // namespace tactus::test
