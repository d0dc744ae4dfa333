#include <algorithm>

#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/dsp/envelopes/onset_kernel.h"
#include "engine/dsp/envelopes/stroke_kernel.h"
#include "engine/nodes/envelopes/pitch_kernel.h"
#include "engine/nodes/envelopes/pulse_kernel.h"
#include "export/kernel_texts.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

void write_onset(NodeWriter& node) {
  enum Input { kIn, kThreshold, kHold, kMargin, kNoiseMargin, kMaskTime, kHighPass, kRinging };
  const auto state = node.state<tactus_onset>("tactus_onset");
  const auto fixed = [&](Input input) { return NodeWriter::number(*node.setup().inputs[input].constant); };
  node.start("tactus_onset_start(&" + state + ", " + node.rate() + ", " + fixed(kHighPass) + ", " +
             fixed(kMaskTime) + ", " + fixed(kRinging) + ");");
  node.call(0, "tactus_onset_step(&" + state + ", " + node.in(kIn) + ", " + node.in(kThreshold) + ", " +
                   node.in(kHold) + ", " + node.in(kMargin) + ", " + node.in(kNoiseMargin) + ")");
  node.give(1, state + ".level");
  node.give(2, state + ".fast[0]");
}

void write_pitch(NodeWriter& node) {
  const double lowest = *node.setup().inputs[2].constant;
  const double highest = std::max(2 * lowest, *node.setup().inputs[3].constant);
  tactus_pitch start{};
  tactus_pitch_start(&start, node.setup().sample_rate.value, lowest, highest);
  const auto state = node.state<tactus_pitch>("tactus_pitch");
  const auto full = node.state<double>("tactus_real", "full", 2 * start.full_frames);
  const auto small = node.state<double>("tactus_real", "small", 2 * start.small_frames);
  node.start("tactus_pitch_start(&" + state + ", " + node.rate() + ", " + NodeWriter::number(lowest) + ", " +
             NodeWriter::number(highest) + ");");
  node.step("tactus_pitch_step(&" + state + ", " + full + ", " + small + ", " + node.in(0) + ");");
  const auto clear = "(" + state + ".clarity >= " + node.operand(1) + " && " + state + ".clarity > 0)";
  if (node.reads(0)) {
    const auto held = node.state<double>("tactus_real", "held");
    node.step("if " + clear + " " + held + " = " + state + ".frequency;");
    node.give(0, held);
  }
  node.give(1, "(tactus_real)" + clear);
  node.give(2, state + ".clarity");
}

void write_stroke(NodeWriter& node) {
  enum Input { kIn, kReference, kThreshold, kHold };
  const auto& choices = find_named(node.setup().type->settings, "lookahead")->choices;
  const auto lookahead = std::ranges::find(choices, node.setting("lookahead")) - choices.begin();
  const auto net = node.table("tactus_stroke_net", "net",
                              kernel_array_entry("tactus_stroke_nets", static_cast<int>(lookahead)),
                              sizeof(tactus_stroke_net));
  const auto state = node.state<tactus_stroke>("tactus_stroke");
  const bool referenced = node.setup().inputs[kReference].constant != 0.0;
  node.start("tactus_stroke_start(&" + state + ", " + node.rate() + ", &" + net + ");");
  node.call(0, "tactus_stroke_step(&" + state + ", " + node.in(kIn) + ", " + node.in(kReference) + ", " +
                   node.in(kThreshold) + ", " + node.in(kHold) + ", " + (referenced ? "1" : "0") + ")");
  node.give(1, state + ".level");
  node.give(2, state + ".evidence");
}

/// What an exponential keeps in one frame: a constant, or worked out whenever its time changes.
std::string keep_of(NodeWriter& node, int input, const std::string& suffix) {
  if (const auto seconds = node.constant(input))
    return NodeWriter::number(tactus_keep(*seconds, node.setup().sample_rate.value));
  return "tactus_time_constant_keep(&" + node.state<tactus_time_constant>("tactus_time_constant", suffix) +
         ", " + node.in(input) + ", " + node.rate() + ")";
}

void write_envelope(NodeWriter& node) {
  enum Input { kIn, kAttack, kRelease };
  const auto follower = node.state<tactus_follower>("tactus_follower");
  const auto attack = keep_of(node, kAttack, "attack"), release = keep_of(node, kRelease, "release");
  node.give(0,
            "tactus_follower_step(&" + follower + ", " + node.in(kIn) + ", " + attack + ", " + release + ")");
}

void write_decay(NodeWriter& node) {
  enum Input { kTrigger, kTime, kLevel, kLength };
  const auto rise = node.state<tactus_rise>("tactus_rise", "rise");
  const auto keep = keep_of(node, kTime, "time");
  const auto rises = "if (tactus_rise_step(&" + rise + ", " + node.in(kTrigger) + ")) ";
  const auto length = node.constant(kLength);
  if (length && *length <= 0) {
    const auto value = node.state<double>("tactus_real", "value");
    node.step(rises + value + " = " + node.in(kLevel) + ";");
    return node.give(0, "tactus_pulse_fall(&" + value + ", " + keep + ")");
  }
  const auto pulse = node.state<tactus_pulse>("tactus_pulse");
  node.step(rises + "tactus_pulse_start(&" + pulse + ", " + node.in(kLevel) + ");");
  node.give(0, "tactus_pulse_step(&" + pulse + ", " + keep + ", " + node.operand(kLength) + " * " +
                   node.rate() + ")");
}

constexpr NodeExport kEnvelopes[] = {
    {"envelope", write_envelope},
    {"adsr", write_step_at_rate<tactus_adsr>, "tactus_adsr_step", "tactus_adsr"},
    {"decay", write_decay},
    {"onset", write_onset},
    {"pitch", write_pitch},
    {"stroke", write_stroke},
};

}  // namespace

std::span<const NodeExport> exported_envelopes() { return kEnvelopes; }

}  // namespace tactus
