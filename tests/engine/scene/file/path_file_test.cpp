#include "engine/scene/file/path_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "engine/dsp/delays/resample.h"
#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"
#include "tests/support/error_summary.h"
#include "tests/support/graphs/node_runner.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Detail::Approx;

namespace {

/// 0.3 s of a resonance at 60 Hz, 2 ms away.
PathFile woofer(Hertz rate) {
  PathFile path{"woofer \"and\" microphone", "resonance 60 Hz, Q 1\npolarity +", "calibrate", rate, {}};
  for (int k = 0; k < 0.3 * rate.value; ++k) {
    const double t = k / rate.value - 0.002, w = 2 * std::numbers::pi * 60;
    path.taps.push_back(t < 0 ? 0 : -1e-3 * std::exp(-0.5 * w * t) * std::sin(0.75 * w * t));
  }
  return path;
}

constexpr const char* kSmall = R"(format = 1
[inputs]
drive = {}
[outputs]
sensor = { from = "path" }
[nodes.path]
type = "fir"
in = "drive"
rate = "48 kHz"
taps = [1, 0.5]
)";

/// What is wrong with kSmall when `from` is `to`.
std::string errors_of(const std::string& from, const std::string& to) {
  std::string text = kSmall;
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  const auto path = read_path(parse_graph_leniently(text.replace(at, from.size(), to), "path.toml"));
  return test::summary(path);
}

/// A scene with this path between the woofer and the microphone, and beside it what the path is given.
SceneRecording played(const PathFile& path, Hertz rate) {
  TemporaryFolder folder;
  folder.write("my_path.toml", to_text(path));
  folder.write("copy.toml", "format = 1\n[inputs]\nin = {}\n[outputs]\nout = { from = \"in\" }\n");
  folder.write("instrument.toml", R"(format = 1
[inputs]
mic = { unit = "full scale" }
[nodes]
tone = { type = "sine", frequency = "75 Hz", level = 0.2 }
[outputs]
woofer = { from = "tone - 0.3 * mic" }
)");
  const auto scene = load_scene(folder.write("scene.toml", R"(format = 1
delay = "5 ms"
duration = "0.5 s"
[parts]
instrument = { use = "instrument.toml", mic = "plant.sensor" }
plant = { use = "my_path.toml", drive = "instrument.woofer" }
given = { use = "copy.toml", in = "instrument.woofer" }
)"));
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  SceneOptions options;
  options.rate = rate;
  auto built = build_scene(*scene, standard_nodes(), options);
  if (!built) throw std::runtime_error(to_string(built.error()));
  return *play_scene(*scene, *built, 64);
}

Samples convolved(const Samples& x, const Samples& taps) {
  Samples y(x.size());
  for (std::size_t n = 0; n < x.size(); ++n)
    for (std::size_t k = 0; k < taps.size() && k <= n; ++k) y[n] += taps[k] * x[n - k];
  return y;
}

}  // namespace

TEST_CASE("path file: what is written is read back, taps to eight digits", "[scene]") {
  auto path = woofer(GENERATE(48_kHz, 44.1_kHz, 47999.1234_Hz));
  path.taps.insert(path.taps.end(), {0.0, 1e-30, -123456.789012345, 1});
  const auto text = to_text(path);
  const auto back = read_path(parse_graph_leniently(text, "path.toml"));
  REQUIRE(back);
  CHECK(back->name == path.name);
  CHECK(back->about == path.about);
  CHECK(back->source == path.source);
  CHECK(back->rate == path.rate);
  REQUIRE(back->taps.size() == path.taps.size());
  for (std::size_t k = 0; k < path.taps.size(); ++k)
    CHECK(std::abs(back->taps[k] - path.taps[k]) <= 5e-8 * std::abs(path.taps[k]));
  CHECK(to_text(*back) == text);
}

TEST_CASE("path file: as the plant of a scene it is a convolution with what was measured", "[scene]") {
  const auto measured_at = GENERATE(48_kHz, 96_kHz);
  const auto path = *read_path(parse_graph_leniently(to_text(woofer(measured_at)), "path.toml"));
  const auto recording = played(path, 48_kHz);
  const auto& given = recording.find("given.out")->samples;
  const auto& recorded = recording.find("plant.sensor")->samples;
  REQUIRE(recorded.size() == 24000);
  const auto expected = convolved(given, taps_at_rate(path.taps, measured_at, 48_kHz));
  double worst = 0, highest = 0;
  for (std::size_t n = 0; n < recorded.size(); ++n) {
    worst = std::max(worst, std::abs(recorded[n] - expected[n]));
    highest = std::max(highest, std::abs(expected[n]));
  }
  CHECK(highest > 1e-3);           // it did play
  CHECK(worst < 1e-12 * highest);  // the same sum in another order: 30000 roundings of 1e-16 at most
}

TEST_CASE("path file: a scene at another rate hears the same path", "[scene]") {
  const auto path = woofer(96_kHz);
  const auto low = played(path, 48_kHz), high = played(path, 96_kHz);
  const auto& at_48 = low.find("plant.sensor")->samples;
  const auto& at_96 = high.find("plant.sensor")->samples;
  double worst = 0, highest = 0;
  for (std::size_t n = 0; n < at_48.size(); ++n) {
    worst = std::max(worst, std::abs(at_48[n] - at_96[2 * n]));
    highest = std::max(highest, std::abs(at_96[2 * n]));
  }
  CHECK(worst < 1e-3 * highest);
}

TEST_CASE("path file: what is no measured path is an error with its place", "[scene]") {
  const std::string form = " 'path' from \"path\"";
  CHECK(errors_of("type = \"fir\"\nin = \"drive\"\nrate = \"48 kHz\"\ntaps = [1, 0.5]",
                  "type = \"clip\"\nin = \"drive\"") ==
        "path.toml:1:1 BadFile 'path'" + form + "\npath.toml:6:8 BadFile 'path'" + form);
  CHECK(errors_of("drive = {}", "drive = {}\nother = {}") == "path.toml:1:1 BadFile 2 1" + form);
  CHECK(errors_of("\"path\"", "\"0.5 * path\"") == "path.toml:5:19 BadFile 'from' \"path\"" + form);
  CHECK(errors_of("in = \"drive\"", "in = \"-drive\"") == "path.toml:8:6 BadFile 'in' \"drive\"" + form);
  CHECK(errors_of("[nodes.path]", "[nodes]\nmore = \"2 * path\"\n[nodes.path]") ==
        "path.toml:7:1 BadFile 'more'" + form);
  CHECK(errors_of("rate = \"48 kHz\"\n", "") == R"(path.toml:6:8 Missing 'path' 'rate' rate "48 kHz")");
  CHECK(errors_of("48 kHz", "48 Hz") == "path.toml:9:8 OutOfRange 'rate' 'path' 48 1 1000");
  CHECK(errors_of("0.5]", "\"0.5 m\"]").find("path.toml:10:12") != std::string::npos);
  CHECK(errors_of("taps = [1, 0.5]", "taps = [").find("path.toml:") != std::string::npos);
  CHECK(!read_path(load_graph_leniently("/nowhere/path.toml")));
}
