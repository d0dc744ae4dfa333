#include "engine/nodes/generators/band_limited_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

constexpr const char* kSource = "Valimaki, Pekonen & Nam, J. Acoust. Soc. Am. 131, 2012";

/// In the order of the kernels: frequency, phase, level.
std::vector<InputPort> wave_inputs() {
  return {
      {"frequency", "Hz", "periods per second, limited to half the sample rate; negative: runs backwards"},
      {"phase", "rad", "phase offset, added to the running phase", 0},
      {"level", "any", "amplitude", 1}};
}

Interval within_level(int, const NodeSetup& setup) { return setup.input("level").range * Interval{-1, 1}; }

}  // namespace

NodeType phasor_type() {
  return {
      .name = "phasor",
      .summary = "A phase that runs from 0 to 1 and starts again: a clock hand, a position in a loop.",
      .equation =
          "out[n] = frac(p[n] + phase / (2 pi)); p[0] = 0, p[n+1] = frac(p[n] + frequency[n] / rate); p = 0 "
          "at a "
          "reset",
      .source = "Moore, Elements of Computer Music, 1990",
      .example = "turn = { type = \"phasor\", frequency = \"2 Hz\" }",
      .inputs = {{"frequency", "Hz", "turns per second; negative: runs from 1 to 0"},
                 {"phase", "rad", "phase offset, added to the running phase", 0},
                 {"reset", "", "trigger that sets the running phase to 0", 0}},
      .outputs = {bounded(0, 1, {"out", "", "phase in turns, 0 to below 1"})},
      .make = make_node<KernelNode<tactus_phasor_reset_step, 3>>,
  };
}

NodeType saw_type() {
  return {
      .name = "saw",
      .summary = "A band-limited sawtooth: rises from -level to level, then jumps back.",
      .equation =
          "level * (2 p - 1), p = frac(frequency t + phase / (2 pi)), convolved with a cubic B-spline of 4 "
          "frames:\n"
          "partial k has the amplitude level * 2 / (pi k) * sinc(k frequency / rate)^4",
      .source = kSource,
      .example = "edge = { type = \"saw\", frequency = \"80 Hz\", level = \"0.5 N\" }",
      .inputs = wave_inputs(),
      .outputs = {{"out", "=level", "the wave"}},
      .silencers = {{"level"}},
      .make = make_node<KernelNode<tactus_saw_step, 3>>,
      .range = within_level,
  };
}

NodeType square_type() {
  auto inputs = wave_inputs();
  inputs.emplace_back(InputPort{
      "width", "", "share of the period in which it is high; its mean is 2 width - 1 levels", 0.5, 0, 1});
  return {
      .name = "square",
      .summary = "A band-limited square or pulse wave between -level and level.",
      .equation =
          "level where p < width, else -level; p = frac(frequency t + phase / (2 pi)), convolved with a "
          "cubic B-spline "
          "of 4 frames:\npartial k has the amplitude level * 4 / (pi k) * |sin(pi k width)| * sinc(k "
          "frequency / "
          "rate)^4",
      .source = kSource,
      .example = "buzz = { type = \"square\", frequency = \"60 Hz\", width = 0.25 }",
      .inputs = inputs,
      .outputs = {{"out", "=level", "the wave"}},
      .silencers = {{"level"}},
      .make = make_node<KernelNode<tactus_square_step, 4>>,
      .range = within_level,
  };
}

NodeType triangle_type() {
  return {
      .name = "triangle",
      .summary = "A band-limited triangle wave, in phase with a sine.",
      .equation =
          "level * (1 - 4 |frac(p + 1/4) - 1/2|), p = frequency t + phase / (2 pi), convolved with a cubic "
          "B-spline of "
          "4 frames:\nodd partial k has the amplitude level * 8 / (pi k)^2 * sinc(k frequency / rate)^4",
      .source = kSource,
      .example = "sway = { type = \"triangle\", frequency = \"0.5 Hz\", level = \"5 mm\" }",
      .inputs = wave_inputs(),
      .outputs = {{"out", "=level", "the wave"}},
      .silencers = {{"level"}},
      .make = make_node<KernelNode<tactus_triangle_step, 3>>,
      .range = within_level,
  };
}

}  // namespace tactus
