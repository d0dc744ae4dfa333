#include "engine/nodes/logic/clock_kernel.h"
#include "engine/nodes/logic/poly_kernel.h"
#include "engine/nodes/logic/sequence_kernel.h"
#include "engine/nodes/logic/state_kernel.h"
#include "engine/nodes/logic/threshold_kernel.h"
#include "engine/nodes/logic/triggered_kernel.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

void write_clock(NodeWriter& node) {
  const auto state = node.state<tactus_clock>("tactus_clock");
  node.call(0, "tactus_clock_step(&" + state + ", " + node.operand(0) + " * " + node.operand(1) + ", " +
                   node.in(2) + ", " + node.in(3) + ", " + node.rate() + ")");
  node.give(1, state + ".phase");
  node.give(2, state + ".count");
}

void write_poly(NodeWriter& node) {
  enum Input { kPitch, kOn, kOff, kLevel };
  const auto voices = node.state<tactus_voice>("tactus_voice", "voices", node.setup().lanes);
  const auto state = node.state<tactus_poly>("tactus_poly");
  const auto voice = voices + "[" + std::to_string(node.setup().lane) + "]";
  const auto pitch = node.variable(kPitch);
  node.step("tactus_poly_step(&" + state + ", " + voices + ", " + std::to_string(node.setup().lanes) + ", " +
            (node.setting("steal") == "oldest" ? "1" : "0") + ", " + node.in(kOn) + ", " + node.in(kOff) +
            ", " + pitch + ", " + node.in(kLevel) + ");");
  node.give(0, voice + ".starts");
  node.give(1, voice + ".held");
  node.give(2, voice + ".since > 0 ? " + voice + ".pitch : " + pitch);
  node.give(3, voice + ".level");
}

void write_sequence(NodeWriter& node) {
  const auto& values = node.setup().setting("values").numbers;
  const auto state = node.state<tactus_sequence>("tactus_sequence");
  const auto list = node.table("values", values);
  node.call(1, "tactus_sequence_step(&" + state + ", " + node.in(0) + ", " + node.in(1) + ", " + list + ", " +
                   std::to_string(values.size()) + ")");
  node.after(0, list + "[tactus_sequence_index(&" + state + ")]");
  node.after(2, "tactus_sequence_index(&" + state + ")");
}

void write_state(NodeWriter& node) {
  const auto state = node.state<tactus_state>("tactus_state");
  node.give(0, "tactus_state_value(&" + state + ", " + node.in(2) + ")");
  node.late("tactus_state_take(&" + state + ", " + node.in(0) + ", " + node.in(1) + ");");
}

void write_interval(NodeWriter& node) {
  const auto state = node.state<tactus_interval>("tactus_interval");
  node.give(0, "tactus_interval_value(&" + state + ", " + node.in(1) + ", " + node.rate() + ")");
  node.late("tactus_interval_pass(&" + state + ", " + node.in(0) + ");");
}

void write_threshold(NodeWriter& node) {
  const auto state = node.state<tactus_threshold>("tactus_threshold");
  const auto* kernel = node.reads(1) ? "tactus_threshold_step(&" : "tactus_threshold_fires(&";
  node.call(0, kernel + state + ", " + node.in(0) + ", " + node.in(1) + ", tactus_max(0.0, " + node.in(2) +
                   "), tactus_clamp(" + node.in(3) + ", 0.0, 3600.0) * " + node.rate() + ")");
  node.give(1, state + ".high");
}

constexpr NodeExport kLogic[] = {
    {"clock", write_clock},
    {"poly", write_poly},
    {"sequence", write_sequence},
    {"state", write_state},
    {"interval", write_interval},
    {"threshold", write_threshold},
    {"counter", write_step<tactus_counter>, "tactus_counter_step", "tactus_counter"},
    {"latch", write_step<tactus_latch>, "tactus_latch_step", "tactus_latch"},
    {"toggle", write_step<tactus_toggle>, "tactus_toggle_step", "tactus_toggle"},
    {"sample_hold", write_step<tactus_sample_hold>, "tactus_sample_hold_step", "tactus_sample_hold"},
};

}  // namespace

std::span<const NodeExport> exported_logic() { return kLogic; }

}  // namespace tactus
