#include "engine/rig/profile.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"
#include "tests/support/messages.h"

using namespace tactus;

namespace {

const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

constexpr const char* kActuator = R"(format = 1
name = "a shaker"
[drive]
resistance = "5 ohm"
peak = "8 V"
slew = "400 V/s"
soft_start = "0.2 s"
fade_out = "10 ms"
[heat]
power = "20 W"
coil_time = "3 s"
body_time = "400 s"
coil_share = 0.6
rise = 100
[travel]
limit = "4 mm"
mass = "100 g"
stiffness = "2.5 N/mm"
damping = "3 kg/s"
force_factor = "5 T m"
[direct]
level = "2 V"
time = "5 s"
)";

test::Messages mistakes(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  const auto profile = parse_profile(text.replace(at, from.size(), to), "shaker.toml");
  return profile ? "" : to_string(profile.error());
}

/// The mistakes of a scene of the haptic drum with this [drives].
test::Messages drives_mistakes(const std::string& drives) {
  const auto scene =
      parse_scene_leniently(R"(format = 1
duration = "1 s"
[drives]
)" + drives + R"(
[parts]
instrument = { use = "instrument.toml", microphone = "plant.microphone" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0, press = 0.3 }
)",
                            (kInstruments / "haptic_drum" / "test.toml").string(), kInstruments);
  const auto built = build_scene(scene, standard_nodes());
  if (built) return "";
  auto text = to_string(built.error());
  const auto folder = (kInstruments / "haptic_drum").string() + "/";
  for (auto at = text.find(folder); at != text.npos; at = text.find(folder)) text.erase(at, folder.size());
  return text;
}

}  // namespace

TEST_CASE("profile: volts, newtons and grams become limits at full scale", "[scene]") {
  const auto profile = parse_profile(kActuator, "shaker.toml");
  REQUIRE(profile);
  const auto limits = limits_for(*profile, 16.0);
  CHECK(limits.ceiling == 0.5);           // 8 V of 16
  CHECK(limits.slew_per_second == 25.0);  // 400 V/s of 16
  CHECK(limits.soft_start == 0.2_s);
  CHECK(limits.heat->watts_at_full_scale == 51.2);  // 16²/5
  CHECK(limits.heat->watts_for_ever == 20.0);
  // A held 16 V pushes with 5 T m * 16 V / 5 ohm = 16 N, against 2.5 N/mm.
  CHECK(limits.excursion->metres_at_full_scale == Approx(6.4e-3).epsilon(1e-12));
  CHECK(limits.excursion->resonance.value ==
        Approx(std::sqrt(2500 / 0.1) / 6.283185307179586).epsilon(1e-12));
  CHECK(limits.excursion->q == Approx(std::sqrt(2500 * 0.1) / (3 + 25.0 / 5)).epsilon(1e-12));
  CHECK(limits.dc.level == 0.125);
  CHECK(limits_for(*profile, 4.0).ceiling == 1.0);  // the converter cannot reach the peak
  CHECK(check(limits).has_value());
}

TEST_CASE("profile: mistakes are told with their place", "[scene]") {
  CHECK(mistakes(kActuator, "\"5 ohm\"", "\"5 V\"") ==
        "shaker.toml:4:14: '5 V' is in V, but 'resistance' is in ohm; give \"6 ohm\"");
  CHECK(mistakes(kActuator, "peak = \"8 V\"\n", "") ==
        "shaker.toml:3:1: [drive] lacks 'peak'; give 'peak': largest voltage, in V");
  CHECK(mistakes(kActuator, "peak", "peek") ==
        "shaker.toml:3:1: [drive] lacks 'peak'; give 'peak': largest voltage, in V\nshaker.toml:5:1: unknown "
        "key 'peek'; did you "
        "mean 'peak'?");
  CHECK(mistakes(kActuator, "0.6", "1.5") ==
        "shaker.toml:13:14: 'coil_share' cannot be 1.5; it runs from 0.01 to 0.99");
  CHECK(mistakes(kActuator, "[heat]", "[hat]").find("unknown key 'hat'; did you mean 'heat'?") !=
        std::string::npos);
  CHECK(mistakes("format = 1\nname = \"x\"\n", "x", "y") ==
        "shaker.toml:1:1: the profile lacks [drive]; give [drive]: limits at the terminals");
}

TEST_CASE("profile: every shipped one can be read, says where its figures are from, and makes sense",
          "[scene]") {
  int profiles = 0;
  for (const auto& file : std::filesystem::directory_iterator(kInstruments / "profiles")) {
    INFO(file.path().string());
    ++profiles;
    const auto profile = load_profile(file.path());
    INFO((profile ? std::string{} : to_string(profile.error())));
    REQUIRE(profile);
    const auto written = load_toml(file.path());
    for (const auto* key : {"source", "about"}) CHECK_FALSE(find(*written, key)->text()->empty());
    for (const double volts : {1.0, 5.0, profile->at("drive.peak"), 40.0})
      CHECK(check(limits_for(*profile, volts)));
    CHECK(find_profile(file.path().stem().string(), kInstruments, "test"));
  }
  CHECK(profiles == 7);
  CHECK(to_string(find_profile("wofer", kInstruments, "test").error()) ==
        "test: there is no profile 'wofer'; did you mean 'woofer'?");
}

TEST_CASE("profile: only the command line raises a limit, and only up", "[scene]") {
  auto limits = conservative_limits();
  CHECK(raise_limit(limits, "ceiling", "0.8", "--raise-limit"));
  CHECK(limits.ceiling == 0.8);
  CHECK(raise_limit(limits, "direct_time", "20 s", "--raise-limit"));
  CHECK(limits.dc.time == 20_s);
  CHECK(to_string(raise_limit(limits, "ceiling", "0.7", "--raise-limit").error()) ==
        "--raise-limit: 'ceiling' is already 0.8; a limit can only be raised here");
  CHECK(to_string(raise_limit(limits, "ceiling", "1.2", "--raise-limit").error()) ==
        "--raise-limit: the ceiling of a drive must be above 0 and at most 1 full scale; give it as a "
        "fraction of the converter's full scale");
  CHECK(to_string(raise_limit(limits, "travel", "8 mm", "--raise-limit").error()) ==
        "--raise-limit: this drive has no limit on 'travel' to raise; remove it");
  CHECK(to_string(raise_limit(limits, "volume", "11", "--raise-limit").error())
            .find("there is no limit 'volume'") != std::string::npos);
}

TEST_CASE("profile: a scene says what its drives move, may ask for less, and not for more", "[scene]") {
  CHECK(drives_mistakes(R"(woofer = { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.7 })") ==
        "");
  CHECK(drives_mistakes("woofer = { ceiling = 0.3 }") == "");
  CHECK(drives_mistakes("woofer = { ceiling = 0.8 }") ==
        "test.toml:4:22: a file cannot raise a limit: the ceiling of 'woofer' is 0.5; lower it, or use "
        "--raise-limit ceiling=0.8 on the command line");
  CHECK(drives_mistakes(R"(woofer = { profile = "wofer", volts_per_full_scale = "10 V" })") ==
        "test.toml:4:22: there is no profile 'wofer'; did you mean 'woofer'?");
  CHECK(drives_mistakes(R"(woofer = { profile = "woofer" })") ==
        "test.toml:4:1: drive 'woofer' lacks 'volts_per_full_scale'; give both 'profile' and "
        "'volts_per_full_scale', or neither");
  CHECK(drives_mistakes("wofer = { ceiling = 0.3 }") ==
        "test.toml:4:1: the instrument has no drive 'wofer'; did you mean 'woofer'?");
  CHECK(drives_mistakes("sound = { ceiling = 0.3 }") ==
        "test.toml:4:1: the instrument has no drive 'sound'; it has 'woofer'");
}

TEST_CASE("profile: no shipped scene needs its guard but the one that explodes, and none fades", "[scene]") {
  int scenes = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(kInstruments)) {
    if (file.path().extension() != ".toml") continue;
    const auto table = load_toml(file.path());
    REQUIRE(table);
    if (find(*table, "parts") == nullptr) continue;
    INFO(file.path().string());
    ++scenes;
    const auto scene = load_scene(file.path(), kInstruments);
    REQUIRE(scene);
    auto built = build_scene(*scene, standard_nodes());
    REQUIRE(built);
    const auto played = play_scene(*scene, *built, 64);
    REQUIRE(played);
    INFO((played->guard.idle() ? "" : describe(played->guard, played->sample_rate).front()));
    const bool explodes = file.path().parent_path().filename() == "exploding";
    CHECK(played->guard.idle() == !explodes);
  }
  CHECK(scenes >= 4);
}
