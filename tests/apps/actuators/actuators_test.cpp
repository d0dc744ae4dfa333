#if defined(TACTUS_PROGRAM) && defined(__unix__)

#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

using ActuatorJson = nlohmann::json;

struct ActuatorsRun {
  int exit = 0;
  std::string out, errors;
};

/// `environment` goes before the command.
ActuatorsRun run_actuators_command(const std::string& arguments, const std::string& environment = {}) {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out.txt", errors = folder.path() / "errors.txt";
  const auto command = environment + " " + TACTUS_PROGRAM + " actuators " + arguments + " >" + out.string() +
                       " 2>" + errors.string();
  const auto text = [](const std::filesystem::path& file) {
    std::ifstream stream{file};
    return std::string{std::istreambuf_iterator<char>{stream}, {}};
  };
  const int status = std::system(command.c_str());
  return {WEXITSTATUS(status), text(out), text(errors)};
}

std::string actuators_text(const std::string& arguments) {
  const auto run = run_actuators_command(arguments);
  REQUIRE(run.exit == 0);
  return run.out;
}

ActuatorJson actuators_json(const std::string& arguments) {
  return ActuatorJson::parse(actuators_text(arguments + " --json"))["actuators"];
}

ActuatorJson judged_for(const std::string& scene) {
  return actuators_json("--for " TACTUS_SOURCE_DIR "/instruments/" + scene);
}

ActuatorJson actuator_of(const ActuatorJson& all, const std::string& name) {
  const auto found = std::ranges::find_if(all, [&](const auto& one) { return one["name"] == name; });
  REQUIRE(found != all.end());
  return *found;
}

/// Does a text of the list contain `part`?
bool says(const ActuatorJson& list, const std::string& part) {
  return std::ranges::any_of(list, [&](const auto& text) {
    return text.template get<std::string>().find(part) != std::string::npos;
  });
}

constexpr const char* kNeedsSensor = "needs a sensor of its own";

}  // namespace

TEST_CASE("actuators command: band and excursion together need a force", "[apps][actuators]") {
  const auto woofer =
      actuator_of(actuators_json("--band '150 Hz' --excursion '5 mm' --force '10 N'"), "woofer");
  // |k - m w^2 + j w c| x = |1000 - 0.035 (2 pi 150)^2 + j 2 pi 150 1.2| 5 mm = 150.55 N; B l U / R = 6 20
  // / 6.5
  CHECK(says(woofer["remarks"], "5 mm at 150 Hz would need 151 N, and its coil has 18.5 N"));
  // At 20 Hz: |1000 - 552.7 + j 150.8| 5 mm = 2.36 N.
  CHECK(actuator_of(actuators_json("--band '20 Hz' --excursion '5 mm'"), "woofer")["remarks"].empty());
}

TEST_CASE("actuators command: turning is no excursion, and a band in words is not unknown",
          "[apps][actuators]") {
  const auto all = actuators_json("--band '160 Hz' --excursion '10 mm'");
  CHECK(says(actuator_of(all, "vibration motor")["lacks"], "excursion"));
  CHECK(says(actuator_of(all, "servomotor with an encoder")["unknown"], "turns without end"));
  CHECK(says(actuator_of(all, "motorised fader")["unknown"], "below 2.7 Hz"));
}

TEST_CASE("actuators command: sensors are left out of what is filtered", "[apps][actuators]") {
  CHECK(actuators_text("").find("resistor") != std::string::npos);
  const auto filtered = actuators_text("--price 0");
  CHECK(filtered.find("resistor") == std::string::npos);
  CHECK(filtered.find("sensors are left out") != std::string::npos);
}

TEST_CASE("actuators command: detents need travel, a sensor and a force at rest", "[apps][actuators]") {
  const auto all = judged_for("actuators/motorised_fader/detents.toml");
  // The hand moves the cap by nearly 50 mm, 25 mm to either side; the bender has 2.6 mm.
  CHECK(says(actuator_of(all, "piezo bender")["objections"], "to either side, and it has 2.6 mm"));
  CHECK(says(actuator_of(all, "woofer")["objections"], "to either side, and it has 6 mm"));
  CHECK(says(actuator_of(all, "woofer")["objections"], kNeedsSensor));
  CHECK(says(actuator_of(all, "vibration motor")["objections"], "lies below 150 Hz"));
  const auto fader = actuator_of(all, "motorised fader");
  CHECK(fader["objections"].empty());
  CHECK(fader["not_compared"].empty());  // the plant of the scene is its own
  CHECK(says(actuator_of(all, "Novint Falcon")["not_compared"], "stability"));
}

TEST_CASE("actuators command: a hand that turns detents is not for a vibration motor or a woofer",
          "[apps][actuators]") {
  const auto all = judged_for("actuators/servomotor/scene.toml");
  CHECK(says(actuator_of(all, "vibration motor")["objections"], "lies below 150 Hz"));
  CHECK(says(actuator_of(all, "woofer")["objections"], kNeedsSensor));
  for (const char* straight : {"piezo bender", "motorised fader", "woofer", "Novint Falcon"})
    CHECK(says(actuator_of(all, straight)["objections"], "the scene turns, and it moves along a line"));
}

TEST_CASE("actuators command: the scene of an actuator is no objection to it", "[apps][actuators]") {
  // 4.86 mm at 6 V: the limits count with the scene's 10 V for full scale, not with the profile's 20 V.
  CHECK(actuator_of(judged_for("actuators/woofer/scene.toml"), "woofer")["objections"].empty());
  // 60.5 Hz against 60 Hz, which is derived from judgements.
  const auto bender = actuator_of(judged_for("actuators/piezo_bender/scene.toml"), "piezo bender");
  CHECK(bender["objections"].empty());
  CHECK(says(bender["at_the_edge"], "and it moves up to 60 Hz"));
  // Overdrive and brake: the drive changes at up to 5.86 Hz, above the 4.8 Hz that the motor follows by
  // itself.
  CHECK(actuators_text("--for " TACTUS_SOURCE_DIR "/instruments/actuators/vibration_motor/quick.toml")
            .find("vibration motor: renders it\n") != std::string::npos);
}

TEST_CASE("actuators command: what turns without an arm does not move along a line", "[apps][actuators]") {
  const auto all = judged_for("effects/arm/spring.toml");
  CHECK(says(actuator_of(all, "vibration motor")["objections"], "it turns without an arm"));
  CHECK_FALSE(says(actuator_of(all, "servomotor with an encoder")["objections"], "turns"));
}

TEST_CASE("actuators command: the actuator of a scene with a sensor renders it", "[apps][actuators]") {
  const auto renders = [](const std::string& scene, const std::string& name) {
    return actuators_text("--for " TACTUS_SOURCE_DIR "/instruments/" + scene).find(name + ": renders it\n") !=
           std::string::npos;
  };
  CHECK(renders("actuators/motorised_fader/detents.toml", "motorised fader"));
  CHECK(renders("actuators/servomotor/scene.toml", "servomotor with an encoder"));
  CHECK(renders("effects/arm/spring.toml", "servomotor with an encoder"));  // by its profile
  // The plant of the drum has the sensor; the quick analysis does not decide whether its events are stable.
  const auto woofer = actuator_of(judged_for("haptic_drum"), "woofer");
  CHECK(woofer["objections"].empty());
  CHECK(woofer["not_compared"] == ActuatorJson{"stability"});
}

TEST_CASE("actuators command: a port that counts the work of two forces measures neither force nor travel",
          "[apps][actuators]") {
  const auto all = judged_for("effects/plane/enclosure.toml");
  CHECK(says(actuator_of(all, "motorised fader")["not_compared"], "force"));
  CHECK(says(actuator_of(all, "woofer")["objections"], "to either side, and it has 6 mm"));
}

TEST_CASE("actuators command: the force on the case is that of the model of the scene's own actuator",
          "[apps][actuators]") {
  const auto text_for = [](const std::string& scene) {
    return actuators_text("--for " TACTUS_SOURCE_DIR "/instruments/actuators/" + scene + "/scene.toml");
  };
  // m w^2 |X|, with X / V = Bl / (R (k - m w^2 + j w (c + Bl^2 / R))).
  // 5 V at 40 Hz: X = 6 5 / (3.6 |-33 + j 251.33 16.8|) = 1.974 mm; 0.2 251.33^2 1.974e-3 = 24.93 N
  const auto shaker = text_for("bass_shaker");
  CHECK(shaker.find("largest force on the case of its actuator: 24.9 N") != std::string::npos);
  CHECK(shaker.find("bass shaker: renders it\n") != std::string::npos);
  CHECK(shaker.find("vibration motor: the force reaches 24.9 N, and it has 1 N") != std::string::npos);
  // 0.98 2.83 V at 170 Hz: 0.0015 1068.1^2 0.787e-3 = 1.347 N
  const auto tactor = text_for("tactor_lra");
  CHECK(tactor.find("largest force on the case of its actuator: 1.35 N") != std::string::npos);
  CHECK(tactor.find("linear resonant actuator: renders it\n") != std::string::npos);
  // The same 5 V from 10 V, of the woofer's 20 V: X = 6 10 / (6.5 |-1210.8 + j 251.33 6.738|) = 4.43 mm in
  // the steady state, 0.035 251.33^2 4.43e-3 = 9.8 N, and a little more where the tone starts and stops.
  const auto woofer_there = actuator_of(judged_for("actuators/bass_shaker/scene.toml"), "woofer");
  CHECK(says(woofer_there["objections"], "the force reaches 24.9 N, and with this drive it gives 10"));
  const auto woofer = text_for("woofer");
  CHECK(woofer.find("woofer: renders it\n") != std::string::npos);
}

TEST_CASE("actuators command: torques and angles are compared with a motor that has an arm",
          "[apps][actuators]") {
  const auto scene = "--for " TACTUS_SOURCE_DIR "/instruments/actuators/servomotor/scene.toml";
  // 2 pi 0.5 N m 0.00833 rad / 15 deg = 0.09996 N m; the motor has 6.37 N at 10 cm.
  CHECK(actuators_text(scene).find("largest torque on the player: 100 mN m") != std::string::npos);
  const auto all = actuators_json(scene);
  const auto servomotor = actuator_of(all, "servomotor with an encoder");
  CHECK(servomotor["objections"].empty());
  CHECK(servomotor["not_compared"].empty());
  CHECK(says(actuator_of(all, "vibration motor")["not_compared"], "torque"));
}

TEST_CASE("actuators command: the tip of an arm goes as far as its motor turns", "[apps][actuators]") {
  const auto servomotor = actuator_of(judged_for("effects/arm/spring.toml"), "servomotor with an encoder");
  CHECK_FALSE(says(servomotor["not_compared"], "travel"));
  CHECK_FALSE(says(servomotor["not_compared"], "force"));
}

TEST_CASE("actuators command: nothing renders a scene of which a criterion was not compared",
          "[apps][actuators]") {
  const auto text =
      actuators_text("--for " TACTUS_SOURCE_DIR "/instruments/actuators/motorised_fader/detents.toml");
  CHECK(text.find("Novint Falcon: no objection; not compared: force, band, drive guard, stability") !=
        std::string::npos);
}

TEST_CASE("actuators command: a profile is known by its figures, however its path is written",
          "[apps][actuators]") {
  const auto text = actuators_text("--for " TACTUS_SOURCE_DIR "/instruments/wall");  // profile = "servo.toml"
  CHECK(text.find("servomotor with an encoder: renders it") != std::string::npos);
}

TEST_CASE("actuators command: a scene whose plant is in rad turns, also without ports", "[apps][actuators]") {
  const auto fader = actuator_of(judged_for("gamepad/scene_wheel_wall.toml"), "motorised fader");
  CHECK(says(fader["objections"], "turns"));
}

TEST_CASE("actuators command: the sources begin with the price", "[apps][actuators]") {
  CHECK(actuators_text("--sources").find("$40 (Berdahl") != std::string::npos);
}

TEST_CASE("actuators command: a length without a unit is refused", "[apps][actuators]") {
  for (const char* option : {"--excursion", "--resolution"}) {
    const auto run = run_actuators_command(std::string{option} + " 3");
    CHECK(run.exit == 2);
    CHECK(run.errors.find(std::string{option} + ": '3' has no unit; write \"3 mm\"") != std::string::npos);
  }
}

TEST_CASE("actuators command: a file with an error hides no other one", "[apps][actuators]") {
  const test::TemporaryFolder folder;
  const std::string figures = "tactus/instruments/actuators/figures/";
  folder.write(figures + "mine.toml", "format = 1\nname = \"mine\"\n");
  folder.write(figures + "reversed.toml",
               "format = 1\nname = \"reversed\"\n[band]\nfrom = \"200 Hz\"\nto = \"20 Hz\"\n"
               "kind = \"sheet\"\nsource = \"x\"\n");
  folder.write(figures + "second.toml", "format = 1\nname = \"woofer\"\n");
  folder.write(figures + "profile.toml", "format = 1\nname = \"strange\"\nprofile = \"woofr\"\n");
  const auto run = run_actuators_command("", "XDG_DATA_HOME=" + folder.path().string());
  CHECK(run.exit == 1);
  for (const char* listed : {"mine", "bass shaker", "woofer"})
    CHECK(run.out.find(std::string{"\n"} + listed + " ") != std::string::npos);
  for (const char* left_out : {"reversed", "strange"}) CHECK(run.out.find(left_out) == std::string::npos);
  CHECK(run.errors.find("reversed.toml:5:6: 'to' of [band] is below 'from'; swap them") != std::string::npos);
  CHECK(run.errors.find("second.toml:2:8: 'woofer' is the name of the actuator in ") != std::string::npos);
  CHECK(run.errors.find("profile.toml:3:11: there is no profile 'woofr'") != std::string::npos);
}

#endif
