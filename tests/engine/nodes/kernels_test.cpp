#include "tests/engine/nodes/kernels.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/nodes/table.h"
#include "tests/support/node_runner.h"

using namespace tactus;
using test::Samples;

namespace {

constexpr int kFrames = 4000;

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

}  // namespace

TEST_CASE("kernels: compiled as C99 they give the bits of their nodes", "[nodes][kernels]") {
  int compared = 0;
  for (const auto* type : standard_nodes().types) {
    std::vector<Samples> inputs;
    std::vector<const double*> data;
    std::map<std::string, test::InputValue> values;
    for (const auto& port : type->inputs) {
      if (port.fixed) continue;
      inputs.push_back(input_of(port, static_cast<unsigned>(inputs.size() + 1)));
      values[port.name] = inputs.back();
    }
    for (const auto& samples : inputs) data.push_back(samples.data());
    Samples out(kFrames);
    if (tactus_run_kernel(type->name.c_str(), data.data(), kFrames, 48000, out.data()) == 0) continue;
    INFO(type->name);
    test::NodeRunner runner(*type, values);
    REQUIRE(runner.error().empty());
    CHECK(test::first_difference({runner.run(test::random_cutting(kFrames, 3))[0]}, {out}).empty());
    CHECK(std::any_of(out.begin(), out.end(), [](double x) { return x != 0; }));
    ++compared;
  }
  CHECK(compared >= 23);
}
