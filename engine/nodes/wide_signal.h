#pragma once

// Thread: [realtime].

#include "engine/dsp/simd/lanes.h"
#include "engine/graph/node.h"

namespace tactus {

static_assert(kVectorWidth == Lanes::kCount);

/// An input of a wide node, whose stride says what it is (see Node::vectorised).
class WideSignal {
 public:
  explicit WideSignal(const Signal& signal) noexcept : data_(signal.data), stride_(signal.stride) {}

  /// All lanes of a frame.
  Lanes operator[](int frame) const noexcept {
    const double* const at = data_ + frame * stride_;
    return stride_ == 1 ? Lanes::broadcast(*at) : Lanes::load(at);
  }
  double lane(int lane, int frame) const noexcept {
    return data_[frame * stride_ + (stride_ == 1 ? 0 : lane)];
  }
  bool constant() const noexcept { return stride_ == 0; }
  /// From a later frame on.
  WideSignal from(int frame) const noexcept { return WideSignal{{data_ + frame * stride_, stride_}}; }

 private:
  const double* data_;
  std::ptrdiff_t stride_;
};

}  // namespace tactus
