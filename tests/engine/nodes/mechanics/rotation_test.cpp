#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

constexpr double kPi = std::numbers::pi;

std::vector<double> first_output(const std::string& text, int frames) {
  return test::run(*test::engine_of(text), {}, frames, {64, 5})[0];
}

}  // namespace

TEST_CASE("rotation: a torsion pendulum has the frequency of its inertia and stiffness", "[nodes]") {
  // k / J = (2 pi 10 Hz)^2 with J = 2e-4 kg m^2: k = 0.78957 N m/rad. From 0.1 rad, after half a period, at
  // -0.1 rad.
  const auto angle = first_output(
      "format = 1\n[networks.knob]\nsolver = \"exact\"\nmotion = \"rotation\"\n"
      "rotor = { type = \"mass\", mass = \"2e-4 kg m^2\", at = \"0.1 rad\" }\n"
      "frame = { type = \"ground\" }\n"
      "spring = { type = \"spring\", between = [\"frame\", \"rotor\"], stiffness = \"0.789568 N m/rad\" }\n"
      "[outputs]\nout = { from = \"knob.rotor.position\", unit = \"rad\" }\n",
      4801);
  CHECK(angle[0] == Approx(0.1));
  CHECK(angle[2400] == Approx(-0.1).epsilon(1e-5));
  CHECK(angle[4800] == Approx(0.1).epsilon(1e-5));
}

TEST_CASE("rotation: angular velocities are in radians, frequencies in turns", "[nodes]") {
  const auto speed = [](const std::string& velocity) {
    return first_output(
        "format = 1\n[networks.knob]\nmotion = \"rotation\"\n"
        "rotor = { type = \"mass\", mass = \"1 kg m^2\", velocity = \"" +
            velocity + "\" }\n[outputs]\nout = { from = \"knob.rotor.velocity\", unit = \"rad/s\" }\n",
        8)[5];
  };
  CHECK(speed("3 rad/s") == Approx(3));
  CHECK(speed("180 deg/s") == Approx(kPi));
  CHECK(speed("30 rpm") == Approx(kPi));
  CHECK(speed("2 Hz") == Approx(4 * kPi));
  const auto sine = [](const std::string& frequency) {
    return first_output("format = 1\n[nodes]\nx = { type = \"sine\", frequency = \"" + frequency +
                            "\" }\n[outputs]\nout = { from = \"x\" }\n",
                        100)[99];
  };
  CHECK(sine("1000 rad/s") == Approx(std::sin(1000 * 99 / 48000.0)));
  CHECK(sine("100 Hz + 500 rad/s") == Approx(std::sin((200 * kPi + 500) * 99 / 48000.0)));
}

TEST_CASE("rotation: an angular velocity is no frequency", "[nodes]") {
  const auto errors = [](const std::string& frequency) {
    return test::full_errors_of(
        "format = 1\n[inputs]\nangle = { unit = \"rad\" }\n[nodes]\n"
        "speed = { type = \"velocity\", in = \"angle\", cutoff = \"100 Hz\" }\n"
        "x = { type = \"sine\", frequency = \"" +
        frequency + "\" }\n[outputs]\nout = { from = \"x\" }\n");
  };
  CHECK(errors("speed") ==
        "test.toml:6:35: 'frequency' of sine 'x' is in Hz, but this is in rad/s; divide by (2 * pi) for "
        "turns per second, "
        "or by 1 rad to take the number as it is");
  CHECK(errors("speed / (2 * pi * 1 rad)") == "");
  CHECK(errors("speed / 1 rad") == "");
  CHECK(errors("100 Hz + speed").find("multiply what is in Hz by (2 * pi * 1 rad)") != std::string::npos);
}

TEST_CASE("rotation: springs, dampers, walls and terrains give torques", "[nodes]") {
  const auto torque = [](const std::string& node) {
    return first_output(
        "format = 1\n[nodes]\nforce = { " + node +
            ", motion = \"rotation\" }\n[outputs]\nout = { from = \"force\", unit = \"N m\" }\n",
        1)[0];
  };
  CHECK(torque("type = \"spring\", in = \"90 deg\", stiffness = \"0.2 N m/rad\"") == Approx(-0.1 * kPi));
  CHECK(torque("type = \"damper\", in = \"60 rpm\", damping = \"0.01 N m s/rad\"") == Approx(-0.02 * kPi));
  CHECK(torque("type = \"wall\", position = \"30 deg\", at = \"0.5 rad\", stiffness = \"10 N m\"") ==
        Approx(-10 * (kPi / 6 - 0.5)));
  // Detents every 30 degrees: z = h cos(12 x), out = 12 w h sin(12 x), largest at 7.5 degrees.
  CHECK(torque(
            "type = \"terrain\", profile = \"sine\", position = \"7.5 deg\", weight = \"0.05 N m\", height = "
            "\"0.1 rad\", length = \"30 deg\"") == Approx(12 * 0.05 * 0.1));
  // A cubic that is level at both ends has 1.5 times the mean slope in the middle.
  CHECK(torque("type = \"terrain\", profile = \"points\", position = \"0.5 rad\", weight = \"2 N m\", points "
               "= [[\"0 "
               "rad\", \"0 deg\"], [\"1 rad\", \"1 rad\"]]") == Approx(-3));
}

TEST_CASE("rotation: units of translation are refused where things turn, and the other way round",
          "[nodes]") {
  const auto errors = [](const std::string& stiffness, const std::string& motion) {
    return test::full_errors_of("format = 1\n[networks.n]\nmotion = \"" + motion +
                                "\"\nm = { type = \"mass\", mass = 1 }\ng = { type = \"ground\" }\n"
                                "s = { type = \"spring\", between = [\"g\", \"m\"], stiffness = \"" +
                                stiffness + "\" }\n[outputs]\nout = { from = \"0 * n.energy / 1 J\" }\n");
  };
  CHECK(errors("5 N/m", "translation") == "");
  CHECK(errors("5 N m", "rotation") == "");
  CHECK(errors("5 N/m", "rotation").find("is in N m/rad, but this is in N/m") != std::string::npos);
  CHECK(errors("5 N m/rad", "translation").find("is in N/m, but this is in N m/rad") != std::string::npos);
}
