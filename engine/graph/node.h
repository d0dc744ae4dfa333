#pragma once

#include <complex>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/core/index.h"
#include "engine/core/realtime.h"
#include "engine/core/units.h"

namespace tactus {

/// Longest sub-block that a node is given, whatever the block size: its signals stay in the cache.
inline constexpr int kMaxSubBlock = 64;

/// Lanes that one vectorised node processes (see Node::vectorised).
inline constexpr int kVectorWidth = 8;

/// One input of a node for one sub-block. A constant (or a control at rest) is one number with stride 0, so
/// that a node can see that nothing changes; anything else has one sample per frame. [any]
struct Signal {
  const double* data = nullptr;
  std::ptrdiff_t stride = 0;

  double operator[](int frame) const { return data[frame * stride]; }
  bool constant() const { return stride == 0; }
};

/// One sub-block of a node: `frames` frames at its own rate, the first of which is number `first_frame` since
/// the engine started. Inputs and outputs are in the order of the declaration.
struct NodeBlock {
  const Signal* in = nullptr;
  double* const* out = nullptr;
  int frames = 0;
  std::int64_t first_frame = 0;
};

/// [any] z = e^(j 2 pi f / rate): the unit circle at frequency f.
inline std::complex<double> on_circle(Hertz frequency, Hertz sample_rate) {
  return std::polar(1.0, 2 * std::numbers::pi * frequency.value / sample_rate.value);
}

/// Something of the file that does not run, and why.
struct LeftOut {
  std::string path;
  std::string reason;
};

/// Guaranteed delay in frames from an input to an output.
struct DelayRange {
  int least = 0;
  int most = 0;
};

/// A running node: one lane of one node of a graph, with its state. Made, ready to run, by `NodeType::make`.
///
/// The contract, checked by tests/conformance for every registered type:
///  - The output does not depend on how the frames are cut into blocks. Vectorised recurrences and updates of
///    coefficients therefore lie on the absolute frame grid (`first_frame`); nothing depends on `frames`.
///  - `process` never allocates, locks, waits, logs or throws.
///  - After `reset` the same input gives the same output again.
///  - Finite inputs within their declared ranges give finite outputs; a parameter outside is clamped.
///
/// A node whose declaration marks inputs as `late` may lie on a loop. There the schedule calls, for each
/// sub-block of at most `delay(late input, output).least` frames, `emit` (which writes every output and must
/// not read late inputs) and later `absorb` (which reads the late inputs of the same frames). Elsewhere it
/// calls `process`, which must give the same bits as emit and absorb frame by frame.
class Node {
 public:
  virtual ~Node() = default;

  /// [realtime] Fills every output for the frames of `block`.
  virtual void process(const NodeBlock& block) noexcept TACTUS_NONBLOCKING = 0;
  /// [realtime] Back to the state after `make`; tables and designs of load time stay.
  virtual void reset() noexcept TACTUS_NONBLOCKING = 0;

  /// [realtime] After an edit: takes over, as far as it fits, the state of the node of the same type and path
  /// that was made from other parameters (longest delay, stiffness).
  virtual void adopt(const Node& /*before*/) noexcept {}
  /// [realtime] After an edit that separates what was one: continues as `other` does, which was made from the
  /// same things. A node without memory has nothing to do.
  virtual void copy(const Node& /*other*/) noexcept {}

  /// [realtime] First half, for nodes with late inputs: outputs without the late inputs.
  virtual void emit(const NodeBlock&) noexcept TACTUS_NONBLOCKING {}
  /// [realtime] Second half: reads the late inputs of the frames last emitted.
  virtual void absorb(const NodeBlock&) noexcept TACTUS_NONBLOCKING {}

  /// [any] Guaranteed for the ranges that the node was made with. `most` < 0: unbounded (an infinite response
  /// has the delay of its first sample).
  virtual DelayRange delay(int /*input*/, int /*output*/) const { return {}; }

  /// [any] H(z) from `input` to `output` of the node, linear or linearised, with every input held at `at`
  /// (declaration order), |z| >= 1; at a frequency f see `on_circle`. nullopt: no linearisation exists (see
  /// NodeType::small_signal_gain). Does not touch the state.
  virtual std::optional<std::complex<double>> response(int /*input*/, int /*output*/,
                                                       std::complex<double> /*z*/,
                                                       std::span<const double> /*at*/) const {
    return std::nullopt;
  }

  /// [control] One vectorised node that replaces these, in their initial state; nullptr if there is none.
  /// `lanes` are kVectorWidth nodes of the same declaration and settings, nullptr where a lane is not used:
  /// it then equals this node, the first that is used. In a vectorised node every output has kVectorWidth
  /// numbers per frame, and the stride of an input is kVectorWidth (as many numbers), 1 (one number for all
  /// lanes) or 0 (kVectorWidth constant numbers). The rest of the contract applies; delays are those of all
  /// lanes, and each lane gives the output of its node except for rounding (its recurrence runs in another
  /// order).
  virtual std::unique_ptr<Node> vectorised(std::span<const Node* const> /*lanes*/) const { return nullptr; }

  /// [any] Notes on how the node was made, for `tactus explain`; may be empty.
  virtual std::string about() const { return {}; }
  /// [any] What it has left out of itself; paths within the node.
  virtual std::vector<LeftOut> left_out() const { return {}; }

  /// [any] How many frames an input was clamped (for example a delay beyond its range).
  virtual std::int64_t clamped() const { return 0; }
};

/// [realtime] `Node::copy` of a class that can be assigned, which must not allocate.
template <class SomeNode>
void assign(SomeNode& to, const Node& other) noexcept {
  if (const auto* same = dynamic_cast<const SomeNode*>(&other)) to = *same;
}

}  // namespace tactus
