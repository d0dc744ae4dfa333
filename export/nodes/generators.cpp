#include <cstdio>

#include "engine/dsp/curves/curve.h"
#include "engine/nodes/generators/band_limited_kernel.h"
#include "engine/nodes/generators/curve_run_kernel.h"
#include "engine/nodes/generators/curve_setup.h"
#include "engine/nodes/generators/random_walk_kernel.h"
#include "engine/nodes/generators/recording.h"
#include "engine/nodes/generators/sample_kernel.h"
#include "export/nodes/curve_text.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

/// Samples of a file that are written out as constants.
constexpr std::size_t kMostSamples = 1 << 16;

std::string noise_key(const NodeWriter& node) {
  char text[32];
  std::snprintf(text, sizeof text, "0x%llxu",
                tactus_noise_key(static_cast<tactus_noise_bits>(node.setup().setting("seed").number),
                                 static_cast<tactus_noise_bits>(node.setup().lane)));
  return text;
}

void write_noise(NodeWriter& node) {
  const auto function =
      node.setting("distribution") == "uniform" ? "tactus_noise_uniform(" : "tactus_noise_gaussian(";
  node.give(0, node.operand(0) + " * " + function + noise_key(node) + ", " + node.frame() + ")");
}

void write_random_walk(NodeWriter& node) {
  node.give(0, node.operand(1) + " * tactus_random_walk_step(&" +
                   node.state<tactus_random_walk>("tactus_random_walk") + ", " + noise_key(node) + ", " +
                   node.frame() + ", " + node.in(0) + ", " + node.rate() + ")");
}

void write_curve(NodeWriter& node) {
  const auto shape = curve_shape(node.setup());
  const Breakpoints points{curve_points(node.setup()), shape};
  const auto run = node.state<tactus_curve_run>("tactus_curve_run");
  const auto curve = write_curve_table(node, points.view(), shape == TACTUS_CURVE_CUBIC);
  const auto waits = node.setup().input("trigger").connected ? "1" : "0";
  const auto place = node.local("place", "tactus_curve_run_step(&" + run + ", " + node.in(0) + ", " +
                                             node.in(1) + ", " + node.in(2) + ", " + waits + ")");
  node.give(
      0, run + ".level * tactus_curve_value(&" + curve + ", " + curve_shape_name(shape) + ", " + place + ")");
}

void write_wavetable(NodeWriter& node) {
  const auto& numbers = node.setup().setting("table").numbers;
  const auto cubic = node.setting("interpolation") == "cubic" ? "1" : "0";
  node.give(0, "tactus_wavetable_step(&" + node.state<tactus_phasor>("tactus_phasor") + ", " +
                   node.table("table", numbers) + ", " + std::to_string(numbers.size()) + ", " + cubic +
                   ", " + node.in(0) + ", " + node.in(1) + ", " + node.in(2) + ", " + node.rate() + ")");
}

void write_sample(NodeWriter& node) {
  const auto recording =
      read_recording(node.setting("file"), static_cast<int>(node.setup().setting("channel").number));
  if (!recording) return node.refuse(recording.error().what, recording.error().remedy);
  if (recording->samples.size() > kMostSamples)
    return node.refuse("its file has " + std::to_string(recording->samples.size()) +
                           " samples, and at most " + std::to_string(kMostSamples) +
                           " can be written out as constants",
                       "use a shorter recording or one at a lower rate");
  const auto state = node.state<tactus_sample>("tactus_sample");
  const auto samples = node.table("samples", recording->samples);
  const auto cubic = node.setting("interpolation") == "cubic" ? "1" : "0";
  node.step("if (tactus_rise_step(&" + state + ".rise, " + node.in(0) + ")) tactus_sample_start(&" + state +
            ");");
  node.give(0, node.operand(2) + " * tactus_sample_read(&" + state + ", " + samples + ", " +
                   std::to_string(recording->samples.size()) + ", tactus_clamp(" + node.in(1) +
                   ", 0.0, 1000.0) * " +
                   NodeWriter::number(recording->sample_rate / node.setup().sample_rate) + ", " + cubic +
                   ")");
}

constexpr NodeExport kGenerators[] = {
    {"sine", write_step_at_rate<tactus_phasor>, "tactus_sine_step", "tactus_phasor"},
    {"phasor", write_step_at_rate<tactus_resettable_phasor>, "tactus_phasor_reset_step",
     "tactus_resettable_phasor"},
    {"saw", write_step_at_rate<tactus_phasor>, "tactus_saw_step", "tactus_phasor"},
    {"square", write_step_at_rate<tactus_phasor>, "tactus_square_step", "tactus_phasor"},
    {"triangle", write_step_at_rate<tactus_phasor>, "tactus_triangle_step", "tactus_phasor"},
    {"noise", write_noise},
    {"random_walk", write_random_walk},
    {"curve", write_curve},
    {"wavetable", write_wavetable},
    {"sample", write_sample},
};

}  // namespace

std::span<const NodeExport> exported_generators() { return kGenerators; }

}  // namespace tactus
