#pragma once
// Thread: [control] unless stated otherwise; [writer]: the thread that reads the ring

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "engine/core/spsc_queue.h"

namespace tactus {

/// Something besides samples that belongs into a take, in the order in which it happened: an entry that was
/// applied, or frames that were dropped.
using TakeEvent = std::variant<JournalEntry, TakeGap>;

/// Where the audio thread puts what a take needs, and a writer fetches it. Room for samples and events is
/// there from the beginning; when it is full, whole blocks are dropped and counted, and the gap is reported
/// once there is room again. Neither side ever waits.
class TakeRing final : public BlockTap {
 public:
  /// [control] Room for `frames` frames of `in_channels` + `out_channels` samples.
  TakeRing(int in_channels, int out_channels, std::int64_t frames);

  /// [realtime] Tap of Guarded and of Player.
  void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING override;
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override;

  /// Samples that lie one after the other, frame by frame: the inputs, then the outputs.
  struct Segment {
    const float* samples;
    std::int64_t frames;
  };
  /// [writer] How many frames were put in so far, gaps left out. All events of these frames are there too.
  std::int64_t written() const noexcept { return written_.load(std::memory_order_acquire); }
  /// [writer] The oldest of them, as many as lie together.
  Segment front(std::int64_t written) const noexcept;
  void drop_front(std::int64_t frames) noexcept {
    read_.store(read_.load(std::memory_order_relaxed) + frames, std::memory_order_release);
  }
  [[nodiscard]] bool pop(TakeEvent& event) noexcept { return events_.pop(event); }
  /// [writer & stream stopped] A gap that no block followed; 0 frames: none.
  const TakeGap& open_gap() const noexcept { return gap_; }

  int channels() const noexcept { return in_channels_ + out_channels_; }
  /// [any] Frames that were dropped, entries that were, sensor samples that were no float32.
  std::int64_t dropped_frames() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  std::int64_t lost_entries() const noexcept { return lost_entries_.load(std::memory_order_relaxed); }
  std::int64_t rounded_sensors() const noexcept { return rounded_.load(std::memory_order_relaxed); }
  /// [any] The stream began again at frame 0; what it did from there on is not recorded.
  bool restarted() const noexcept { return restarted_.load(std::memory_order_relaxed); }

 private:
  bool close_gap() noexcept;
  void copy(const BlockIo& io, std::int64_t at) noexcept;

  int in_channels_, out_channels_;
  std::int64_t capacity_;  ///< frames
  std::vector<float> samples_;
  SpscQueue<TakeEvent> events_{16384};
  std::atomic<std::int64_t> written_{0}, read_{0};  ///< frames since the beginning
  std::atomic<std::int64_t> dropped_{0}, lost_entries_{0}, rounded_{0};
  std::atomic<bool> restarted_{false};
  // Audio side.
  std::int64_t next_frame_ = 0;  ///< of the stream
  TakeGap gap_;
};

/// Empties a TakeRing into a WAV file and the journal beside it. One thread; `work` once in a while is all.
class TakeWriter {
 public:
  /// [control] Both files are there and readable when it returns. Errors: BadFile, BadArgument.
  static Result<TakeWriter> create(const std::filesystem::path& wav, const TakeHeader& header,
                                   TakeRing& ring);

  /// What is in the ring goes to the disk: first what was applied, then the samples that it explains, then
  /// the sizes in the header. False: the disk does not take it, and nothing is written any more.
  bool work();
  /// The k-th version of the graph that takes over is `edit`, whose frame is found out.
  void add_edit(TakeEdit edit) { edits_.push_back(std::move(edit)); }
  /// [stream stopped] Writes the rest and the end.
  void finish();

  /// Frames in the WAV, gaps included.
  std::int64_t frames() const { return wav_.frames(); }
  /// Why nothing is written any more; empty if all is well.
  const std::string& error() const { return error_; }

 private:
  TakeWriter(GrowingWav wav, std::filesystem::path journal, const TakeHeader& header, TakeRing& ring);

  void drain_events();
  void write_gap(const TakeGap& gap);
  Status write_samples(std::int64_t written);
  void settle();
  void fail_with(const std::string& what);

  GrowingWav wav_;
  std::filesystem::path journal_path_;
  std::ofstream journal_;
  TakeRing* ring_;
  std::deque<TakeGap> gaps_;           ///< not reached by the samples yet
  std::deque<std::int64_t> replaced_;  ///< frames of versions whose text did not come yet
  std::deque<TakeEdit> edits_;         ///< texts of versions that did not take over yet
  std::int64_t settle_every_;          ///< frames
  std::int64_t settled_ = 0;           ///< frames
  Take progress_;                      ///< as of the last line
  std::string error_;
};

/// How a recording goes.
struct TakeStatus {
  Seconds recorded;                 ///< on the disk
  std::int64_t dropped_frames = 0;  ///< the disk was too slow; they are marked in the journal
  std::string error;                ///< why nothing is written any more: the disk is full; empty: all is well
  std::vector<std::string> messages;  ///< what went wrong; empty: nothing
};

/// Records a take: take.wav with sensors and drives, and take.jsonl with everything else that entered
/// `process`. The audio thread only ever copies into memory that is there; a thread of this object writes
/// every 20 ms. What the sound does never depends on the disk.
///
///   auto stream = backend.open(request, guarded);              // prepares `guarded`
///   TakeHeader header = …;                                     // apps/cli/take_files.h: take_header
///   auto recorder = TakeRecorder::start("take.wav", header);   // before the stream starts
///   guarded.set_tap(&(*recorder)->tap());
///   engine.set_tap(&(*recorder)->tap());
///   stream->start();
///   …  engine.replace(version) went well: recorder->note_edit({…, files, settings, controls});
///   …  print(recorder->status());
///   stream->stop();                                            // no block is in `process` any more
///   guarded.set_tap(nullptr), engine.set_tap(nullptr);
///   for (const auto& line : (*recorder)->finish()) print(line);
///
/// A stream that was lost and opened again is prepared again, at frame 0: that is another take.
class TakeRecorder {
 public:
  /// [control] Both files are on the disk when it returns. `memory`: how long the disk may take its time.
  /// Errors: BadFile if the take is there already or cannot be written; BadArgument for the channels.
  static Result<std::unique_ptr<TakeRecorder>> start(const std::filesystem::path& wav, TakeHeader header,
                                                     Seconds memory = Seconds{5.0});
  /// Finishes.
  ~TakeRecorder();
  TakeRecorder(const TakeRecorder&) = delete;
  TakeRecorder& operator=(const TakeRecorder&) = delete;

  /// [control] For Guarded::set_tap and Player::set_tap.
  TakeRing& tap() { return *ring_; }
  /// [control] Player::replace took this version. Its frame is filled in when it takes over. `controls`: all
  /// names by number, as Player::control_index counts them.
  void note_edit(TakeEdit edit);
  /// [control]
  TakeStatus status() const;
  /// [control & stopped] Writes what is left and ends the files. Returns the messages of the last status; a
  /// second call returns none.
  std::vector<std::string> finish();

 private:
  TakeRecorder(TakeHeader header, std::unique_ptr<TakeRing> ring, TakeWriter writer);
  void run();
  std::vector<std::string> messages() const;

  Hertz sample_rate_;
  std::unique_ptr<TakeRing> ring_;
  mutable std::mutex mutex_;  ///< between control and writer: never taken by the audio thread
  std::condition_variable wake_;
  TakeWriter writer_;
  bool done_ = false;
  std::vector<TakeEdit> edits_;  ///< that the writer did not fetch yet
  TakeStatus status_;
  std::thread thread_;
};

}  // namespace tactus
