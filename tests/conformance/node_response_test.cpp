#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <numeric>

#include "engine/core/units.h"
#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"

// response() against what the node does: the transform of its answer to a small impulse on top of inputs at
// rest.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kSettle = 4099;  ///< frames before the impulse; odd, to lie on no grid
constexpr double kRate = 48000;

/// Where z stands: on the unit circle, where something vibrates, and outside, where it grows.
struct Place {
  Hertz frequency;
  double radius = 1;
  std::complex<double> z() const { return radius * on_circle(frequency, Hertz{kRate}); }
};
const Place kPlaces[] = {{10_Hz}, {50_Hz},  {230_Hz},       {1_kHz},
                         {5_kHz}, {20_kHz}, {0_Hz, 1.0002}, {700_Hz, 1.01}};

struct Rest {
  const NodeType* type;
  std::map<std::string, std::string> settings;
  std::vector<double> at;
};

Samples run(const Rest& rest, std::size_t input, std::size_t output, int frames, double impulse) {
  std::map<std::string, InputValue> inputs;
  for (std::size_t i = 0; i < rest.at.size(); ++i) inputs[rest.type->inputs[i].name] = rest.at[i];
  Samples moving(static_cast<std::size_t>(kSettle + frames), rest.at[input]);
  moving[kSettle] += impulse;
  inputs[rest.type->inputs[input].name] = moving;
  NodeRunner runner(*rest.type, inputs, rest.settings, Hertz{kRate}, typical_ranges(*rest.type));
  return runner.run(even_cutting(kSettle + frames, kLongestSubBlock))[output];
}

double step_of(const Rest& rest, std::size_t input) {
  const auto range = typical_range(rest.type->inputs[input]);
  return 1e-5 * std::max(range.high - range.low, 1e-6);
}

/// Central difference, so that the curvature of a nonlinear law drops out.
Samples impulse_response(const Rest& rest, std::size_t input, std::size_t output, int frames) {
  const double step = step_of(rest, input);
  const auto above = run(rest, input, output, frames, step);
  const auto below = run(rest, input, output, frames, -step);
  Samples response;
  for (std::size_t n = kSettle; n < above.size(); ++n) response.push_back((above[n] - below[n]) / (2 * step));
  return response;
}

double weight(Samples::const_iterator from, Samples::const_iterator to) {
  return std::accumulate(from, to, 0.0, [](double sum, double x) { return sum + std::abs(x); });
}

bool settled(const Samples& response) {
  const auto eighth = static_cast<std::ptrdiff_t>(response.size() / 8);
  return weight(response.end() - eighth, response.end()) <= 1e-9 * weight(response.begin(), response.end());
}

std::complex<double> transform(const Samples& samples, const Place& place) {
  std::complex<double> sum = 0;
  const double decay = std::log(place.radius), turn = 2 * kPi * place.frequency.value / kRate;
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const auto frames = static_cast<double>(n);
    sum += samples[n] * std::polar(std::exp(-decay * frames), -turn * frames);
  }
  return sum;
}

struct Measured {
  std::vector<std::complex<double>> at_places;
  /// By which a rounding error in each frame grows: it stays for as long as the response, and the transform
  /// adds those of all frames.
  double rounding = 1;
};

/// H at kPlaces. What never settles (an integrator) is differenced: (1 - z^-1) H settles. What settles late
/// is not, since the division by 1 - z^-1 raises its rounding errors.
std::optional<Measured> measure(const Rest& rest, std::size_t input, std::size_t output) {
  for (const bool whole : {true, false})
    for (int frames = 4096; frames <= 1 << 18; frames *= 8) {
      auto response = impulse_response(rest, input, output, frames);
      if (!whole) std::adjacent_difference(response.begin(), response.end(), response.begin());
      if (!settled(response)) continue;
      Measured found;
      for (const auto& place : kPlaces)
        found.at_places.push_back(transform(response, place) / (whole ? 1.0 : 1.0 - 1.0 / place.z()));
      double peak = 0;
      for (const double x : response) peak = std::max(peak, std::abs(x));
      const double memory = peak > 0 ? weight(response.begin(), response.end()) / peak : 1;
      found.rounding = std::sqrt(memory * frames);
      return found;
    }
  return std::nullopt;
}

/// Compares one path; the number of paths that have a response.
int check_path(const Rest& rest, Node& node, std::size_t input, std::size_t output) {
  const auto expected = [&](const Place& place) {
    return node.response(static_cast<int>(input), static_cast<int>(output), place.z(), rest.at);
  };
  if (!expected(kPlaces[0])) return 0;
  INFO(rest.type->inputs[input].name << " to " << rest.type->outputs[output].name);
  const auto measured = measure(rest, input, output);
  CHECK(measured);
  if (!measured) return 1;
  // Where the output does not answer at all, the difference still shows the rounding of what it rests at:
  // some ten roundings of half a unit (1.1e-16) in each frame of both runs, and three of their standard
  // deviations.
  const double rounding =
      1e-15 * measured->rounding * std::abs(run(rest, input, output, 1, 0).back()) / step_of(rest, input);
  double largest = 0;
  for (const auto& h : measured->at_places) largest = std::max(largest, std::abs(h));
  for (std::size_t k = 0; k < measured->at_places.size(); ++k) {
    INFO(kPlaces[k].frequency.value << " Hz, |z| = " << kPlaces[k].radius);
    REQUIRE(expected(kPlaces[k]));
    const auto h = *expected(kPlaces[k]);
    // A step of 1e-5 of the range bends the laws by 1e-7 at most; rounding leaves 1e-11 of the step.
    const double tolerance = 1e-6 * std::abs(h) + 1e-8 * largest + rounding;
    CHECK(measured->at_places[k].real() == Approx(h.real()).margin(tolerance).epsilon(0));
    CHECK(measured->at_places[k].imag() == Approx(h.imag()).margin(tolerance).epsilon(0));
  }
  return 1;
}

int check_type(const NodeType& type, double fraction) {
  int paths = 0;
  for (const auto& [label, settings] : setting_variants(type)) {
    INFO(type.name << " " << label << " at " << fraction << " of its ranges");
    Rest rest{&type, settings, {}};
    std::map<std::string, InputValue> inputs;
    for (const auto& port : type.inputs) {
      const auto range = typical_range(port);
      rest.at.push_back(port.fallback.value_or(range.low + fraction * (range.high - range.low)));
      inputs[port.name] = rest.at.back();
    }
    NodeRunner runner(type, inputs, settings, Hertz{kRate}, typical_ranges(type));
    CHECK(runner.error() == "");
    if (!runner.made()) continue;
    for (std::size_t i = 0; i < type.inputs.size(); ++i)
      for (std::size_t o = 0; !type.inputs[i].fixed && o < type.outputs.size(); ++o)
        paths += check_path(rest, runner.node(), i, o);
  }
  return paths;
}

}  // namespace

TEST_CASE("nodes: response() is the transform of the impulse response", "[conformance]") {
  // Three places, on either side of the corners that laws have, and on no round number.
  const double fraction = GENERATE(0.66, 0.41, 0.52);
  int paths = 0;
  for (const auto* type : standard_nodes().types) paths += check_type(*type, fraction);
  CHECK(paths > 0);
}
