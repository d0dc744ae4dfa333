#include <catch2/catch.hpp>
#include <cmath>

#include "apps/cli/console.h"
#include "apps/play/live/plan.h"
#include "backends/wav_file.h"
#include "tests/support/desk.h"
#include "tests/support/temporary_folder.h"

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
  CHECK(limit_of(ran.json(), 0, "soft_start")["source"] == "profile 'strong.toml' of [actuators] shaker");
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
