#pragma once
// Thread: [control, one thread] unless stated otherwise.

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/core/spsc_queue.h"
#include "engine/graph/plan/plan.h"
#include "engine/runtime/signal_reader.h"

namespace tactus {

/// A signal of a plan that can be shown.
struct ScopeSignal {
  std::string name;     ///< as a file names it: "strike", "strike.level", "string[2]"; "out/woofer"
  int vertex = -1;      ///< that makes it
  Dimension dimension;  ///< plain where it is not known
  SignalPlace place;
  const OutputPort* port = nullptr;  ///< of the node; nullptr: it is no output of a node
  int lane = 0;
  bool in_part = false;
};

/// As a file names an output of a node, or one lane of it: "strike", "strike.level", "string.out[2]".
std::string signal_name(const Vertex& vertex, int port, int lane = 0);

/// The vertices that give the values of expressions with a name of their own, by path: not those of ports,
/// and not those of outputs that nothing else reads.
std::map<std::string, int> named_expressions(const Plan& plan);

/// Inputs, controls, outputs of nodes that are computed, named expressions, and outputs before the guard.
/// Constants are none of them.
std::vector<ScopeSignal> scope_signals(const Plan& plan);

/// Values of the traces of a scope, one after the other; of a bin of several frames the lowest and the
/// highest value.
struct ScopeChunk {
  static constexpr int kMostTraces = 8, kMostBins = 64;

  std::uint32_t id = 0;  ///< of the choice
  int bin = 1;           ///< frames
  int traces = 0, bins = 0;
  std::int64_t frame = 0;                                 ///< the first of the first bin
  std::array<float, 2 * kMostTraces * kMostBins> values;  ///< [trace][bin], or [trace][bin][low, high]

  int per_bin() const { return bin == 1 ? 1 : 2; }
  /// Of a whole chunk: as many as there is room for, and no more than 20 ms at 48 kHz.
  static int bins_of(int bin) { return bin == 1 ? kMostBins : std::clamp(960 / bin, 1, kMostBins); }
};

/// What a scope shows.
struct ScopeChoice {
  /// [control] Of a version of a graph (Player::version), whose `scope_signals` have these places; those
  /// beyond the eighth are left out.
  static ScopeChoice of(std::uint64_t version, std::uint32_t id, int bin,
                        std::span<const SignalPlace> places);

  std::uint64_t running = 0;  ///< Running::number of the version that the places belong to
  std::uint32_t id = 0;
  int bin = 1;
  int traces = 0;
  std::array<SignalPlace, ScopeChunk::kMostTraces> places;
};

/// Copies up to eight signals of a running player for a screen. Where the screen does not take them, they
/// are lost. Bins begin at multiples of their length and chunks at multiples of theirs, whatever the blocks
/// are, so that those of two players fit together.
class SignalScope final : public SignalObserver {
 public:
  explicit SignalScope(std::size_t chunks = 256) : chunks_(chunks) {}

  /// From the next sub-block on. False: too many choices wait, try again after a block.
  [[nodiscard]] bool choose(const ScopeChoice& choice) { return choices_.push(choice); }
  /// [any, one thread] The oldest chunk. False: there is none.
  [[nodiscard]] bool take(ScopeChunk& chunk) { return chunks_.pop(chunk); }
  void observe(const Running& running, std::int64_t now, int frames) noexcept override;
  /// [any] Chunks that found no room.
  std::int64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  struct Extremes {
    double low, high;
  };

  bool take_choices(const Running& running) noexcept;
  void add(std::int64_t frame, const double* values) noexcept;
  void finish_bin() noexcept;

  SpscQueue<ScopeChoice> choices_{16};
  SpscQueue<ScopeChunk> chunks_;
  std::atomic<std::int64_t> lost_{0};
  // Audio side.
  ScopeChoice choice_;
  ScopeChunk chunk_;
  std::array<double, ScopeChunk::kMostTraces> held_{};  ///< of parts with a rate of their own
  std::array<Extremes, ScopeChunk::kMostTraces> extremes_{};
  std::int64_t next_ = 0;  ///< the frame that continues the chunk
  bool in_chunk_ = false;
};

}  // namespace tactus
