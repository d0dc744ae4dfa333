#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>
#include <numbers>

#include "engine/nodes/table.h"
#include "engine/runtime/player.h"
#include "engine/scene/play_scene.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

const std::filesystem::path kFolder = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments/multirate";

/// How much further the fader swings between 1.5 s and 2 s than between 0.5 s and 1 s, let go at 1 mm.
double growth(const char* file, double stiffness, double damping = 0.5) {
  const auto scene = load_scene(kFolder / file, kFolder.parent_path());
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  SceneOptions options;
  options.set = {{"stiffness", stiffness}, {"plant.start", 1e-3}, {"plant.damping", damping}};
  auto quiet = *scene;
  quiet.gestures.front().points = {{0, 0}, {1, 0}};
  quiet.duration = 2_s;
  auto built = build_scene(quiet, standard_nodes(), options);
  if (!built) throw std::runtime_error(to_string(built.error()));
  const auto recording = play_scene(quiet, *built, 64);
  if (!recording) throw std::runtime_error(to_string(recording.error()));
  const auto& fader = recording->find("plant.fader")->samples;
  const auto swing = [&](double from_s, double to_s) {
    double sum = 0;
    for (auto n = static_cast<std::size_t>(from_s * 48000); n < static_cast<std::size_t>(to_s * 48000); ++n)
      sum += fader[n] * fader[n];
    return std::sqrt(sum);
  };
  return swing(1.5, 2) / swing(0.5, 1);
}

/// Amplitude at a frequency in 100 ms of the motor's force [N], the fader moving at 1 m/s over ribs of 1 N.
double force_at(const char* file, double ribs_hz, double frequency) {
  const auto graph = load_graph(kFolder / file, kFolder.parent_path());
  if (!graph) throw std::runtime_error(to_string(graph.error()));
  CompileOptions options;
  options.controls = {{"stiffness", 0.0}, {"ribs", 1.0}, {"spacing", 1 / ribs_hz}};
  auto schedule = compile(**graph, standard_nodes(), options);
  if (!schedule) throw std::runtime_error(to_string(schedule.error()));
  Player engine{std::move(*schedule)};
  std::vector<double> fader(9600);
  for (std::size_t n = 0; n < fader.size(); ++n) fader[n] = static_cast<double>(n) / 48000;
  const auto motor = test::run(engine, {fader}, 9600, {64})[0];
  std::complex<double> sum = 0;
  for (std::size_t n = 4800; n < 9600; ++n)
    sum +=
        20 * motor[n] * std::polar(1.0, -2 * std::numbers::pi * frequency * static_cast<double>(n) / 48000);
  return 2 * std::abs(sum) / 4800;
}

/// What holding for 16 frames leaves of a frequency.
double held(double frequency) {
  const double x = std::numbers::pi * frequency / 48000;
  return std::abs(std::sin(16 * x) / (16 * std::sin(x)));
}

}  // namespace

TEST_CASE("multirate: a spring at 3 kHz carries b / (1.5 T), a sixteenth of the one at 48 kHz",
          "[instruments]") {
  // Delay and half a hold: K = b / (T + T / 2), and 16 times that. The bell gives way by K / 3.8 MN/m, which
  // is 0.4 % of the fast one and raises its border by twice that.
  const double slow = 0.5 * 3000 / 1.5, fast = 16 * slow;
  CHECK(growth("scene.toml", 0.97 * slow) < 0.95);
  CHECK(growth("scene.toml", 1.03 * slow) > 1.05);
  CHECK(growth("fast_scene.toml", 0.97 * fast) < 0.95);
  CHECK(growth("fast_scene.toml", 1.03 * fast) > 1.05);
  CHECK(growth("scene.toml", 0.97 * 2 * slow, 1.0) < 0.95);
  CHECK(growth("scene.toml", 1.03 * 2 * slow, 1.0) > 1.05);
}

TEST_CASE("multirate: ribs come through the slow spring as far as holding lets them, with an image",
          "[instruments]") {
  for (const double ribs : {100.0, 500.0, 1000.0, 1400.0}) {
    // F = 2 pi w h / spacing, spacing = 1 m/s / f.
    const double whole = 2 * std::numbers::pi * 1e-4 * ribs;
    CHECK(force_at("fast.toml", ribs, ribs) == Approx(whole).epsilon(1e-6));
    CHECK(force_at("instrument.toml", ribs, ribs) == Approx(whole * held(ribs)).epsilon(1e-6));
    CHECK(force_at("instrument.toml", ribs, 3000 - ribs) == Approx(whole * held(3000 - ribs)).epsilon(1e-6));
  }
  // Above half its rate it feels slower ribs instead.
  CHECK(force_at("instrument.toml", 2500, 500) > 2 * force_at("instrument.toml", 2500, 2500));
}
