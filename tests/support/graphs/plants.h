#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "latency/estimation/loop_recording.h"
#include "tests/support/graphs/graph_runner.h"

namespace tactus::test {

/// Actuators with what hears them, as graphs from `drive` to `sensor`.
struct Plant {
  std::string name;
  std::string text;
};

inline std::string plant_text(const std::string& inside, const std::string& sensor) {
  return "format = 1\nname = \"plant\"\n[inputs]\ndrive = { unit = \"full scale\" }\n" + inside +
         "[outputs]\nsensor = { from = \"" + sensor + "\" }\n";
}

/// A woofer of 6.5 inch and a microphone 8 cm away; a bass shaker and a pick-up for its motion; a coil that
/// pushes a plate with a piezo disc on it, which resonates at 4.5 kHz and hears nothing below 8 Hz.
inline std::vector<Plant> plants() {
  const auto coil = [](const char* mass, const char* stiffness, const char* damping) {
    return std::string{"[networks.p]\nframe = { type = \"ground\" }\ncone = { type = \"mass\", mass = \""} +
           mass + "\" }\nrim = { type = \"spring\", between = [\"frame\", \"cone\"], stiffness = \"" +
           stiffness + "\", damping = \"" + damping +
           "\" }\ncoil = { type = \"coil\", on = \"cone\", voltage = \"10 V * drive\", force_factor = \"6 T "
           "m\", "
           "resistance = \"6.5 ohm\", inductance = \"0.8 mH\" }\n";
  };
  return {
      {"woofer",
       plant_text(
           coil("35 g", "1000 N/m", "1.2 kg/s") +
               "[nodes]\nair = { type = \"delay\", in = \"0.2 s/m * p.cone.velocity\", time = \"0.25 ms\", "
               "interpolation = \"none\" }\n",
           "air")},
      {"shaker", plant_text(coil("200 g", "12600 N/m", "1.8 kg/s"), "0.5 s/m * p.cone.velocity")},
      {"piezo",
       plant_text("[nodes]\nplate = { type = \"low_pass\", in = \"drive\", cutoff = \"4.5 kHz\", q = 8 }\n"
                  "disc = { type = \"high_pass\", in = \"plate\", cutoff = \"8 Hz\", q = 0.5 }\n",
                  "0.2 * disc")}};
}

/// What comes back through a plant, `delay` whole frames later than through the plant alone, with noise of
/// that rms.
inline LoopRecording through_plant(const Plant& plant, const std::vector<double>& played, int delay,
                                   double noise, std::uint64_t seed) {
  CompileOptions options;
  options.sample_rate = 48_kHz;
  const auto engine = engine_of(plant.text, options);
  const auto frames = static_cast<int>(played.size()) + delay + 9600;
  LoopRecording recording{48_kHz, played, {}};
  recording.played.resize(static_cast<std::size_t>(frames), 0.0);
  auto out = run(*engine, {recording.played}, frames, {256})[0];
  out.insert(out.begin(), static_cast<std::size_t>(delay), 0.0);
  out.resize(static_cast<std::size_t>(frames));
  std::mt19937_64 random{seed};
  std::normal_distribution<double> normal;
  for (auto& sample : out) sample += noise * normal(random);
  recording.captured.push_back(std::move(out));
  return recording;
}

}  // namespace tactus::test
