#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/journal.h"
#include "engine/core/spsc_queue.h"
#include "engine/graph/plan/plan.h"
#include "engine/runtime/output_fade.h"
#include "engine/runtime/running.h"

namespace tactus {

/// What went wrong at one node while running: how often something not finite came out of it.
struct FaultCount {
  std::string path;
  std::int64_t count = 0;
};

/// Runs a Plan on blocks of any size. The output does not depend on the size: a block is worked off in
/// pieces of at most kMaxPiece frames, cut where a journal entry falls, and every node is exact to the frame.
class Engine final : public BlockProcessor {
 public:
  explicit Engine(std::unique_ptr<Plan> plan);
  ~Engine() override;

  /// [control & stopped] Starts again at frame 0 with everything reset. Inputs and outputs beyond those of
  /// the format read zero and are not written. Errors: BadArgument if the sample rate is not the plan's.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared]
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;

  /// [control & stopped] Entries known beforehand (rendering, replay), sorted by frame. Applies from the next
  /// process on.
  void set_journal(std::vector<JournalEntry> entries);
  /// [control, one thread] An entry for the running engine. False: the queue is full, try again after a
  /// block.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept { return inbox_.push(entry); }
  /// [control, one thread] Puts another version of the graph in the place of the running one, from `frame` on
  /// (kNow: from the next block). Nodes of the same path that are made from the same things go on with their
  /// state, controls keep their value, constants that differ move to their new value in 10 ms, and an output
  /// that would jump gets an offset equal to its jump, which fades in 10 ms. An edit that changes nothing
  /// changes no bit. Errors: BadArgument if inputs, outputs or sample rate differ, or if the last version
  /// still waits for its frame; the sounding graph then plays on.
  [[nodiscard]] Status replace(std::unique_ptr<Plan> plan, std::int64_t frame = JournalEntry::kNow);
  /// [control, one thread] A version given to `replace` has not taken over yet; the next one would be
  /// refused.
  bool replacing() const { return before_ != nullptr && !retired_.load(std::memory_order_acquire); }
  /// [control, one thread] The number that journal entries name a control by; it outlives every replacement.
  /// -1: there is none.
  int control_index(std::string_view control) const;
  /// [control, one thread] Names by that number; those of controls that are gone stay.
  const std::vector<std::string>& control_names() const { return newest_->control_names; }

  /// [control & stopped] `tap` outlives this, or is taken away with nullptr. It hears every entry, of the
  /// journal and posted, and every version that takes over: at the same frame that comes first.
  void set_tap(JournalTap* tap) noexcept { tap_ = tap; }
  /// [control & stopped] For a plan with an `Outside` step: who answers there. It reads this engine's
  /// outputs and fills its inputs, in blocks of the loop's sub-block.
  void set_outside(BlockProcessor& outside) { outside_ = &outside; }

  /// [control, one thread] The newest one.
  const Plan& plan() const { return *newest_->plan; }
  /// Channels of `io.in` and `io.out`; taps are no channels.
  int in_channels() const { return static_cast<int>(newest_->plan->input_names.size()); }
  int out_channels() const { return static_cast<int>(newest_->outputs.size()); }
  /// [realtime] Samples of tap `i` (in the order of CompileOptions::taps, lanes one after the other) of the
  /// last block.
  const double* tap(int i) const { return running_->taps[static_cast<std::size_t>(i)].data(); }
  int tap_count() const { return static_cast<int>(newest_->taps.size()); }

  /// [control, one thread] Counted while running, by all versions.
  std::vector<FaultCount> faults() const;
  /// [any]
  std::int64_t bad_input_samples() const { return bad_inputs_.load(std::memory_order_relaxed); }
  std::int64_t frame() const { return frame_.load(std::memory_order_relaxed); }

  /// [control & stopped] Runs like `process` and adds up what each step took. For `tactus explain`.
  void process_timed(const BlockIo& io) noexcept;
  const std::vector<double>& step_nanoseconds() const { return newest_->step_ns; }

 private:
  template <bool kTimed>
  void run_block(const BlockIo& io) noexcept;
  template <bool kTimed>
  void run_piece(const BlockIo& io, int offset, int frames) noexcept;
  template <bool kTimed>
  void run_section(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept;
  static constexpr int kSound = -1;
  /// The first non-finite frame of a step, and its vertex.
  struct Fault {
    int vertex = kSound;
    int frame = kMaxPiece;
  };
  static std::int64_t end_of_cell(std::int64_t frame);
  void run_alone(int step, int frames) noexcept;
  template <bool kTimed>
  void run_loop(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept;
  Fault run_step(const Step& step, bool loop, int offset, int frames) noexcept;
  Fault run_node(const Step& step, const NodeBlock& block) noexcept;
  [[gnu::noinline]] void move_operands(const Step& step, int offset, NodeBlock& block) noexcept;
  // Steps of a part with a rate of its own, and at its border.
  [[gnu::noinline]] Fault run_paced(const Step& step, bool loop, int offset, int frames) noexcept;
  void move_paced(const Step& step, int offset, NodeBlock& block) noexcept;
  /// nullptr: that of the engine itself.
  const Pace* pace(int of) const noexcept {
    return of == 0 ? nullptr : &running_->paces[static_cast<std::size_t>(of)];
  }
  static bool paced(const Step& step) noexcept { return (step.pace | step.pace_in | step.pace_out) != 0; }
  static Fault fault_of(const Step& step, const NodeBlock& block) noexcept;
  Fault run_operations(const Step& step, bool loop, int offset, int frames) noexcept;
  bool run_at_rest(const MicroOperation& operation, const Signal* operands, int frames) noexcept;
  void answer_outside(const BlockIo& io, int block_offset, int offset, int frames) noexcept;
  void count_fault(int vertex, int times = 1) noexcept;
  void reset(const Step& step) noexcept;
  void silence(const Step& step, int offset, int frames) noexcept;

  // Journal, controls, other versions.
  int frames_to_next_entry(int frames) noexcept;
  void apply(const JournalEntry& entry) noexcept;
  void tell(const JournalEntry& entry) noexcept;
  void take_over(Running& next) noexcept;
  double last_output(std::size_t output) const noexcept;
  void collect();
  void make_finite(double* samples, int frames) noexcept;
  void load_inputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept;
  void store_outputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept;

  // Control side. `newest_` runs, or waits in `incoming_`; `before_` then runs.
  std::unique_ptr<Running> newest_, before_;
  std::map<std::string, std::int64_t> past_faults_;  // of versions that are gone
  // Between the two.
  std::atomic<Running*> incoming_{nullptr};
  std::atomic<bool> retired_{false};  // nobody runs `before_` any more
  SpscQueue<JournalEntry> inbox_{256};
  std::atomic<std::int64_t> bad_inputs_{0};
  std::atomic<std::int64_t> frame_{0};
  // Audio side.
  Running* running_;
  Plan* plan_;  // of `running_`
  StreamFormat format_;
  std::vector<OutputFade> fades_;
  std::int64_t fading_until_ = 0;
  int last_frames_ = 0;  // of the piece before
  std::vector<const double*> outside_in_;
  std::vector<double*> outside_out_;
  std::vector<std::vector<double>> outside_buffers_;
  BlockProcessor* outside_ = nullptr;
  JournalTap* tap_ = nullptr;
  int replacements_ = 0;
  std::vector<JournalEntry> journal_;
  std::size_t next_entry_ = 0;
  std::int64_t now_ = 0;
};

}  // namespace tactus
