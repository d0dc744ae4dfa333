#include "engine/nodes/generators/oscillator_kernel.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

Result<std::unique_ptr<Node>> make_wavetable(const NodeSetup& setup) {
  const auto& table = setup.setting("table").numbers;
  if (table.empty())
    return fail(Errc::BadArgument, {}, "'table' is empty", "write one period, as in table = [0, 1, 0, -1]");
  const bool cubic = setup.setting("interpolation").text == "cubic";
  return make_step_node<3, tactus_phasor>([table, cubic, rate = rate_of(setup)](tactus_phasor& phasor,
                                                                                double frequency,
                                                                                double phase, double level) {
    return tactus_wavetable_step(&phasor, table.data(), static_cast<int>(table.size()), cubic, frequency,
                                 phase, level, rate);
  });
}

}  // namespace

NodeType sine_type() {
  return {
      .name = "sine",
      .summary = "A sine oscillator whose frequency, phase and level are signals.",
      .equation = "out[n] = level * sin(2 pi p[n] + phase); p[0] = 0, p[n+1] = p[n] + frequency[n] / rate",
      .source = "elementary",
      .example = "tone = { type = \"sine\", frequency = \"80 Hz\", level = \"0.5 N\" }",
      .inputs = {{"frequency", "Hz", "frequency in cycles per second; negative: the phase runs backwards"},
                 {"phase", "rad", "phase offset, added to the running phase", 0},
                 {"level", "any", "amplitude", 1}},
      .outputs = {{"out", "=level", "the sine"}},
      .silencers = {{"level"}},
      .make = make_node<KernelNode<tactus_sine_step, 3>>,
      .range =
          [](int, const NodeSetup& setup) {
            return setup.input("level").range * Interval{-1, 1};
          },
  };
}

NodeType wavetable_type() {
  return {
      .name = "wavetable",
      .summary =
          "Repeats one period given as numbers. Not band-limited: partials above half the sample rate alias.",
      .equation =
          "out[n] = level * table(N * frac(p[n] + phase / (2 pi))) for N numbers; p[0] = 0, p[n+1] = p[n] + "
          "frequency[n] / rate",
      .source = "Moore, Elements of Computer Music, 1990; cubic: Catmull & Rom, 1974",
      .example = "buzz = { type = \"wavetable\", table = [0, 1, 0.5, -0.5, -1], frequency = \"60 Hz\" }",
      .inputs = {{"frequency", "Hz", "periods per second; negative: runs backwards"},
                 {"phase", "rad", "phase offset, added to the running phase", 0},
                 {"level", "any", "amplitude, multiplies the table", 1}},
      .outputs = {{"out", "=level", "the waveform"}},
      .silencers = {{"level"}},
      .settings = {required({"table", Setting::Kind::Numbers,
                             "one period at equal intervals; at least one number"}),
                   choice("interpolation", "interpolation between two numbers", {"linear", "cubic"},
                          "linear")},
      .make = make_wavetable,
  };
}

}  // namespace tactus
