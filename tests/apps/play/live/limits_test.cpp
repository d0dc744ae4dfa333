#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

#include "apps/cli/console.h"
#include "apps/play/live/plan.h"
#include "backends/wav_file.h"
#include "engine/rig/profile.h"
#include "tests/support/desk.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/terminal_process.h"

using namespace tactus;

namespace {

constexpr const char* kInstrument = R"(format = 1
name = "constant"
[inputs]
microphone = {}
[outputs]
drive = { from = "0.9 + 0 * microphone" }
sound = { from = "0.9 + 0 * microphone", kind = "audio" }
)";

constexpr const char* kRig = R"(format = 1
[device]
output = "loop:20ms"
[inputs]
microphone = { channel = 1 }
[outputs]
drive = { channel = 1, ceiling = 0.05 }
sound = { channel = 2, ceiling = 0.1 }
[actuators]
shaker = { channel = 1, profile = "strong.toml", volts_per_full_scale = "1 V" }
)";

constexpr const char* kProfile = R"(format = 1
name = "strong"
[drive]
resistance = "8 ohm"
peak = "1 V"
soft_start = "50 ms"
fade_out = "5 ms"
)";

void write_files(const test::TemporaryFolder& folder) {
  folder.write("constant.toml", kInstrument);
  folder.write("desk.toml", kRig);
  folder.write("strong.toml", kProfile);
}

}  // namespace

TEST_CASE("live limits: no option replaces what the rig says of device, channels and actuators", "[live]") {
  const test::TemporaryFolder folder;
  write_files(folder);
  app::LiveOptions options;
  options.target = (folder.path() / "constant.toml").string();
  options.rig = (folder.path() / "desk.toml").string();
  const auto refused = [&](const app::LiveOptions& given) {
    try {
      (void)app::make_plan(given);
    } catch (const app::CommandError& error) {
      return std::pair{error.errors.front().where, app::report(error)};
    }
    return std::pair{std::string{}, 0};
  };
  CHECK(refused(options).second == 0);
  auto profile = options, volts = options, backend = options, device = options;
  profile.guard.profile = "voice_coil";
  profile.guard.volts = volts.guard.volts = "1";
  backend.backend = "loop";
  device.device = "loop:cable";
  CHECK(refused(profile) == std::pair{std::string{"--profile"}, int{app::kUsage}});
  CHECK(refused(volts) == std::pair{std::string{"--volts-per-full-scale"}, int{app::kUsage}});
  CHECK(refused(backend) == std::pair{std::string{"--backend"}, int{app::kUsage}});
  CHECK(refused(device) == std::pair{std::string{"--device"}, int{app::kUsage}});

  auto saved = options;
  saved.save_rig = std::exchange(saved.rig, {});
  auto in = saved, out = saved;
  in.in_channels = {2};
  out.out_channels = {2, 1};
  CHECK(refused(in) == std::pair{std::string{"--inputs"}, int{app::kUsage}});
  CHECK(refused(out) == std::pair{std::string{"--outputs"}, int{app::kUsage}});
}

namespace {

/// Of an output in the guard's report.
nlohmann::json limit_of(const nlohmann::json& report, std::size_t output, const std::string& name) {
  for (const auto& limit : report["limits"][output]["limits"])
    if (limit["limit"] == name) return limit;
  return {};
}

double highest(const std::vector<double>& samples) {
  double most = 0;
  for (const double sample : samples) most = std::max(most, std::abs(sample));
  return most;
}

}  // namespace

TEST_CASE("live limits: the lowest of a rig counts for drives and sound, and is reported", "[live]") {
  const test::Desk desk;
  write_files(desk.folder);
  const auto ran =
      desk.run("play constant.toml --rig desk.toml --arm --duration '1 s' --record take.wav --json");
  INFO(ran.out << ran.err);
  REQUIRE(ran.exit == 0);
  const auto take = read_wav(desk.file("take.wav"));
  REQUIRE(take);
  REQUIRE(take->channels.size() == 3);
  REQUIRE(take->frames() > 0);
  CHECK(highest(take->channels[1]) <= 0.05 + 1e-9);
  CHECK(highest(take->channels[2]) <= 0.1 + 1e-8);
  // Neither begins at its ceiling.
  CHECK(std::abs(take->channels[2].front()) < 0.01);
  CHECK(limit_of(ran.json(), 0, "ceiling")["source"] == "[outputs] drive");
  CHECK(limit_of(ran.json(), 0, "soft_start")["source"] ==
        "profile 'strong.toml' (strong.toml) of [actuators] shaker");
  CHECK(limit_of(ran.json(), 1, "ceiling")["value"] == 0.1);
  CHECK(ran.err.find("drive: ceiling 0.05 of [outputs] drive") != std::string::npos);
  CHECK(desk.run("render --replay take.wav").exit == 0);
}

TEST_CASE("live limits: a raised limit is announced, reported and recorded", "[live]") {
  const test::Desk desk;
  write_files(desk.folder);
  const auto ran = desk.run(
      "play constant.toml --rig desk.toml --raise-limit sound.ceiling=0.3 --duration '0.2 s' --record "
      "take.wav "
      "--json");
  INFO(ran.out << ran.err);
  REQUIRE(ran.exit == 0);
  CHECK(ran.err.find("warning: sound: the limit 'ceiling' is raised from 0.1 ([outputs] sound) to 0.3") !=
        std::string::npos);
  CHECK(limit_of(ran.json(), 1, "ceiling")["raised_from"] == 0.1);
  CHECK_FALSE(limit_of(ran.json(), 0, "ceiling").contains("raised_from"));
  const auto journal = test::text_of(desk.file("take.jsonl"));
  const auto header = nlohmann::json::parse(journal.substr(0, journal.find('\n')));
  CHECK(header["guard"][1]["origins"][0]["raised_from"] == 0.1);
  CHECK(header["guard"][1]["ceiling"] == 0.3);
  const auto text =
      desk.run("play constant.toml --rig desk.toml --raise-limit drive.ceiling=0.3 --duration '0.1 s'");
  CHECK(text.out.find("drive: the limit 'ceiling' is raised from 0.05") != std::string::npos);
  test::check_exit(desk.run("play constant.toml --rig desk.toml --raise-limit drive.ceiling=0.04"), 2,
                   "--raise-limit 'ceiling' 0.05");
}

namespace {

/// kProfile with another peak.
std::string profile_with_peak(const std::string& volts) {
  std::string text = kProfile;
  return text.replace(text.find("1 V"), 3, volts);
}

}  // namespace

TEST_CASE("live limits: an instrument's folder has no say in the profiles of a rig and of --profile",
          "[live]") {
  const test::Desk desk;
  desk.folder.write("stranger/constant.toml", kInstrument);
  for (const auto* name : {"tactor_lra", "mine", "foreign"})
    desk.folder.write("stranger/profiles/" + std::string{name} + ".toml", profile_with_peak("1000 V"));
  desk.folder.write("desk/profiles/mine.toml", profile_with_peak("0.5 V"));
  desk.folder.write("profiles/tactor_lra.toml", profile_with_peak("1000 V"));
  const auto play = [&](const std::string& profile) {
    desk.folder.write("desk/rig.toml",
                      "format = 1\n[device]\noutput = \"loop:20ms\"\n[inputs]\nmicrophone = { channel = 1 }\n"
                      "[outputs]\nsound = { channel = 2 }\ndrive = { channel = 1, profile = \"" +
                          profile + "\", volts_per_full_scale = \"10 V\" }\n");
    return desk.run("play stranger/constant.toml --rig desk/rig.toml --duration '0.1 s' --json");
  };
  const auto shipped = load_profile(TACTUS_SOURCE_DIR "/instruments/profiles/tactor_lra.toml");
  const auto ceiling = shipped->at("drive.peak") / 10;
  const auto of_shipped = play("tactor_lra"), of_user = play("mine");
  INFO(of_shipped.err << of_user.err);
  CHECK(limit_of(of_shipped.json(), 0, "ceiling")["value"].get<double>() == Approx(ceiling));
  CHECK(of_shipped.err.find("instruments/profiles/tactor_lra.toml) of [outputs] drive") != std::string::npos);
  CHECK(limit_of(of_user.json(), 0, "ceiling")["value"] == 0.05);
  CHECK(of_user.err.find("(desk/profiles/mine.toml)") != std::string::npos);
  test::check_exit(play("foreign"), 3, "rig.toml:8 'foreign'");
  test::check_exit(desk.run("latency measure --rig desk/rig.toml"), 3, "rig.toml:8 'foreign'");
  test::check_exit(desk.run("check stranger/constant.toml --rig desk/rig.toml"), 3, "rig.toml:8 'foreign'");

  const std::string option =
      "play stranger/constant.toml --device loop:20ms --duration '0.1 s' --json --volts-per-full-scale 10 "
      "--profile ";
  const auto by_option = desk.run(option + "tactor_lra");
  INFO(by_option.err);
  CHECK(limit_of(by_option.json(), 0, "ceiling")["value"].get<double>() == Approx(ceiling));
  test::check_exit(desk.run(option + "foreign"), 2, "--profile 'foreign'");
}

TEST_CASE("live limits: a raise without the name of its output is refused, not for every drive", "[live]") {
  const test::Desk desk;
  write_files(desk.folder);
  test::check_exit(
      desk.run("play constant.toml --rig desk.toml --raise-limit .ceiling=0.3 --duration '0.1 s'"), 2,
      "--raise-limit '.ceiling=0.3' OUTPUT.ceiling=0.3");
}

TEST_CASE("live limits: saving controls keeps a limit that was edited meanwhile", "[live]") {
  const test::Desk desk;
  write_files(desk.folder);
  test::TerminalProcess play{{TACTUS_PROGRAM, "play", desk.file("constant.toml").string(), "--rig",
                              desk.file("desk.toml").string()}};
  REQUIRE(play.shows("the drives are disarmed"));
  std::string text = kRig;
  text.replace(text.find("0.05"), 4, "0.01");
  desk.folder.write("desk.toml", text);
  play.type("s");
  CHECK(play.shows("controls and what moves them saved"));
  play.type("q");
  CHECK(play.wait() == 0);
  CHECK(test::text_of(desk.file("desk.toml")).find("ceiling = 0.01") != std::string::npos);
}

TEST_CASE("live limits: a rig that was just saved protects its actuators at once", "[live]") {
  const test::Desk desk;
  write_files(desk.folder);
  // Channel and full scale of the microphone; channel, profile and volts of the drive; channel of the sound.
  const auto ran =
      desk.run("play constant.toml --device loop:20ms --save-rig new.toml --duration '0.1 s' --json", {},
               "1\nunknown\n1\nstrong.toml\n5 V\n2\n");
  INFO(ran.out << ran.err);
  REQUIRE(ran.exit == 0);
  CHECK(limit_of(ran.json(), 0, "ceiling")["value"] == 0.2);  // 1 V of 5 V
}
