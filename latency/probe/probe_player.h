#pragma once
// Thread: [control] unless stated otherwise

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "backends/backend.h"
#include "engine/guard/guarded.h"
#include "latency/estimation/loop_recording.h"
#include "latency/path/level.h"

namespace tactus {

/// Plays one opening of a stream from beginning to end, and records it: finds the level (level.h), plays the
/// probes and the pilot, waits until they are back, and is silent from then on. Runs inside a Guarded and
/// is its tap too, because what went out behind the guard is what counts.
///
/// It steers itself by frames: the control side has no deadline, and neither blocks nor clocks
/// change what is played. Within the frame in which the input comes to its end it falls silent, and then
/// checks whether that helped.
class ProbePlayer final : public BlockProcessor, public BlockTap {
 public:
  struct Script {
    int input = 0;  ///< among the stream's
    int probes = 8;
    LevelSearch::Settings level;
  };
  enum class Outcome {
    Played,    ///< all of it
    TooLoud,   ///< muted, and then it was quiet
    Feedback,  ///< muted, and it went on
  };

  /// [control & stopped] What the next `prepare` is for.
  void set_script(const Script& script) { script_ = script; }
  /// [control & stopped, prepared] Whose health is noted at both ends of the probes.
  void set_stream(const Stream* stream) { stream_ = stream; }

  Status prepare(const StreamFormat& format) override;
  void process(const BlockIo& io) noexcept TACTUS_NONBLOCKING override;
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override;
  void applied(const JournalEntry&) noexcept TACTUS_NONBLOCKING override {}

  /// [any] It has come to its end; what follows is silence.
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }
  /// [any] How much of it is over, 0 … 1; a guess until the level is found.
  double share() const noexcept { return share_.load(std::memory_order_relaxed); }

  // [control & done]
  Outcome outcome() const { return outcome_; }
  const PathLevel& level() const { return level_; }
  const Health& health_before() const { return before_; }
  const Health& health_after() const { return after_; }
  /// From the first frame to the end; only the probes, where the search for the level drove the input to its
  /// end. Moves it out.
  LoopRecording take_recording();

 private:
  enum class Stage { Level, Probes, Muted, Done };

  double share_now() const noexcept;
  double next() noexcept;
  void observe_input(double sample) noexcept;
  void end_window() noexcept;
  void follow(LevelSearch::Step step) noexcept;
  void begin_probes() noexcept;
  void mute() noexcept;
  void finish(Outcome outcome) noexcept;
  Health health() const noexcept { return stream_ != nullptr ? stream_->health() : Health{}; }

  Script script_;
  const Stream* stream_ = nullptr;
  StreamFormat format_;
  std::vector<double> level_probe_, train_;
  std::optional<LevelSearch> search_;
  Stage stage_ = Stage::Done;
  std::int64_t frame_ = 0;  ///< since `prepare`

  // What sounds: `train_` or `level_probe_` from `at_` on.
  const std::vector<double>* sounding_ = nullptr;
  std::size_t at_ = 0;
  double gain_ = 0.0;
  std::int64_t probes_from_ = 0;
  std::int64_t back_at_ = 0;  ///< frame at which the probes are back

  // The window in hand.
  int window_frames_ = 0, in_window_ = 0;
  LevelWindow window_;
  double slow_ = 0.0, slow_share_ = 0.0;
  RingOutMonitor ring_out_;

  std::vector<double> played_;
  std::vector<std::vector<double>> captured_;
  std::size_t recorded_ = 0;
  std::int64_t end_frame_ = 0;  ///< of the recording

  Outcome outcome_ = Outcome::Played;
  PathLevel level_;
  Health before_, after_;
  std::atomic<bool> done_{true};
  std::atomic<double> share_{0.0};
};

}  // namespace tactus
