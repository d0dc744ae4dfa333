#include <algorithm>

#include "engine/dsp/curves/curve.h"
#include "engine/nodes/shapers/antialiased_kernel.h"
#include "engine/nodes/shapers/shaper_kernel.h"
#include "engine/nodes/shapers/slew_kernel.h"
#include "export/nodes/curve_text.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

void write_slew(NodeWriter& node) {
  node.give(0, kernel_call(node, "&" + node.state<tactus_slew>("tactus_slew"),
                           NodeWriter::number(1 / node.setup().sample_rate.value)));
}

void write_shaper(NodeWriter& node) {
  // The choices are in the order of `tactus_shape`.
  const auto& choices = find_named(node.setup().type->settings, "shape")->choices;
  const auto shape = std::ranges::find(choices, node.setting("shape")) - choices.begin();
  node.give(0, kernel_call(node, "&" + node.state<tactus_shaper>("tactus_shaper"), std::to_string(shape)));
}

void write_map(NodeWriter& node) {
  const auto shape = node.setting("curve") == "exponential" ? TACTUS_CURVE_EXPONENTIAL : TACTUS_CURVE_LINEAR;
  const Breakpoints points{node.setup().setting("points").points, shape};
  node.give(0, "tactus_curve_value(&" + write_curve_table(node, points.view(), false) + ", " +
                   curve_shape_name(shape) + ", " + node.in(0) + ")");
}

void write_mix(NodeWriter& node) { node.give(0, node.in(0)); }

void write_crossfade(NodeWriter& node) {
  node.give(0, kernel_call(node, "", node.setting("law") == "equal_power" ? "1" : "0"));
}

void write_quantiser(NodeWriter& node) {
  node.set_kernel(node.setting("rounding") == "nearest" ? "tactus_quantise_nearest"
                                                        : "tactus_quantise_floor");
  write_value(node);
}

constexpr NodeExport kShapers[] = {
    {"hysteresis", write_step<tactus_hysteresis>, "tactus_hysteresis_step", "tactus_hysteresis"},
    {"slew", write_slew, "tactus_slew_step"},
    {"shaper", write_shaper, "tactus_shaper_step"},
    {"clip", write_value, "tactus_clip", "", nullptr, nullptr, -1, true},
    {"map", write_map},
    {"mix", write_mix},
    {"crossfade", write_crossfade, "tactus_crossfade"},
    {"quantiser", write_quantiser},
};

}  // namespace

std::span<const NodeExport> exported_shapers() { return kShapers; }

}  // namespace tactus
