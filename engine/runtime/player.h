#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/channels.h"
#include "engine/core/journal.h"
#include "engine/runtime/replacement.h"
#include "engine/runtime/step_runner.h"

namespace tactus {

class SignalObserver;

/// Runs a Plan on blocks of any size. The output does not depend on the size: a block is processed in
/// sub-blocks of at most kMaxSubBlock frames, cut where a journal entry falls, and every node is exact to the
/// frame.
class Player final : public BlockProcessor, private Outside {
 public:
  /// [control]
  explicit Player(std::unique_ptr<Plan> plan);

  /// [control & stopped] Starts again at frame 0 with everything reset. Inputs and outputs beyond those of
  /// the format read zero and are not written. Errors: BadArgument if the sample rate is not the plan's.
  [[nodiscard]] Status prepare(const StreamFormat& format) override;
  /// [realtime & prepared] The thread must flush denormals to zero, as it does inside Guarded and ClosedLoop.
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;
  /// [control & stopped] From now on `process` adds up what each step takes (see StepTimes), or no longer.
  void time_steps(bool on) noexcept { timed_ = on; }
  /// [control & stopped] Of the newest version, without the time that the clock itself takes.
  const std::vector<double>& step_nanoseconds() const { return versions_.newest().step_ns; }

  /// [control & stopped] Entries known beforehand (rendering, replay), sorted by frame. Applies from the next
  /// process on.
  void set_journal(std::vector<JournalEntry> entries) { inbox_.set_journal(std::move(entries)); }
  /// [control & stopped] Drops the posted entries that were not applied yet.
  void drop_posted() noexcept { inbox_.drop_posted(); }
  /// [control, one thread] An entry for the running player. False: the queue is full, try again after a
  /// block.
  [[nodiscard]] bool post(const JournalEntry& entry) noexcept { return inbox_.post(entry); }
  /// [control, one thread] Puts another version of the graph in the place of the running one, from `frame` on
  /// (kNow: from the next block). Nodes of the same path that are made from the same things continue with
  /// their state, controls keep their value, constants that differ move to their new value in 10 ms, and an
  /// output that would jump gets an offset equal to its jump, which fades in 10 ms. An edit that changes
  /// nothing changes no bit. Errors: BadArgument if inputs, outputs or sample rate differ, or if the last
  /// version has not taken over yet; the playing graph then plays on.
  [[nodiscard]] Status replace(std::unique_ptr<Plan> plan, std::int64_t frame = JournalEntry::kNow) {
    return versions_.offer(std::move(plan), frame, format_.max_frames);
  }
  /// [control, one thread] A version given to `replace` has not taken over yet; the next one would be
  /// refused.
  bool replacing() const { return versions_.waits(); }
  /// [control, one thread] The number that journal entries name a control by; it outlives every replacement.
  /// -1: there is none.
  int control_index(std::string_view control) const;
  /// [control, one thread] Names by that number; those of controls that are gone stay.
  const std::vector<std::string>& control_names() const { return versions_.newest().control_names; }

  /// [control & stopped] `tap` outlives this, or is taken away with nullptr. It observes every entry, of the
  /// journal and posted, and every version that takes over: at the same frame that comes first.
  void set_tap(JournalTap* tap) noexcept { inbox_.set_tap(tap); }
  /// [control & stopped] For a plan with an `Outside` step: who answers there. It reads this player's
  /// outputs and fills its inputs, in blocks of the loop's sub-block.
  void set_outside(BlockProcessor& outside) { outside_ = &outside; }

  /// [control & stopped] It outlives this, or is removed.
  void add_observer(SignalObserver& observer) { observers_.push_back(&observer); }
  void remove_observer(SignalObserver& observer) { std::erase(observers_, &observer); }
  /// [control, one thread] Running::number of the newest version of the graph.
  std::uint64_t version() const { return versions_.newest().number; }

  /// [control, one thread] The newest one.
  const Plan& plan() const { return *versions_.newest().plan; }
  /// [control, one thread] Channels of `io.in` and `io.out`; taps are no channels.
  int in_channels() const { return static_cast<int>(plan().input_names.size()); }
  int out_channels() const { return static_cast<int>(versions_.newest().outputs.size()); }
  /// [realtime] Samples of tap `i` (in the order of CompileOptions::taps, lanes one after the other) of the
  /// last block.
  const double* tap(int i) const { return running_->taps[index(i)].data(); }
  /// [control, one thread]
  int tap_count() const { return static_cast<int>(versions_.newest().taps.size()); }

  /// [control, one thread] Counted while running, by all versions.
  std::vector<FaultCount> faults() const { return versions_.faults(); }
  /// [any]
  std::int64_t bad_input_samples() const { return bad_inputs_.load(std::memory_order_relaxed); }
  std::int64_t frame() const { return frame_.load(std::memory_order_relaxed); }

 private:
  void run_sub_block(int frames) noexcept;
  void use(Running& running) noexcept {
    running_ = &running;
    steps_.use(running);
  }
  [[gnu::noinline]] int frames_to_next_entry(int frames) noexcept;
  void apply(const JournalEntry& entry) noexcept;
  void take_over(Running& next) noexcept;
  double last_output(std::size_t output) const noexcept;
  const Signal& output_signal(std::size_t output) const noexcept { return *running_->output_signals[output]; }
  void load_inputs(int frames) noexcept;
  void load_input(const double* from, int frames, double* to) noexcept;
  template <class Samples>
  void load_lanes(const InputLanes& lanes, int frames, double* to, const Samples& samples_of) noexcept;
  void store_outputs(int frames) noexcept;
  [[gnu::noinline]] void clear_input(double* samples, int frames) noexcept;
  [[gnu::noinline]] void fade_outputs(std::size_t channels, int frames) noexcept;
  [[gnu::noinline]] void store_taps(int frames) noexcept;
  [[gnu::noinline]] std::size_t store_lanes(std::size_t first, std::size_t channels, int frames) noexcept;
  void answer(int offset, int frames) noexcept override;

  Replacement versions_;
  ControlInbox inbox_;
  std::atomic<std::int64_t> bad_inputs_{0};
  std::atomic<std::int64_t> frame_{0};
  // Audio side.
  Running* running_ = nullptr;
  StepRunner steps_;
  StreamFormat format_;
  std::size_t stored_ = 0;  ///< outputs that the format has
  std::vector<OutputFade> fades_;
  std::int64_t fading_until_ = 0;
  const BlockIo* io_ = nullptr;  // the block in hand; a copy would wait for the stores of its members
  int offset_ = 0;               // of the sub-block in hand
  int last_frames_ = 0;          // of the sub-block before
  ChannelBuffers outside_in_, outside_out_;
  BlockProcessor* outside_ = nullptr;
  std::vector<SignalObserver*> observers_;
  int replacements_ = 0;
  std::int64_t now_ = 0;
  bool timed_ = false;
};

}  // namespace tactus
