#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <limits>
#include <numbers>
#include <set>

#include "engine/graph/file/load.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using test::kInstruments;
using test::play;
using test::shipped_scene;

namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

struct Run {
  SceneRecording recording;

  const std::vector<double>& of(const char* name) const {
    const auto* signal = recording.find(name);
    if (signal == nullptr) throw std::runtime_error(std::string{"not recorded: "} + name);
    return signal->samples;
  }
  std::ptrdiff_t frame(double s) const { return std::lround(s * recording.sample_rate.value); }
  double at(const char* name, double s) const { return of(name)[static_cast<std::size_t>(frame(s))]; }
  double peak(const char* name, double from_s, double to_s) const {
    double most = 0;
    for (auto n = frame(from_s); n < frame(to_s); ++n)
      most = std::max(most, std::abs(of(name)[static_cast<std::size_t>(n)]));
    return most;
  }
  /// Time of the last frame from `from_s` on in which the signal is off 0 by more than `least`.
  double last_moving(const char* name, double from_s, double least) const {
    auto last = frame(from_s);
    for (auto n = last; n < std::ssize(of(name)); ++n)
      if (std::abs(of(name)[static_cast<std::size_t>(n)]) > least) last = n;
    return static_cast<double>(last) / recording.sample_rate.value;
  }
  /// Time at which the signal first reaches `level`, interpolated.
  double reached(const char* name, double level) const {
    const auto& samples = of(name);
    for (std::size_t n = 1; n < samples.size(); ++n)
      if (samples[n] >= level)
        return (static_cast<double>(n - 1) + (level - samples[n - 1]) / (samples[n] - samples[n - 1])) /
               recording.sample_rate.value;
    return std::numeric_limits<double>::infinity();
  }
};

/// `file` within instruments/actuators; numbers in SI.
Run run(const std::string& file, const std::map<std::string, double>& set = {},
        std::optional<Hertz> rate = {}) {
  SceneOptions options;
  options.rate = rate;
  for (const auto& [name, value] : set) options.set[name] = value;
  return {play(shipped_scene("actuators/" + file), options)};
}

/// X / V(jw) of a coil on a spring: the mass moves against its suspension, the moving coil generates a
/// voltage.
struct MovingCoil {
  double mass, stiffness, damping, force_factor, resistance, inductance;

  Complex excursion_per_volt(double frequency) const {
    const Complex s{0, 2 * pi * frequency};
    return force_factor / ((resistance + s * inductance) * (stiffness + s * damping + s * s * mass) +
                           s * force_factor * force_factor);
  }
};
constexpr MovingCoil kWoofer{35e-3, 1000, 1.2, 6, 6.5, 0.8e-3};
constexpr MovingCoil kDataSheet{38.839e-3, 18518.5, 5.932, 11.325, 6.18, 0};
constexpr MovingCoil kShaker{0.2, 12600, 6.8, 6, 3.6, 0};
constexpr MovingCoil kTactor{1.5e-3, 1711, 0.08, 0.8, 25, 0};

/// The closed form for a voltage that is held during each frame: half a frame later, and sin(x) / x of it.
Complex held(const MovingCoil& coil, double frequency, Hertz rate) {
  const double x = pi * frequency / rate.value;
  return coil.excursion_per_volt(frequency) * std::polar(std::sin(x) / x, -x);
}

Complex component(const Run& played, const char* name, double frequency, double from_s, double to_s) {
  Complex sum = 0;
  for (auto n = played.frame(from_s); n < played.frame(to_s); ++n)
    sum += played.of(name)[static_cast<std::size_t>(n)] *
           std::polar(1.0, -2 * pi * frequency * static_cast<double>(n) / played.recording.sample_rate.value);
  return sum;
}

/// The vibration motor of the plant.
struct Motor {
  double inertia = 2.4e-9, unbalance = 0.8e-6, torque_constant = 1.2e-3, resistance = 30, drag = 2.47e-8,
         friction = 4e-5;

  double brake() const { return drag + torque_constant * torque_constant / resistance; }
  double time_constant() const { return inertia / brake(); }
  double speed(double volts) const { return (torque_constant * volts / resistance - friction) / brake(); }
};

bool is_bounded(const Run& played, const char* name, double most) {
  const auto& samples = played.of(name);
  return std::all_of(samples.begin(), samples.end(),
                     [&](double sample) { return std::isfinite(sample) && std::abs(sample) <= most; });
}

}  // namespace

TEST_CASE("actuators: a coil on a spring follows X / V(jw) within 0.1 dB and 1 degree to 1 kHz",
          "[instruments]") {
  struct Case {
    const char* file;
    MovingCoil coil;
    double from_s, to_s;  // steady, whole periods of all frequencies
  };
  const auto [file, coil, from_s, to_s] = GENERATE(values<Case>({
      {"woofer/scene.toml", kWoofer, 0.4, 0.6},
      {"woofer/data_sheet.toml", kDataSheet, 0.4, 0.6},
      {"bass_shaker/scene.toml", kShaker, 0.4, 0.6},
      {"tactor_lra/scene.toml", kTactor, 0.3, 0.5},
  }));
  for (const double frequency : {10.0, 20.0, 40.0, 100.0, 170.0, 400.0, 1000.0}) {
    INFO(file << " at " << frequency << " Hz");
    const auto played = run(file, {{"frequency", frequency}, {"level", 0.1}});
    const auto measured = component(played, "plant.position", frequency, from_s, to_s) /
                          component(played, "plant.volts", frequency, from_s, to_s);
    const auto ratio = measured / held(coil, frequency, played.recording.sample_rate);
    CHECK(std::abs(20 * std::log10(std::abs(ratio))) < 0.1);
    CHECK(std::abs(std::arg(ratio)) * 180 / pi < 1);
  }
}

TEST_CASE("actuators: a coil without inductance answers a step as the damped oscillator does, within 1e-9",
          "[instruments]") {
  const auto [file, coil, volts] = GENERATE(values<std::tuple<const char*, MovingCoil, double>>(
      {{"bass_shaker/step.toml", kShaker, 5.0}, {"tactor_lra/step.toml", kTactor, 1.415}}));
  const auto played = run(file);
  const double rest = volts * coil.force_factor / coil.resistance / coil.stiffness;
  const double decay =
      (coil.damping + coil.force_factor * coil.force_factor / coil.resistance) / (2 * coil.mass);
  const double turn = std::sqrt(coil.stiffness / coil.mass - decay * decay);
  double worst = 0;
  for (std::ptrdiff_t n = 0; n < played.frame(0.05); ++n) {
    const double t = static_cast<double>(n) / played.recording.sample_rate.value;
    const double exact =
        rest * (1 - std::exp(-decay * t) * (std::cos(turn * t) + decay / turn * std::sin(turn * t)));
    worst = std::max(worst, std::abs(played.of("plant.position")[static_cast<std::size_t>(n)] - exact));
  }
  CHECK(worst < 1e-9 * rest);
}

TEST_CASE("actuators: the case of a shaker feels the reaction to its moving mass", "[instruments]") {
  const auto played = run("bass_shaker/scene.toml");
  const double turn = 2 * pi * 40;
  const double excursion = 5 * std::abs(kShaker.excursion_per_volt(40));
  CHECK(played.peak("plant.position", 0.5, 0.6) == Approx(excursion).epsilon(0.001));
  CHECK(played.peak("plant.force", 0.5, 0.6) ==
        Approx(kShaker.mass * turn * turn * excursion).epsilon(0.005));
}

TEST_CASE("actuators: the stops of a coil hold a woofer that is driven far beyond them", "[instruments]") {
  // The cone arrives at less than sqrt(2 F d / m), and the stop of 1e5 N/m takes that energy and the force.
  const double force = 6 * 5 / 6.5, gap = 0.5e-3;
  const double deep = force / 1e5 + std::sqrt(force / 1e5 * force / 1e5 + 2 * force * gap / 1e5);
  for (const double rate : {8e3, 48e3, 192e3})
    CHECK(is_bounded(run("woofer/step.toml", {{"plant.excursion", gap}}, Hertz{rate}), "plant.position",
                     gap + deep));
}

TEST_CASE("actuators: a vibration motor starts with the time constant of its closed form", "[instruments]") {
  const Motor motor;
  const double steady = motor.speed(0.8333333333 * 3.6);
  const auto played = run("vibration_motor/step.toml");
  CHECK(played.at("plant.speed", 0.39) == Approx(steady).epsilon(0.001));
  CHECK(played.reached("plant.speed", (1 - std::exp(-1.0)) * steady) ==
        Approx(motor.time_constant()).epsilon(0.01));
  CHECK(played.reached("plant.speed", 0.9 * steady) - played.reached("plant.speed", 0.1 * steady) ==
        Approx(2.197 * motor.time_constant()).epsilon(0.01));
  const double coasting = motor.time_constant() * std::log(1 + steady * motor.brake() / motor.friction);
  CHECK(played.last_moving("plant.speed", 0.4, 1e-6) - 0.4 == Approx(coasting).margin(0.1e-3));
}

TEST_CASE("actuators: the force of a vibration motor rises with the square of its frequency",
          "[instruments]") {
  const Motor motor;
  double speeds[2], forces[2];
  for (const int i : {0, 1}) {
    const double volts = i == 0 ? 2 : 3;
    const auto played = run("vibration_motor/scene.toml", {{"rated", volts / 3.6}});
    speeds[i] = played.at("plant.speed", 0.69);
    forces[i] = played.peak("plant.force", 0.6, 0.7);
    CHECK(speeds[i] == Approx(motor.speed(volts)).epsilon(0.001));
    CHECK(forces[i] == Approx(motor.unbalance * speeds[i] * speeds[i]).epsilon(0.01));
  }
  CHECK(forces[1] / forces[0] == Approx(std::pow(speeds[1] / speeds[0], 2)).epsilon(0.01));
}

TEST_CASE("actuators: a vibration motor starts above friction times resistance over torque constant",
          "[instruments]") {
  const Motor motor;
  const double start = motor.friction * motor.resistance / motor.torque_constant;
  CHECK(run("vibration_motor/scene.toml", {{"rated", 0.98 * start / 3.6}}).peak("plant.speed", 0, 1.2) == 0);
  CHECK(run("vibration_motor/scene.toml", {{"rated", 1.02 * start / 3.6}}).peak("plant.speed", 0, 1.2) > 1);
  CHECK(run("vibration_motor/scene.toml", {{"plant.stiction", 5}}).peak("plant.speed", 0, 1.2) == 0);
}

TEST_CASE("actuators: overdrive shortens the start of a vibration motor, a brake its stop", "[instruments]") {
  const Motor motor;
  const double ninety = 0.9 * motor.speed(0.833 * 3.6), late = 1e-3;  // the slew rate
  const auto plain = run("vibration_motor/scene.toml"), quick = run("vibration_motor/quick.toml");
  CHECK(plain.reached("plant.speed", ninety) - 0.1 ==
        Approx(motor.time_constant() * std::log(10.0)).margin(late));
  const double most = motor.speed(3.6);
  CHECK(quick.reached("plant.speed", ninety) - 0.1 ==
        Approx(motor.time_constant() * std::log(most / (most - ninety))).margin(late));
  CHECK(plain.last_moving("plant.speed", 0.7, 1) - 0.7 > 0.035);
  CHECK(quick.last_moving("plant.speed", 0.7, 1) - 0.7 < 0.015);
}

TEST_CASE("actuators: off its resonance a linear resonant actuator moves as little as its Q says",
          "[instruments]") {
  const double at = run("tactor_lra/scene.toml").peak("plant.position", 0.4, 0.5);
  const double off = run("tactor_lra/off_resonance.toml").peak("plant.position", 0.4, 0.5);
  const double resonance = std::sqrt(kTactor.stiffness / kTactor.mass) / (2 * pi);
  const double q = 2 * pi * resonance * kTactor.mass /
                   (kTactor.damping + kTactor.force_factor * kTactor.force_factor / kTactor.resistance);
  CHECK(q == Approx(15.17).epsilon(0.001));
  const auto gain = [&](double frequency) {
    const double r = frequency / resonance;
    return 1 / std::abs(Complex{1 - r * r, r / q});
  };
  CHECK(off / at == Approx(gain(200) / gain(170)).epsilon(0.01));
}

TEST_CASE(
    "actuators: a piezo bender overshoots as its Q requires, and its charge is that of voltage and motion",
    "[instruments]") {
  const auto played = run("piezo_bender/step.toml");
  const double rest = 3.333e-3 * 75 / 192.3, mass = 1.35e-3;
  const double decay = 0.0255 / (2 * mass), turn = std::sqrt(192.3 / mass - decay * decay);
  CHECK(played.peak("plant.position", 0, 0.02) ==
        Approx(rest * (1 + std::exp(-decay * pi / turn))).epsilon(0.001));
  CHECK(played.at("plant.charge", 0.1) ==
        Approx(240e-9 * 75 + 3.333e-3 * played.at("plant.position", 0.1)).epsilon(1e-6));
}

TEST_CASE("actuators: a piezo disc senses no force below 1 / (2 pi R C)", "[instruments]") {
  const auto played = run("piezo_bender/disc_scene.toml");
  for (const double t : {0.001, 0.02, 0.05})
    CHECK(played.at("plant.volts", 0.1 + t) == Approx(17.5e-3 * std::exp(-t / 20e-3)).margin(0.02e-3));
}

TEST_CASE("actuators: the cap of a fader takes as long from end to end as a rigid belt allows",
          "[instruments]") {
  // m v' = Bl V / R - friction - Bl^2 / R v
  const double mass = 0.03, brake = 2.5 * 2.5 / 12.5, push = 2.5 * 10 / 12.5 - 0.8;
  const double tau = mass / brake, most = push / brake;
  const auto way = [&](double t) { return most * (t - tau * (1 - std::exp(-t / tau))); };
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) (way((low + high) / 2) < 0.1 ? low : high) = (low + high) / 2;
  const auto played = run("motorised_fader/step.toml");
  CHECK(played.reached("plant.position", 0.1) == Approx(low).epsilon(0.015));
  CHECK(is_bounded(played, "plant.position", 0.101));
}

TEST_CASE("actuators: friction stops a fader within friction / stiffness of its target", "[instruments]") {
  for (const double stiffness : {200.0, 300.0, 600.0}) {
    INFO(stiffness << " N/m");
    const auto played = run("motorised_fader/scene.toml", {{"stiffness", stiffness}});
    for (const auto& [at, target] : {std::pair{0.99, 80e-3}, {1.99, 20e-3}, {2.99, 50e-3}})
      CHECK(std::abs(played.at("plant.position", at) - target) <=
            0.8 / stiffness + 0.1e-3);  // a step of the wiper
    CHECK(played.peak("plant.velocity", 2.9, 3) < 1e-4);
  }
}

TEST_CASE("actuators: a servomotor is read in steps of 2 pi / 4000", "[instruments]") {
  const double count = 2 * pi / 4000;
  const auto played = run("servomotor/step.toml");
  const auto &encoder = played.of("plant.encoder"), &angle = played.of("plant.angle");
  double most_off = 0, most_behind = 0;
  for (std::size_t n = 0; n < encoder.size(); ++n) {
    most_off = std::max(most_off, std::abs(encoder[n] / count - std::round(encoder[n] / count)));
    most_behind = std::max(most_behind, std::abs(angle[n] - encoder[n]) / count);
  }
  CHECK(most_off < 1e-6);
  CHECK(most_behind < 1.1);  // a count and the error of its tracks
}

TEST_CASE("actuators: cogging holds a servomotor as a spring of its torque and its teeth", "[instruments]") {
  const double cogging = 5e-3, inertia = 9.2e-5, teeth = 24, start = 2e-3;
  auto scene = shipped_scene("actuators/servomotor/step.toml");
  SceneOptions options;
  for (const auto& [name, value] : std::map<std::string, double>{
           {"plant.friction", 0}, {"plant.drag", 0}, {"plant.start", start}, {"plant.peak", 0}})
    options.set[name] = value;
  const Run played{play(scene, options)};
  // From the tooth's edge to the bottom: a quarter of a period.
  const auto& angle = played.of("plant.angle");
  std::size_t n = 0;
  while (n < angle.size() && angle[n] > 0) ++n;
  const double quarter = (static_cast<double>(n) - angle[n] / (angle[n] - angle[n - 1])) / 48e3;
  CHECK(1 / (4 * quarter) == Approx(std::sqrt(cogging * teeth / inertia) / (2 * pi)).epsilon(0.002));
  // A held force is late by half a frame, which makes it grow by cogging teeth / (4 inertia rate) per second.
  CHECK(played.peak("plant.angle", 0.3, 0.5) < 1.01 * start);
}

TEST_CASE("actuators: friction and cogging hold a servomotor against a torque below them", "[instruments]") {
  const auto moved = [](double share) {
    return run("servomotor/step.toml", {{"plant.peak", share * 0.02 / 0.05}, {"plant.cogging", 0}})
        .peak("plant.angle", 0, 0.2);
  };
  CHECK(moved(0.99) < 1e-6);
  CHECK(moved(1.05) > 1e-3);
}

TEST_CASE("actuators: a force-sensitive resistor conducts as a power of the force, and lags behind it",
          "[instruments]") {
  const auto played = run("force_sensitive_resistor/scene.toml");
  const auto law = [](double force) { return 1e-4 * std::pow(force, 0.95); };
  for (const double at : {0.125, 0.5, 0.9})
    CHECK(played.at("plant.current", at) == Approx(law(8 * at)).epsilon(0.001));
  for (const double at : {2.0, 2.25}) {
    const double drifted = 1 + 0.05 * std::log10(at - 0.1 / 8);  // since it was touched
    CHECK(played.at("plant.current", at) == Approx(1.1 * drifted * law(8 * (2.5 - at))).epsilon(0.001));
  }
  CHECK(played.at("plant.current", 0.01) == 0);  // 0.08 N
  CHECK(played.peak("instrument.shaker", 1, 1.025) == Approx(0.4 * 8 / 10).epsilon(0.003));
}

TEST_CASE("actuators: at 8 to 192 kHz no plant grows, at stiff and extreme values", "[instruments]") {
  struct Case {
    const char *file, *signal;
    std::map<std::string, double> set;
    double most;
  };
  const std::vector<Case> cases = {
      {"woofer/step.toml", "plant.position", {{"plant.mass", 1e-6}}, 4.64e-3},
      {"woofer/step.toml", "plant.position", {{"plant.stiffness", 1e7}}, 1e-6},
      {"woofer/step.toml", "plant.position", {{"plant.cubic", 1e9}}, 5.2e-3},
      {"bass_shaker/step.toml", "plant.position", {{"plant.mass", 1e-6}}, 0.67e-3},
      {"bass_shaker/step.toml", "plant.position", {{"plant.excursion", 0.2e-3}}, 0.35e-3},
      {"tactor_lra/step.toml", "plant.position", {{"plant.mass", 1e-6}}, 0.027e-3},
      {"tactor_lra/step.toml", "plant.position", {{"plant.excursion", 0.02e-3}}, 0.023e-3},
      {"piezo_bender/step.toml", "plant.position", {{"plant.mass", 1e-6}}, 2.6e-3},
      {"vibration_motor/step.toml", "plant.speed", {{"plant.inertia", 1e-9}}, 1101},
      {"vibration_motor/step.toml", "plant.speed", {{"plant.inductance", 0.1}}, 1101},
      {"motorised_fader/step.toml",
       "plant.position",
       {{"plant.motor_mass", 1e-4}, {"plant.cap_mass", 1e-4}},
       0.101},
      {"motorised_fader/step.toml", "plant.position", {{"plant.belt", 1e8}}, 0.101},
      {"motorised_fader/step.toml", "plant.position", {{"plant.end_stiffness", 1e9}}, 0.101},
      {"motorised_fader/step.toml", "plant.position", {{"plant.friction", 0}}, 0.101},
      {"motorised_fader/step.toml", "plant.position", {{"plant.stiction", 5}}, 0.2e-3},
      {"servomotor/step.toml", "plant.angle", {{"plant.inertia", 1e-9}}, 4.8},
      {"servomotor/step.toml", "plant.angle", {{"plant.stiction", 5}}, 1e-6},
      {"servomotor/step.toml", "plant.angle", {{"plant.cogging", 0.1}}, 0.1},
  };
  for (const auto& [file, signal, set, most] : cases)
    for (const double rate : {8e3, 48e3, 96e3, 192e3}) {
      INFO(file << ", " << set.begin()->first << ", " << rate << " Hz");
      CHECK(is_bounded(run(file, set, Hertz{rate}), signal, most));
    }
}
