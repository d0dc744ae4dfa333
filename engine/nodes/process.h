#pragma once

// Thread: [realtime].

#include <algorithm>
#include <array>
#include <vector>

#include "engine/dsp/filters/recurrence.h"
#include "engine/dsp/simd/lanes.h"
#include "engine/graph/node.h"

namespace tactus {

static_assert(kVectorWidth == Lanes::kCount);

/// Cuts a block where parameters may change: `update(frame)` at each group start (and at the very first frame
/// of a node), `run(from, to, position)` on the frames between. Where the parameters are constant there is
/// one run for all whole groups.
class GroupSteps {
 public:
  void reset() noexcept { first_ = true; }

  /// For a block of one frame: updates where that is due, returns the position.
  template <class Update>
  int single(const NodeBlock& block, Update update) noexcept {
    const int position = group_position(block.first_frame);
    if (position == 0 || first_) update(0);
    first_ = false;
    return position;
  }

  template <class Update, class Run>
  void run(const NodeBlock& block, bool constant, Update update, Run run) noexcept {
    for (int from = 0; from < block.frames;) {
      const int position = group_position(block.first_frame + from);
      if (position == 0 || first_) update(from);
      first_ = false;
      const int to =
          constant && position == 0 ? block.frames : std::min(block.frames, from + kGroup - position);
      run(from, to, position);
      from = to;
    }
  }

 private:
  bool first_ = true;
};

/// A few frames of a block that cannot be skipped as a whole, then again the rest. Not inlined: what it
/// prepares would delay a block in which nothing happens.
template <class Skip, class Step>
[[gnu::noinline]] void run_in_parts(int frames, bool may_skip, Skip skip, Step step) noexcept {
  constexpr int kFew = 8;
  for (int n = 0; n < frames;) {
    const int count = std::min(kFew, frames - n);
    step(n, count);
    n += count;
    if (may_skip && n < frames && skip(n, frames - n)) return;
  }
}

/// For nodes in which most of the time nothing happens: all that is left of a block at once where `may_skip`
/// and `skip(from, count)` allow it, else `step(from, count)` for a few frames.
template <class Skip, class Step>
void run_with_skips(const NodeBlock& block, bool may_skip, Skip skip, Step step) noexcept {
  if (!may_skip || !skip(0, block.frames)) run_in_parts(block.frames, may_skip, skip, step);
}

/// Puts the outputs that somebody reads to the front of `outputs`, which has room for all. Returns how many.
inline std::size_t find_read(const NodeBlock& block, std::vector<std::size_t>& outputs) noexcept {
  std::size_t count = 0;
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (block.out[i] != nullptr) outputs[count++] = i;
  return count;
}

/// Whether `count` inputs from `first` on are constant.
inline bool all_constant(const NodeBlock& block, std::size_t first, std::size_t count) noexcept {
  bool all = true;
  for (std::size_t i = first; i < first + count; ++i) all = all && block.in[i].constant();
  return all;
}

/// An input of a vectorised node (see Node::vectorised); of a scalar node its only lane is 0.
class VectorSignal {
 public:
  explicit VectorSignal(const Signal& signal) noexcept : data_(signal.data), stride_(signal.stride) {}

  /// All lanes of a frame.
  Lanes operator[](int frame) const noexcept {
    const double* const at = data_ + frame * stride_;
    return stride_ == 1 ? Lanes::broadcast(*at) : Lanes::load(at);
  }
  double lane(int lane, int frame) const noexcept {
    return data_[frame * stride_ + (stride_ == 1 ? 0 : lane)];
  }
  /// From a later frame on.
  VectorSignal operator+(int frames) const noexcept {
    return VectorSignal{{data_ + frames * stride_, stride_}};
  }

 private:
  const double* data_;
  std::ptrdiff_t stride_;
};

/// The frames of a signal of `Width` lanes one behind the other; what has fewer numbers is written out.
template <int Width = 1>
class Contiguous {
 public:
  const double* operator()(const Signal& signal, int frames) noexcept {
    if (signal.stride == Width) return signal.data;
    if constexpr (Width == 1)
      std::fill_n(samples_.begin(), frames, signal[0]);
    else
      for (int n = 0; n < frames; ++n) VectorSignal{signal}[n].store(&samples_[n * Width]);
    return samples_.data();
  }

 private:
  std::array<double, static_cast<std::size_t>(kMaxSubBlock* Width)> samples_;
};

/// The first input of a block, to be read in runs: samples one behind the other, or all lanes of each frame.
template <int Width>
auto run_input(const NodeBlock& block, Contiguous<1>& contiguous) noexcept {
  if constexpr (Width == 1)
    return contiguous(block.in[0], block.frames);
  else
    return VectorSignal{block.in[0]};
}

}  // namespace tactus
