#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <sstream>
#include <thread>

#include "engine/rig/profile.h"
#include "tests/backends/take/performance.h"
#include "tests/conformance/random_graph.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/busy_graph.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

namespace {

const std::string kOutputs = R"([outputs]
y0 = { from = "all" }
y1 = { from = "back" }
y2 = { from = "tuned", kind = "audio" }
)";

DriveLimits woofer() {
  const std::filesystem::path folder{TACTUS_SOURCE_DIR "/instruments"};
  return limits_for(must(load_profile(must(find_profile("woofer", {folder}, {})))), 10);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("no '" + from + "' in the text");
  return text.replace(at, from.size(), to);
}

/// The busy graph with another constant, another structure, another control, and as it was.
std::string edited_busy_graph(int version) {
  const auto text = kBusyGraph + kOutputs;
  if (version % 4 == 1) return replaced(text, "\"12 ms\"", "\"9 ms\"");
  if (version % 4 == 2) return replaced(text, "in = \"combs\"", "in = \"0.5 * combs + 0.1 * x\"");
  if (version % 4 == 3)
    return replaced(replaced(text, "[controls]\n", "[controls]\nextra = { value = 0.2, range = [-1, 1] }\n"),
                    "0.9 * damped", "0.9 * extra * damped");
  return text;
}

/// What is wired back comes back more softly, and a little of an input with it.
std::string edited_random_graph(const std::string& text, int version) {
  if (version % 2 == 0) return text;
  const std::string begin = "later0 = \"";
  const auto from = text.find(begin) + begin.size(), to = text.find('"', from);
  return text.substr(0, from) + "0.5 * (" + text.substr(from, to - from) + ") + 0.1 * x1" + text.substr(to);
}

/// "" or in which way the replay is not the same.
std::string complaint(unsigned seed, const TemporaryFolder& folder) {
  const auto wav = folder.path() / ("take" + std::to_string(seed) + ".wav");
  const int lanes = 2 + static_cast<int>(seed % 3);
  folder.write("part.toml", RandomGraph{seed + 1000000, lanes}.text(true));
  const auto text = RandomGraph{seed, lanes}.text(false);
  Performance performance{folder.write("test.toml", text), wav, seed, {{DriveGuard::Kind::Drive, woofer()}}};
  performance.play(6000, [&](int version) { return edited_random_graph(text, version); });
  if (const auto words = performance.finish(); !words.empty()) return words.front();
  folder.write("part.toml", "changed since");
  const auto again = replay_of(wav, {1 + static_cast<int>(seed * 37 % 500), 64, 7});
  if (again.replayed.frames != 6000) return "not whole";
  return again.same() ? "" : again.verdict() + "\n" + text;
}

/// The journal of a take of format 1, as docs/takes.md describes it. Its guard limits nothing but the ramps:
/// 960 frames up, 480 down.
std::string old_journal(int format) {
  return replaced(R"({"tactus_take": FORMAT, "program": "0.1", "sample_rate_hz": 48000,)", "FORMAT",
                  std::to_string(format)) +
         R"( "inputs": ["x"], "outputs": ["y"], "controls": ["g"], "settings": {"g": 0.5}, "taps": [],)"
         R"( "system_delay_s": 0, "armed": true, "soft_start": true, "trusted_sensors": true, "state": [],)"
         R"( "guard": [{"ceiling": 1, "slew_per_second": null, "soft_start_s": 0.02, "fade_out_s": 0.01,)"
         R"( "direct": {"level": 1, "time_s": 0}, "kind": "audio"}], "rig": "", "left_out": [],)"
         R"( "input_scales": [0.5], "padding_frames": 0, "files": {"main": "gain.toml", "root": ".",)"
         R"( "texts": {"gain.toml": "format = 1\n[inputs]\nx = {}\n[controls]\ng = { value = 1,)"
         R"( range = [0, 1], smooth = \"0 ms\" }\n[outputs]\ny = { from = \"g * x\", kind = \"audio\" }\n"},)"
         R"( "sounds": {}}}
{"frame": 1500, "kind": "control", "index": 0, "value": 0.25}
{"frame": 2000, "kind": "mute", "index": 0, "value": 1}
{"frame": 2500, "kind": "complete", "lost_entries": 0, "rounded_sensors": 0}
{"frame": 3000, "kind": "mute", "index": 0, "value": 0}
{"frame": 5000, "kind": "end", "lost_entries": 0, "rounded_sensors": 0, "why": ""}
)";
}

/// The ramps of the guard in `old_journal`.
double old_gain(int frame) {
  if (frame < 960) return frame / 960.0;
  if (frame < 2000) return 1;
  if (frame < 2480) return 1 - (frame - 2000) / 480.0;
  return frame < 3000 ? 0 : std::min(1.0, (frame - 3000) / 960.0);
}

}  // namespace

TEST_CASE("takes: one of format 1 plays to its end, and is input times control times ramps", "[take]") {
  const auto format = GENERATE(1, 2, 3);
  CAPTURE(format);
  std::vector<double> x, y;
  for (int n = 0; n < 5000; ++n) {
    x.push_back((n * 37 % 2001 - 1000) / 1024.0);
    const double before_guard = (n < 1500 ? 0.5 : 0.25) * (0.5 * x.back());
    y.push_back(static_cast<double>(as_recorded(before_guard * old_gain(n))));
  }
  const TemporaryFolder folder;
  const auto wav = folder.path() / "old.wav";
  must(write_wav(wav, {48_kHz, {x, y}}));
  folder.write("old.jsonl", old_journal(format));
  const auto again = replay_of(wav, {GENERATE(1, 64, 997)});
  INFO(again.verdict());
  CHECK(again.take.finished);
  CHECK(again.replayed.frames == 5000);
  CHECK(again.same());
  REQUIRE(again.drives.size() == 1);
  REQUIRE(again.drives[0].size() == 5000);
  for (std::size_t n = 0; n < 5000; ++n) {
    CAPTURE(n);
    REQUIRE(static_cast<double>(as_recorded(again.drives[0][n])) == y[n]);
  }
}

TEST_CASE("takes: drives of random graphs are the same bit for bit, edits and all", "[take][slow]") {
  const TemporaryFolder folder;
  copy_files(folder);
  const unsigned first = 1, last = 60;
  for (unsigned seed = first; seed <= last; ++seed) {
    INFO("seed " << seed);
    REQUIRE(complaint(seed, folder) == "");
  }
}

TEST_CASE("takes: so are those of 3000 random graphs", "[.soak]") {
  const TemporaryFolder folder;
  copy_files(folder);
  for (unsigned seed = 1000; seed < 4000; ++seed) {
    INFO("seed " << seed);
    REQUIRE(complaint(seed, folder) == "");
    std::filesystem::remove(folder.path() / ("take" + std::to_string(seed) + ".wav"));
  }
}

TEST_CASE("takes: sensors that fall out, stops and guards that heat are in it", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  const unsigned seed = GENERATE(1u, 2u, 3u, 4u, 5u, 6u);
  Performance performance{
      folder.write("test.toml", kBusyGraph + kOutputs),
      wav,
      seed,
      {{DriveGuard::Kind::Drive, woofer()}, {DriveGuard::Kind::Drive, conservative_limits()}}};
  performance.play(60000, edited_busy_graph);
  CHECK(performance.finish().empty());
  bool railed = false;
  for (GuardEvent event; performance.guarded().take_event(event);)
    railed = railed || event.kind == GuardEvent::Kind::SensorRailed;
  CHECK(railed);

  const auto again = replay_of(wav, {GENERATE(1, 256, 4096)});
  CHECK(again.take.edits.size() > 10);
  CHECK(again.replayed.frames == 60000);
  INFO(again.verdict());
  CHECK(again.same());
}

TEST_CASE("takes: a dead man's switch that expired, resumed and disarmed is in it", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  Performance performance{
      folder.write("test.toml", kBusyGraph + kOutputs), wav, 4, {{DriveGuard::Kind::Drive, woofer()}}};
  using Kind = GuardEvent::Kind;
  std::vector<Kind> kinds;
  const auto play = [&](int frames, bool refreshes) {
    performance.refreshes = refreshes;
    performance.play(frames);
    for (GuardEvent event; performance.guarded().take_event(event);)
      if (event.kind == Kind::DeadMan || event.kind == Kind::DeadManDisarmed) kinds.push_back(event.kind);
  };
  play(20'000, true);
  play(30'000, false);
  play(20'000, true);
  play(260'000, false);
  play(10'000, true);
  CHECK(performance.finish().empty());
  CHECK(kinds == std::vector{Kind::DeadMan, Kind::DeadMan, Kind::DeadManDisarmed});
  const auto again = replay_of(wav, {GENERATE(1, 64, 997)});
  INFO(again.verdict());
  CHECK(again.replayed.frames == 340'000);
  CHECK(again.same());
}

TEST_CASE("takes: a change that is left out of the journal shows where it was", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  const auto text =
      "format = 1\nname = \"gain\"\n[inputs]\nx = {}\n[controls]\n"
      "g = { value = 0.1, range = [0, 0.5], smooth = \"0 ms\" }\n[outputs]\ny = { from = \"x * g\" }\n";
  Performance performance{folder.write("test.toml", text), wav, 2, {{DriveGuard::Kind::Drive, {}}}};
  REQUIRE(performance.engine().post({777, JournalEntry::Kind::ControlChange, 0, 0.4}));
  for (int n = 0; n < 10; ++n) performance.block(200);
  CHECK(performance.finish().empty());
  CHECK(replay_of(wav, {64}).same());

  std::ifstream file{journal_path(wav)};
  std::stringstream kept;
  for (std::string line; std::getline(file, line);)
    if (line.find("\"control\"") == std::string::npos) kept << line << "\n";
  std::ofstream{journal_path(wav)} << kept.str();
  const auto again = replay_of(wav, {64});
  CHECK_FALSE(again.same());
  REQUIRE(again.replayed.first_difference.has_value());
  CHECK(again.replayed.first_difference->frame == 777);
  CHECK(test::names_in(again.verdict()).starts_with("0.0162 777 'y' "));
}

TEST_CASE("takes: one that was cut anywhere is the same up to there", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav", journal = journal_path(wav);
  Performance performance{
      folder.write("test.toml", kBusyGraph + kOutputs), wav, 5, {{DriveGuard::Kind::Drive, woofer()}}};
  for (int n = 0; n < 12; ++n) {
    performance.play(10000, edited_busy_graph);
    while (performance.recorder().status().recorded < Seconds{(n + 1) * 10000 / 48000.0})
      std::this_thread::yield();
  }
  CHECK(performance.finish().empty());
  const auto bytes = std::filesystem::file_size(journal);
  std::int64_t last = 120000;
  for (const auto percent : {99u, 90u, 75u, 50u, 25u}) {
    std::filesystem::resize_file(journal, bytes * percent / 100);
    const auto again = replay_of(wav, {128});
    INFO(again.verdict());
    CHECK(again.same());
    CHECK_FALSE(again.take.finished);
    CHECK(again.replayed.frames <= last);
    last = again.replayed.frames;
  }
  CHECK(last < 120000);
}

TEST_CASE("takes: one with a gap is played, but not called the same", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  Performance performance{folder.write("test.toml", kBusyGraph + kOutputs), wav, 4};
  performance.play(5000);
  CHECK(performance.finish().empty());
  std::ofstream{journal_path(wav), std::ios::app} << journal_line(TakeGap{4999, 1});
  const auto again = replay_of(wav, {64});
  CHECK(again.replayed.frames == 5000);
  CHECK_FALSE(again.same());
  CHECK(test::names_in(again.verdict()) == "0.104");
}

TEST_CASE("takes: a WAV of another take is refused", "[take]") {
  const TemporaryFolder folder;
  const auto wav = folder.path() / "take.wav";
  Performance performance{folder.write("test.toml", kBusyGraph + kOutputs), wav, 4};
  performance.play(500);
  CHECK(performance.finish().empty());
  must(write_wav(wav, {44100_Hz, {{0.0}}}));
  CHECK_THROWS_WITH(replay_of(wav, {64}),
                    Catch::Contains(" 1 channels at 44100 Hz") && Catch::Contains(" 5 at 48000 Hz"));
}

TEST_CASE("takes: what a restart leaves warm, muted or disarmed is in it", "[take]") {
  const TemporaryFolder folder;
  const auto graph = folder.write("test.toml", kBusyGraph + kOutputs);
  const StreamFormat format{Performance::kRate, 2, 3, 256};
  Player engine{must(compile(load_graph_leniently(graph), standard_nodes(), {}))};
  Guarded first{engine, {{DriveGuard::Kind::Drive, woofer()}}};
  must(first.prepare(format));
  REQUIRE(first.post({0, JournalEntry::Kind::CoilHeat, 0, 0.5}));
  REQUIRE(first.post({0, JournalEntry::Kind::Mute, 1, 1.0}));
  REQUIRE(first.post({0, JournalEntry::Kind::Arm, 2, 0.0}));
  std::vector<double> silence(256), spare(256);
  const std::vector<const double*> in{silence.data(), silence.data()};
  const std::vector<double*> out{spare.data(), spare.data(), spare.data()};
  first.process({in.data(), out.data(), 256});

  Guarded second{engine, {{DriveGuard::Kind::Drive, woofer()}}};
  must(second.prepare(format));
  for (const auto& entry : first.state()) REQUIRE(second.post(entry));
  second.process({in.data(), out.data(), 1});
  CHECK(second.state().size() == first.state().size());
  CHECK(first.state().size() == 4);
}

TEST_CASE("takes: another instrument hears the sensors of its own names, and its controls move", "[take]") {
  TakeHeader header;
  header.inputs = {"microphone", "ribbon"};
  CHECK(app::sensors_for(header, {"ribbon", "piezo", "microphone"}) == std::vector<int>{1, -1, 0});

  Take take;
  take.header.controls = {"strength", "gone", "pitch"};
  for (const int control : {0, 1, 2})
    take.engine.push_back({5, JournalEntry::Kind::ControlChange, control, 1.0});
  const TemporaryFolder folder;
  const auto graph =
      folder.write("test.toml",
                   "format = 1\n[inputs]\nx = {}\n[controls]\npitch = { value = 0, range = [0, 1] }\n"
                   "strength = { value = 0, range = [0, 1] }\n[outputs]\n"
                   "y = { from = \"x * strength * pitch\" }\n");
  const Player engine{must(compile(load_graph_leniently(graph), standard_nodes(), {}))};
  const auto entries = app::journal_for(take, engine);
  REQUIRE(entries.size() == 2);
  CHECK(entries[0].index == engine.control_index("strength"));
  CHECK(entries[1].index == engine.control_index("pitch"));
}

TEST_CASE("takes: ports that a rig left out are left out again", "[take]") {
  Rig rig;
  rig.inputs.emplace_back().name = "x";
  rig.inputs.back().channels = {1};
  rig.inputs.emplace_back().name = "spare";
  rig.outputs.emplace_back().name = "sound";
  TakeHeader header;
  app::add_rig(rig, "text", header);
  CHECK(header.left_out == std::vector<std::string>{"spare", "sound"});
  header.files = {"a.toml",
                  {{"a.toml",
                    "format = 1\n[inputs]\nx = {}\nspare = {}\n[outputs]\ny = { from = \"x + spare\" }\n"
                    "sound = { from = \"spare\", kind = \"audio\" }\n"}},
                  {},
                  ""};
  const auto plan = must(app::compile_take(header, header.files, {}));
  CHECK(plan->input_names == std::vector<std::string>{"x"});
  CHECK(output_names(*plan) == std::vector<std::string>{"y"});
}

TEST_CASE("takes: a take that would write outside of its folder is refused", "[take]") {
  const TemporaryFolder folder;
  const auto refused = [&](const TakeFiles& files) {
    const auto file = app::unpack(files, folder.path() / "inside");
    return test::summary(file);
  };
  CHECK(refused({"a.toml", {{"a.toml", ""}, {"../b.toml", ""}}, {}, ""}) == "../b.toml BadFile");
  CHECK(refused({"a.toml", {{"/b.toml", ""}}, {}, ""}) == "/b.toml BadFile");
  CHECK(refused({"a.toml", {{"parts/../../b.toml", ""}}, {}, ""}) == "parts/../../b.toml BadFile");
  CHECK_FALSE(std::filesystem::exists(folder.path() / "b.toml"));
}

TEST_CASE("takes: a sound file that changed is an error", "[take]") {
  const TemporaryFolder folder;
  folder.write("hit.wav", "old");
  const auto graph = folder.write("test.toml",
                                  "format = 1\n[inputs]\nx = {}\n[nodes]\ns = { type = \"sample\", file = "
                                  "\"hit.wav\", trigger = \"x\" }\n"
                                  "[outputs]\ny = { from = \"s\" }\n");
  const auto files = app::take_files(load_graph_leniently(graph), standard_nodes(), folder.path());
  CHECK(files.sounds.size() == 1);
  CHECK(app::unpack(files, folder.path() / "again").has_value());
  folder.write("hit.wav", "new");
  const auto gone = app::unpack(files, folder.path() / "again");
  REQUIRE_FALSE(gone.has_value());
  CHECK(folder.strip(test::summary(gone)) == "hit.wav BadFile");
}
