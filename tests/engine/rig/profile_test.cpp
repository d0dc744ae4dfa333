#include "engine/rig/profile.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/optional_files.h"
#include "tests/support/temporary_folder.h"

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

std::string errors_of(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  const auto profile = parse_profile(text.replace(at, from.size(), to), "shaker.toml");
  return test::summary(profile);
}

/// The errors of a scene of the haptic drum with this [drives].
std::string drive_errors(const std::string& drives) {
  const auto scene =
      parse_scene_leniently(R"(format = 1
duration = "1 s"
[drives]
)" + drives + R"(
[parts]
instrument = { use = "instrument.toml", microphone = "plant.microphone" }
plant = { use = "plant.toml", drive = "instrument.woofer", lift = 0, press = 0.3 }
)",
                            (kInstruments / "haptic_drum" / "test.toml").generic_string(), kInstruments);
  const auto built = build_scene(scene, standard_nodes());
  auto text = test::summary(built);
  const auto folder = (kInstruments / "haptic_drum").generic_string() + "/";
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

TEST_CASE("profile: errors have their place", "[scene]") {
  CHECK(errors_of(kActuator, "\"5 ohm\"", "\"5 V\"") ==
        R"(shaker.toml:4:14 UnitMismatch '5 V' 'resistance' "6 ohm")");
  CHECK(errors_of(kActuator, "peak = \"8 V\"\n", "") == "shaker.toml:3:1 Missing [drive] 'peak' 'peak'");
  CHECK(errors_of(kActuator, "peak", "peek") ==
        R"(shaker.toml:3:1 Missing [drive] 'peak' 'peak'
shaker.toml:5:1 UnknownName 'peek' 'peak')");
  CHECK(errors_of(kActuator, "0.6", "1.5") == "shaker.toml:13:14 OutOfRange 'coil_share' 1.5 0.01 0.99");
  CHECK(errors_of(kActuator, "[heat]", "[hat]") == "shaker.toml:9:2 UnknownName 'hat' 'heat'");
  CHECK(errors_of("format = 1\nname = \"x\"\n", "x", "y") == "shaker.toml:1:1 Missing [drive] [drive]");
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
    CHECK(find_profile(file.path().stem().string(), {kInstruments}, "test"));
  }
  CHECK(profiles == 9);
  CHECK(test::summary(find_profile("wofer", {kInstruments}, "test")) == "test UnknownName 'wofer' 'woofer'");
}

TEST_CASE("profile: a name means the first file of that name in the folders given", "[scene]") {
  const test::TemporaryFolder folder;
  folder.write("first/profiles/mine.toml", kActuator);
  folder.write("first/profiles/woofer.toml", kActuator);
  folder.write("second/profiles/mine.toml", kActuator);
  folder.write("second/profiles/other.toml", kActuator);
  const auto first = folder.path() / "first", second = folder.path() / "second";
  const ProfileFolders folders{first, second, kInstruments};
  CHECK(find_profile("mine", folders, "") == first / "profiles/mine.toml");
  CHECK(find_profile("other", folders, "") == second / "profiles/other.toml");
  CHECK(find_profile("woofer", folders, "") == first / "profiles/woofer.toml");
  CHECK(find_profile("woofer", {second, kInstruments}, "") == kInstruments / "profiles/woofer.toml");
  CHECK(test::summary(find_profile("mine", {folder.path()}, "here")).starts_with("here BadFile"));
}

TEST_CASE("profile: a scene says what its drives move, may ask for less, and not for more", "[scene]") {
  CHECK(drive_errors(R"(woofer = { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.7 })") ==
        "");
  CHECK(drive_errors("woofer = { ceiling = 0.3 }") == "");
  CHECK(drive_errors("woofer = { ceiling = 0.8 }") ==
        "test.toml:4:22 OutOfRange [drives] 0.5 --raise-limit 0.8");
  CHECK(drive_errors(R"(woofer = { profile = "wofer", volts_per_full_scale = "10 V" })") ==
        "test.toml:4:22 UnknownName 'wofer' 'woofer'");
  CHECK(drive_errors(R"(woofer = { profile = "woofer" })") ==
        "test.toml:4:1 Missing 'woofer' 'volts_per_full_scale' 'profile' 'volts_per_full_scale'");
  CHECK(drive_errors("wofer = { ceiling = 0.3 }") == "test.toml:4:1 UnknownName 'wofer' 'woofer'");
  CHECK(drive_errors("sound = { ceiling = 0.3 }") == "test.toml:4:1 UnknownName 'sound' 'woofer'");
}

TEST_CASE("profile: no shipped scene needs its guard but the one that explodes, and none fades",
          "[scene][slow]") {
  int scenes = 0;
  for (const auto& file : std::filesystem::recursive_directory_iterator(kInstruments)) {
    if (file.path().extension() != ".toml" || test::is_left_out(file.path())) continue;
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
