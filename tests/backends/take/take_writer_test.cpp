#include <signal.h>
#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <thread>

#include "backends/take/take_recorder.h"
#include "backends/wav_file.h"
#include "tests/support/allocation_count.h"
#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 100;

TakeHeader header_of_two() {
  TakeHeader header;
  header.inputs = {"in"};
  header.outputs = {"out"};
  return header;
}

/// A stream whose sensor counts frames and whose drive counts them backwards.
struct Stream {
  explicit Stream(TakeRing& to) : ring(to) {}
  void block() {
    for (int n = 0; n < kFrames; ++n) {
      in[static_cast<std::size_t>(n)] = static_cast<double>(frame + n);
      out[static_cast<std::size_t>(n)] = -in[static_cast<std::size_t>(n)];
    }
    const double* from = in.data();
    double* to = out.data();
    ring.observe({&from, &to, kFrames}, frame);
    frame += kFrames;
  }
  TakeRing& ring;
  std::vector<double> in = std::vector<double>(kFrames), out = in;
  std::int64_t frame = 0;
};

/// Files may not grow beyond this while it lives: the disk is full.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    handler_ = signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("take: a disk that stands still drops whole blocks, tells where, and keeps time", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "take.wav";
  TakeRing ring{1, 1, 10 * kFrames};
  auto writer = TakeWriter::create(path, header_of_two(), ring);
  REQUIRE(writer.has_value());
  Stream stream{ring};
  for (int n = 0; n < 25; ++n) stream.block();  // 10 blocks fit
  CHECK(ring.dropped_frames() == 15 * kFrames);
  CHECK(writer->work());
  for (int n = 0; n < 3; ++n) stream.block();
  writer->finish();

  const auto take = read_take(path);
  REQUIRE(take.has_value());
  CHECK(take->gaps == std::vector<TakeGap>{{10 * kFrames, 15 * kFrames}});
  CHECK(take->complete == 28 * kFrames);
  CHECK(take->finished);
  CHECK(test::names_in(why_not_exact(*take)) == "0.021");
  const auto samples = read_wav(path);
  REQUIRE(samples.has_value());
  REQUIRE(samples->frames() == 28 * kFrames);
  for (std::size_t n = 0; n < 28 * kFrames; ++n) {
    const bool missing = n >= 10 * kFrames && n < 25 * kFrames;
    REQUIRE(samples->channels[0][n] == (missing ? 0.0 : static_cast<double>(n)));
    REQUIRE(samples->channels[1][n] == (missing ? 0.0 : -static_cast<double>(n)));
  }
}

TEST_CASE("take: a gap at the end is recorded too", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "take.wav";
  TakeRing ring{1, 1, 2 * kFrames};
  auto writer = TakeWriter::create(path, header_of_two(), ring);
  REQUIRE(writer.has_value());
  Stream stream{ring};
  for (int n = 0; n < 5; ++n) stream.block();
  writer->finish();
  CHECK(read_take(path)->gaps == std::vector<TakeGap>{{2 * kFrames, 3 * kFrames}});
  CHECK(read_wav(path)->frames() == 5 * kFrames);
}

TEST_CASE("take: more changes than there is room for are counted, and it says that it is not exact",
          "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "take.wav";
  TakeRing ring{1, 1, 2 * kFrames};
  auto writer = TakeWriter::create(path, header_of_two(), ring);
  REQUIRE(writer.has_value());
  for (int n = 0; n < 16384 + 3; ++n) ring.applied({0, JournalEntry::Kind::Arm, 0, 1.0});
  Stream{ring}.block();
  writer->finish();
  const auto take = read_take(path);
  REQUIRE(take.has_value());
  CHECK(take->guard.size() == 16384);
  CHECK(take->lost_entries == 3);
  CHECK(test::names_in(why_not_exact(*take)) == "3");
}

TEST_CASE("take: a full disk ends the take and keeps what is there", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "take.wav";
  TakeRing ring{1, 1, 100 * kFrames};
  auto writer = TakeWriter::create(path, header_of_two(), ring);
  REQUIRE(writer.has_value());
  Stream stream{ring};
  {
    const FullDisk full{200'003};
    for (int round = 0; round < 10; ++round) {
      for (int n = 0; n < 90; ++n) stream.block();
      (void)writer->work();
    }
    CHECK(writer->error().ends_with("(File too large)"));
    CHECK_FALSE(writer->work());
    writer->finish();
  }
  const auto take = read_take(path);
  REQUIRE(take.has_value());
  CHECK(take->ended == writer->error());
  const auto samples = read_wav(path);
  REQUIRE(samples.has_value());
  CHECK(samples->frames() == (200'003 - 94) / 8);
  CHECK(take->complete == 180 * kFrames);  // at the end of the last round that was whole
  for (std::size_t n = 0; n < static_cast<std::size_t>(samples->frames()); ++n)
    REQUIRE(samples->channels[0][n] == static_cast<double>(n));
}

TEST_CASE("take: an edit counts from the frame at which it took over, whichever comes first", "[take]") {
  const TemporaryFolder folder;
  const auto path = folder.path() / "take.wav";
  TakeRing ring{1, 1, 100 * kFrames};
  auto header = header_of_two();
  header.sample_rate = 1_kHz;  // settled often
  auto writer = TakeWriter::create(path, header, ring);
  REQUIRE(writer.has_value());
  Stream stream{ring};
  writer->add_edit({0, {"a.toml", {{"a.toml", "first"}}, {}, ""}, {}, {}});
  stream.block();
  ring.applied({150, JournalEntry::Kind::Replacement, 1, 0.0});
  for (int n = 0; n < 4; ++n) stream.block();
  ring.applied({520, JournalEntry::Kind::Replacement, 2, 0.0});
  for (int n = 0; n < 4; ++n) stream.block();
  CHECK(writer->work());
  CHECK(read_take(path)->complete == 520);  // what runs from there on is not known yet
  writer->add_edit({0, {"a.toml", {{"a.toml", "second"}}, {}, ""}, {}, {}});
  writer->finish();
  const auto take = read_take(path);
  REQUIRE(take.has_value());
  REQUIRE(take->edits.size() == 2);
  CHECK(take->edits[0].frame == 150);
  CHECK(take->edits[0].files.texts.at("a.toml") == "first");
  CHECK(take->edits[1].frame == 520);
  CHECK(take->edits[1].files.texts.at("a.toml") == "second");
  CHECK(take->complete == 9 * kFrames);
}

TEST_CASE("take: a stream that begins again ends the take", "[take]") {
  const TemporaryFolder folder;
  const auto recorder = TakeRecorder::start(folder.path() / "take.wav", header_of_two());
  REQUIRE(recorder.has_value());
  Stream stream{(*recorder)->tap()};
  for (int n = 0; n < 3; ++n) stream.block();
  stream.frame = 0;
  (*recorder)->tap().applied({0, JournalEntry::Kind::Arm, 0, 1.0});
  for (int n = 0; n < 5; ++n) stream.block();
  CHECK((*recorder)->status().messages.size() == 1);
  CHECK((*recorder)->finish() ==
        std::vector<std::string>{"the stream restarted at 0.006 s; the take ends there"});
  const auto take = read_take(folder.path() / "take.wav");
  REQUIRE(take.has_value());
  CHECK(take->guard.empty());
  CHECK(take->ended == "the stream restarted");
  CHECK(read_wav(folder.path() / "take.wav")->frames() == 3 * kFrames);
}

TEST_CASE("take: sensors finer than float32 are counted, and drives are what a card gets", "[take]") {
  TakeRing ring{1, 2, kFrames};
  const std::vector<double> in{0.1, 0.5, static_cast<double>(0.1f), 1e-40};
  const std::vector<double> drives{0.1, -1e-39, 1e-37, 0.25};
  auto copy = drives;
  const double* from = in.data();
  double* to[] = {copy.data(), copy.data()};
  ring.observe({&from, to, 4}, 0);
  CHECK(ring.rounded_sensors() == 2);
  const auto piece = ring.front(ring.written());
  REQUIRE(piece.frames == 4);
  CHECK(piece.samples[1] == 0.1f);
  CHECK(piece.samples[4] == 0.0f);
  CHECK(piece.samples[7] == 1e-37f);
}

TEST_CASE("take: hearing and writing down allocates nothing on the audio thread", "[take]") {
  TakeRing ring{1, 1, 1000 * kFrames};
  Stream stream{ring};
  const auto before = allocation_count();
  for (int n = 0; n < 2000; ++n) {
    ring.applied({stream.frame, JournalEntry::Kind::Arm, 0, 1.0});
    stream.block();
  }
  CHECK(allocation_count() == before);
}

TEST_CASE("take: audio, writer and control thread at once lose nothing and do not race", "[take][threads]") {
  const TemporaryFolder folder;
  const auto recorder = TakeRecorder::start(folder.path() / "take.wav", header_of_two());
  REQUIRE(recorder.has_value());
  constexpr int kBlocks = 2000;  // less than the ring holds
  std::thread audio{[&] {
    Stream stream{(*recorder)->tap()};
    for (int n = 0; n < kBlocks; ++n) {
      if (n % 10 == 9)
        (*recorder)->tap().applied({stream.frame, JournalEntry::Kind::Replacement, n / 10 + 1, 0.0});
      stream.block();
    }
  }};
  for (int n = 0; n < kBlocks / 10; ++n) {
    (*recorder)->note_edit({0, {"a.toml", {{"a.toml", std::to_string(n)}}, {}, ""}, {}, {}});
    CHECK((*recorder)->status().error.empty());
  }
  audio.join();
  CHECK((*recorder)->finish().empty());
  const auto take = read_take(folder.path() / "take.wav");
  REQUIRE(take.has_value());
  REQUIRE(take->edits.size() == kBlocks / 10);
  for (int n = 0; n < kBlocks / 10; ++n) {
    const auto& edit = take->edits[static_cast<std::size_t>(n)];
    CHECK(edit.frame == (10 * n + 9) * kFrames);
    CHECK(edit.files.texts.at("a.toml") == std::to_string(n));
  }
  const auto samples = read_wav(folder.path() / "take.wav");
  REQUIRE(samples->frames() == kBlocks * kFrames);
  for (std::size_t n = 0; n < kBlocks * kFrames; ++n)
    REQUIRE(samples->channels[0][n] == static_cast<double>(n));
}
