#include "tests/engine/nodes/kernels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "engine/graph/plan/inserted_nodes.h"
#include "engine/nodes/shapers/shaper_kernel.h"
#include "engine/nodes/table.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;
using test::Samples;

namespace {

constexpr int kFrames = 6000;  // 125 ms: `stroke` detects nothing in its first 100 ms

/// Noise over the range that means something to the port; triggers come about every 20 frames.
Samples input_of(const InputPort& port, unsigned seed) {
  const bool trigger =
      port.unit.empty() && port.name != "count" && port.name != "sustain" && port.name != "q";
  const double low = std::max(port.low, trigger ? 0.0 : -1.0);
  const double high = port.unit == "s" ? 0.01 : port.unit == "Hz" ? 5000.0 : 1.0;
  auto samples = test::noise(kFrames, seed, low, high);
  if (trigger)
    for (auto& sample : samples) sample = sample > 0.95 ? 1 : 0;
  return samples;
}

/// Of nodes that a file must give more than defaults. Ports that are fixed, or mean nothing as triggers, have
/// these constants.
struct Given {
  std::map<std::string, std::string> settings = {};
  std::map<std::string, double> constants = {};
  std::map<std::string, Samples> signals = {};
};

/// Noise that becomes louder by 40 dB.
Samples burst() {
  auto samples = test::noise(kFrames, 5);
  for (int n = 0; n < kFrames - 500; ++n) samples[static_cast<std::size_t>(n)] *= 0.01;
  return samples;
}

/// Four samples of 16 bits at the engine's rate.
std::string sound_file() {
  const auto path = (std::filesystem::temp_directory_path() / "tactus_kernels_test.wav").string();
  std::ofstream file(path, std::ios::binary);
  const char header[] = "RIFF\x2c\0\0\0WAVEfmt \x10\0\0\0\1\0\1\0\x80\xbb\0\0\0\x77\1\0\2\0\x10\0data\x8\0\0";
  file.write(header, sizeof header);
  file.write("\0\x40\0\xe0\0\x10\0\0", 8);
  return path;
}

Given given_to(const std::string& node) {
  if (node == "fir") return {.settings = {{"taps", "[1, -0.25, 0.5]"}}};
  if (node == "modal") return {.settings = {{"modes", "51"}}};
  if (node == "modal_body") return {.settings = {{"modes", "51"}}, .constants = {{"impedance", 2}}};
  if (node == "wavetable") return {.settings = {{"table", "[0, 1, 0.5, -0.5, -1]"}}};
  if (node == "map") return {.settings = {{"points", "[[-1, 3], [0.25, -1], [1, 2]]"}}};
  if (node == "curve") return {.settings = {{"points", "[[0 s, 0.25], [2 ms, 1], [10 ms, -1]]"}}};
  if (node == "sequence") return {.settings = {{"values", "[1, 0.5, -2]"}}};
  if (node == "clock") return {.constants = {{"tempo", 700}, {"division", 3}, {"swing", 0.6}}};
  if (node == "pitch") return {.constants = {{"lowest", 100}, {"highest", 1000}, {"clarity", 0.2}}};
  if (node == "shaper") return {.constants = {{"drive", 3}}};
  if (node == "sample") return {.settings = {{"file", sound_file()}}, .constants = {{"speed", 0.75}}};
  if (node == "align") return {.constants = {{"on", 1}}};
  if (node == "delay") return {.settings = {{"min", "0 s"}, {"max", "10 ms"}}};
  if (node == "string") return {.constants = {{"gain", 0.99}, {"loss", 0.4}}};
  if (node == "waveguide")
    return {.settings = {{"end", "free"}, {"loss_filter", "one_pole"}},
            .constants = {{"gain", 0.9}, {"loss", 0.3}}};
  if (node == "onset") return {.constants = {{"threshold", 0.02}, {"margin", 1.41}, {"noise_margin", 7}}};
  if (node == "stroke")
    return {.constants = {{"reference", 0}, {"threshold", 0}}, .signals = {{"in", burst()}}};
  return {};
}

/// Nodes whose class does nothing but run their kernel: they need no line in kernels.c.
bool is_kernel_node(const NodeType& type) {
  const auto declares = "NodeType " + type.name + "_type() {";
  const auto folder = std::filesystem::path{TACTUS_SOURCE_DIR} / "engine/nodes";
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    if (text.find(declares) != std::string::npos)
      return text.find("KernelNode<tactus_" + type.name) != std::string::npos;
  }
  return false;
}

/// What the node and its kernel make of the same inputs.
void compare(const NodeType& type) {
  const auto given = given_to(type.name);
  std::vector<Samples> inputs;
  std::map<std::string, test::InputValue> values;
  for (const auto& port : type.inputs) {
    const auto constant = given.constants.find(port.name);
    if (port.fixed && constant != given.constants.end()) values[port.name] = constant->second;
    if (port.fixed) continue;
    const auto signal = given.signals.find(port.name);
    inputs.push_back(constant != given.constants.end() ? Samples(kFrames, constant->second)
                     : signal != given.signals.end()
                         ? signal->second
                         : input_of(port, static_cast<unsigned>(inputs.size() + 1)));
    values[port.name] = inputs.back();
  }
  std::vector<const double*> data;
  for (const auto& samples : inputs) data.push_back(samples.data());
  Samples out(kFrames);
  if (tactus_run_kernel(type.name.c_str(), data.data(), kFrames, 48000, out.data()) == 0) {
    CHECK(is_kernel_node(type));
    return;
  }
  test::NodeRunner runner(type, values, given.settings);
  REQUIRE(runner.error().empty());
  CHECK(test::first_difference({runner.run(test::random_cutting(kFrames, 3))[0]}, {out}) == "");
  CHECK(std::any_of(out.begin(), out.end(), [](double x) { return x != 0; }));
}

}  // namespace

// A new node needs one as well: a header beside it, and a line in kernels.c unless it is a KernelNode.
TEST_CASE("kernels: every node has one, and compiled as C99 it gives the bits of the node",
          "[nodes][kernels]") {
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    compare(*type);
  }
}

TEST_CASE("kernels: lanes are mixed as the compiled graph mixes them", "[nodes][kernels]") {
  const int lanes = GENERATE(3, 8, 11, 24);
  const int rows = (lanes + kVectorWidth - 1) / kVectorWidth;
  auto samples = test::noise(rows * kVectorWidth, 5);
  std::vector<Signal> in;
  for (int row = 0; row < rows; ++row) in.push_back({samples.data() + row * kVectorWidth, kVectorWidth});
  Samples sum(1);
  double* const out[] = {sum.data()};
  LaneSum{lanes}.process({in.data(), out, 1, 0});
  CHECK(test::first_difference({sum}, {{tactus_mix(samples.data(), lanes)}}) == "");
}
