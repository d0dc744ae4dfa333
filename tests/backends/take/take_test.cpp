#include "backends/take/take.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

TakeHeader full_header() {
  TakeHeader header;
  header.program = "0.1.0";
  header.sample_rate = Hertz{44100};
  header.inputs = {"a", "b[1]"};
  header.outputs = {"c"};
  header.controls = {"gain"};
  header.files = {
      "drum/instrument.toml", {{"drum/instrument.toml", "name = \"ä\"\n"}}, {{"hit.wav", "00ff"}}, "/x"};
  header.settings = {{"gain", 0.1}};
  header.taps = {"hit"};
  header.system_delay = Seconds{0.02};
  header.rig = "rig";
  header.left_out = {"sound"};
  header.input_scales = {1.0 / 3.0};
  header.padding_frames = 7;
  DriveLimits limits = conservative_limits();
  limits.heat = HeatLimits{1.5, 2.5, Seconds{3.5}, Seconds{4.5}, 0.25, 80};
  limits.excursion = ExcursionLimits{0.001, 0.002, 50_Hz, 0.7};
  header.guard = {{DriveGuard::Kind::Drive, limits, FeedbackPath{true, false}},
                  {DriveGuard::Kind::Audio, {}}};
  header.armed = false;
  header.soft_start = false;
  header.trusted_sensors = true;
  header.state = {{0, JournalEntry::Kind::CoilHeat, 0, 0.1}};
  return header;
}

std::string message(const TemporaryFolder& folder, const std::string& journal) {
  folder.write("take.wav", "");
  folder.write("take.jsonl", journal);
  const auto take = read_take(folder.path() / "take.wav");
  return folder.strip(test::summary(take));
}

}  // namespace

TEST_CASE("take: a header comes back as it was, to the last bit", "[take]") {
  const TemporaryFolder folder;
  const auto line = journal_line(full_header());
  folder.write("take.wav", "");
  folder.write("take.jsonl", line);
  const auto take = read_take(folder.path() / "take.wav");
  REQUIRE(take.has_value());
  const auto& header = take->header;
  CHECK(journal_line(header) == line);
  CHECK(header.input_scales == std::vector<double>{1.0 / 3.0});
  CHECK(header.guard[1].limits.slew_per_second == std::numeric_limits<double>::infinity());
  CHECK(header.guard[0].limits.heat->body_time == Seconds{4.5});
  CHECK(header.guard[1].kind == DriveGuard::Kind::Audio);
  CHECK(header.guard[0].feedback == FeedbackPath{true, false});
  CHECK(header.state == full_header().state);
  CHECK(header.files.texts == full_header().files.texts);
}

TEST_CASE("take: headers of formats 1 to 3 are read, those of a later format refused", "[take]") {
  const TemporaryFolder folder;
  const auto with_version = [](const std::string& version) {
    auto line = journal_line(full_header());
    const std::string now = "\"tactus_take\":4";
    return line.replace(line.find(now), now.size(), "\"tactus_take\":" + version);
  };
  for (const auto* version : {"1", "2", "3"}) CHECK(message(folder, with_version(version)).empty());
  for (const auto* version : {"0", "5"})
    CHECK(message(folder, with_version(version)) == "take.jsonl BadFile");
}

TEST_CASE("take: in formats 1 and 2 limiting counts as feedback, of drives, as it did then", "[take]") {
  const TemporaryFolder folder;
  auto line = journal_line(full_header());
  const auto limiting_counts = [&](int version, std::size_t channel) {
    line[line.find("\"tactus_take\":") + 14] = static_cast<char>('0' + version);
    folder.write("take.wav", "");
    folder.write("take.jsonl", line);
    return read_take(folder.path() / "take.wav")->header.guard[channel].feedback.limiting_counts;
  };
  for (const int version : {1, 2}) {
    CHECK(limiting_counts(version, 0));
    CHECK_FALSE(limiting_counts(version, 1));
  }
  CHECK_FALSE(limiting_counts(3, 0));
}

TEST_CASE("take: a number that no recording has is refused with its key", "[take]") {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& from, const std::string& to) {
    auto line = journal_line(full_header());
    const auto at = line.find(from);
    REQUIRE(at != std::string::npos);
    return message(folder, line.replace(at, from.size(), to));
  };
  const std::string padding = "\"padding_frames\":7";
  for (const auto* frames : {"-1", "441001", "2000000000"})
    CHECK(with(padding, std::string{"\"padding_frames\":"} + frames) ==
          "take.jsonl:1 BadFile 'padding_frames' " + std::string{frames} + " 0 441000");
  for (const auto* frames : {"3000000000", "1e99", "0.5", "\"many\"", "null"})
    CHECK(with(padding, std::string{"\"padding_frames\":"} + frames) ==
          "take.jsonl BadFile 'padding_frames'");
  CHECK(with("\"sample_rate_hz\":44100.0", "\"sample_rate_hz\":1e12") ==
        "take.jsonl:1 BadFile 'sample_rate_hz' 1000000000000 1000 768000");
  CHECK(with("\"system_delay_s\":0.02", "\"system_delay_s\":null") ==
        "take.jsonl:1 BadFile 'system_delay_s' 0 20");
}

TEST_CASE("take: limits are recorded with their sources, which earlier takes do not have", "[take]") {
  const TemporaryFolder folder;
  auto header = full_header();
  header.guard[0].origins = {{"ceiling", 0.8, "woofer", 0.5}, {"slew", 1000, "the built-in limits"}};
  auto line = journal_line(header);
  folder.write("take.wav", "");
  folder.write("take.jsonl", line);
  const auto take = read_take(folder.path() / "take.wav");
  REQUIRE(take);
  CHECK(take->header.guard[0].origins == header.guard[0].origins);
  const auto from = line.find(",\"origins\":["), to = line.find(']', from);
  REQUIRE(to != std::string::npos);
  CHECK(message(folder, line.erase(from, to + 1 - from)).empty());
}

TEST_CASE("take: a journal that breaks off in the middle of a line holds up to there", "[take]") {
  const TemporaryFolder folder;
  folder.write("take.wav", "");
  Take progress;
  progress.complete = 500;
  const JournalEntry entry{480, JournalEntry::Kind::ControlChange, 1, 0.1};
  const auto whole = journal_line(full_header()) + journal_line(entry) + journal_line(progress);
  const auto last = journal_line(JournalEntry{510, JournalEntry::Kind::Arm, -1, 1.0});
  for (std::size_t bytes = 0; bytes < last.size(); ++bytes) {
    folder.write("take.jsonl", whole + last.substr(0, bytes));
    const auto take = read_take(folder.path() / "take.wav");
    REQUIRE(take.has_value());
    CHECK(take->engine == std::vector<JournalEntry>{entry});
    CHECK(take->guard.size() == (bytes + 1 == last.size() ? 1 : 0));  // only its line end is missing
    CHECK(take->complete == 500);
    CHECK_FALSE(take->finished);
  }
}

TEST_CASE("take: what is no take says what it is", "[take]") {
  const TemporaryFolder folder;
  CHECK(folder.strip(test::summary(read_take(folder.path() / "none.wav"))) == "none.wav BadFile");
  folder.write("foreign.wav", "");
  CHECK(folder.strip(test::summary(read_take(folder.path() / "foreign.wav"))) ==
        "foreign.wav BadFile 'foreign.jsonl' --in");
  CHECK(message(folder, "") == "take.jsonl BadFile");
  CHECK(message(folder, "hello\n") == "take.jsonl BadFile");
  CHECK(message(folder, "{}\n") == "take.jsonl BadFile");
  CHECK(message(folder, "{\"tactus_take\": 5}\n") == "take.jsonl BadFile");
  CHECK(message(folder, journal_line(full_header()) + "rubbish\n" + journal_line(JournalEntry{})) ==
        "take.jsonl:2 BadFile");
}
