#pragma once
// Thread: [control]

#include <cstdint>
#include <deque>
#include <fstream>
#include <memory>
#include <string>

#include "backends/take/growing_wav.h"
#include "backends/take/take.h"
#include "backends/take/take_ring.h"

namespace tactus {

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
  void add(const JournalEntry& entry);
  void match_edits();
  void write_gap(const TakeGap& gap);
  Status write_samples(std::int64_t written);
  void settle();
  void note_progress();
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

}  // namespace tactus
