#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/journal.h"
#include "engine/core/spsc_queue.h"
#include "engine/graph/schedule.h"

namespace tactus {

/// What went wrong at one node while running: how often something not finite came out of it.
struct FaultCount {
  std::string path;
  std::int64_t count = 0;
};

/// Runs a Schedule on blocks of any size. The output does not depend on the size: a block is worked off in
/// pieces of at most kMaxPiece frames, cut where a journal entry falls, and every node is exact to the frame.
class Engine final : public BlockProcessor {
 public:
  explicit Engine(std::unique_ptr<Schedule> schedule);
  ~Engine() override;

  /// [control & stopped] Starts again at frame 0 with everything reset. Inputs and outputs beyond those of
  /// the format read zero and are not written. Errors: BadArgument if the sample rate is not the schedule's.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared]
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;

  /// [control & stopped] Entries known beforehand (rendering, replay), sorted by frame. Applies from the next
  /// process on.
  void set_journal(std::vector<JournalEntry> entries);
  /// [control, one thread] An entry for the running engine. False: the queue is full, try again after a
  /// block.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept { return inbox_.push(entry); }
  /// [control & stopped] For a schedule with an `Outside` step: who answers there. It reads this engine's
  /// outputs and fills its inputs, in blocks of the loop's sub-block.
  void set_outside(BlockProcessor& outside) { outside_ = &outside; }

  const Schedule& schedule() const { return *schedule_; }
  /// Channels of `io.in` and `io.out`; taps are no channels.
  int in_channels() const { return static_cast<int>(schedule_->input_names.size()); }
  int out_channels() const { return static_cast<int>(outputs_.size()); }
  /// [realtime] Samples of tap `i` (in the order of CompileOptions::taps, lanes one after the other) of the
  /// last block.
  const double* tap(int i) const { return taps_[static_cast<std::size_t>(i)].data(); }
  int tap_count() const { return static_cast<int>(taps_.size()); }

  /// [any] Counted while running.
  std::vector<FaultCount> faults() const;
  std::int64_t bad_input_samples() const { return bad_inputs_.load(std::memory_order_relaxed); }
  std::int64_t frame() const { return frame_.load(std::memory_order_relaxed); }

  /// [control & stopped] Runs like `process` and adds up what each step took. For `tactus explain`.
  void process_timed(const BlockIo& io) noexcept;
  const std::vector<double>& step_nanoseconds() const { return step_ns_; }

 private:
  struct ControlState;

  template <bool kTimed>
  void run_block(const BlockIo& io) noexcept;
  template <bool kTimed>
  void run_piece(const BlockIo& io, int offset, int frames) noexcept;
  template <bool kTimed>
  void run_section(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept;
  static constexpr int kSound = -1;  ///< nothing went wrong; else the path of what did
  int run_step(const Section& section, const Step& step, int offset, int frames) noexcept;
  int run_operations(const Section& section, const Step& step, int offset, int frames) noexcept;
  void answer_outside(const BlockIo& io, int block_offset, int offset, int frames) noexcept;
  void count_fault(int path) noexcept;
  void silence(const Step& step, int offset, int frames) noexcept;

  int frames_to_next_entry(int frames) noexcept;
  void apply(const JournalEntry& entry) noexcept;
  void advance_controls(int frames) noexcept;
  void rest(std::size_t control, bool resting) noexcept;
  void make_finite(double* samples, int frames) noexcept;
  void load_inputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept;
  void store_outputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept;

  std::unique_ptr<Schedule> schedule_;
  StreamFormat format_;
  std::vector<int> outputs_;  // channels that are not taps
  std::vector<int> tap_channels_;
  std::vector<std::vector<double>> taps_;
  std::vector<ControlState> controls_;
  std::vector<Signal> moved_in_;  // a step's operands at an offset into the piece
  std::vector<double*> moved_out_;
  std::vector<const double*> outside_in_;
  std::vector<double*> outside_out_;
  std::vector<std::vector<double>> outside_buffers_;
  BlockProcessor* outside_ = nullptr;
  std::vector<JournalEntry> journal_;
  std::size_t next_entry_ = 0;
  SpscQueue<JournalEntry> inbox_{256};
  std::vector<std::atomic<std::int64_t>> faults_;  // by path
  std::atomic<std::int64_t> bad_inputs_{0};
  std::atomic<std::int64_t> frame_{0};
  std::int64_t now_ = 0;
  std::vector<double> step_ns_;
};

}  // namespace tactus
