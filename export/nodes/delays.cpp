#include <algorithm>

#include "engine/dsp/strings/string_kernel.h"
#include "engine/nodes/delays/align_kernel.h"
#include "engine/nodes/delays/delay_setup.h"
#include "engine/nodes/delays/event_delay_kernel.h"
#include "engine/nodes/delays/string_setup.h"
#include "export/kernels/delay_kernel.h"
#include "export/nodes/line.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

enum DelayInput { kDelayIn, kDelayTime };

/// Where the taps lie: constants, or the state that aims them.
std::string write_aim(NodeWriter& node, const tactus_delay& range, int order) {
  if (const auto time = node.constant(kDelayTime)) {
    tactus_aim aim{};
    tactus_aim_at(&aim, &range, order, *time);
    std::string weights;
    for (int k = 0; k <= order; ++k) weights += (k == 0 ? "" : ", ") + NodeWriter::number(aim.weights[k]);
    return node.table(
        "tactus_aim", "aim",
        "{" + NodeWriter::number(aim.seconds) + ", 1, " + std::to_string(aim.newest) + ", {" + weights + "}}",
        sizeof(tactus_aim));
  }
  const auto range_text =
      node.table("tactus_delay", "range",
                 "{" + NodeWriter::number(range.low) + ", " + NodeWriter::number(range.high) + ", " +
                     NodeWriter::number(range.rate) + ", " + std::to_string(range.first) + "}",
                 sizeof(tactus_delay));
  const auto aim = node.state<tactus_aim>("tactus_aim", "aim");
  const auto aim_at = "tactus_aim_at(&" + aim + ", &" + range_text + ", " + std::to_string(order) + ", " +
                      node.in(kDelayTime) + ");";
  node.pace(kDelayTime) == Pace::Control ? node.follow(aim_at) : node.step(aim_at);
  return aim;
}

void write_delay(NodeWriter& node) {
  const int order = delay_order(node.setup());
  const auto range = *delay_range(node.setup());
  // What matters is how long it can get here; places of taps follow from the range of the engine.
  auto reach = range;
  reach.high = std::max(range.low, std::min(range.high, node.range(kDelayTime).high));
  const WrittenLine line{node, tactus_delay_most(&reach, order) + order + 1, order + 1};
  const auto order_text = std::to_string(order), written = std::string{node.halves() ? "0" : "1"};
  const auto write = "tactus_line_write(" + line.text() + ", " + node.in(kDelayIn) + ");";
  const auto aim = write_aim(node, range, order);
  node.halves() ? node.late(write) : node.step(write);
  node.late(line.keep());
  node.give(0, "tactus_aim_read(&" + aim + ", " + order_text + ", " + line.text() + ", " + written + ")");
}

void write_align(NodeWriter& node) {
  tactus_align start{};
  const double longest = node.setup().input("period").range.high;
  tactus_align_start(&start, node.setup().sample_rate.value, longest);
  constexpr int kOrder = TACTUS_ALIGN_TAPS - 1;
  const auto state = node.state<tactus_align>("tactus_align");
  const WrittenLine line{node, tactus_delay_most(&start.delay, kOrder) + kOrder + 1, kOrder + 1};
  node.start("tactus_align_start(&" + state + ", " + node.rate() + ", " +
             NodeWriter::number(std::min(longest, TACTUS_ALIGN_LONGEST)) + ");");
  node.set_kernel("tactus_align_step");
  node.give(0, kernel_call(node, "&" + state + ", " + line.text()));
  node.late(line.keep());
}

void write_event_delay(NodeWriter& node) {
  const auto state = node.state<tactus_event_delay>("tactus_event_delay");
  node.call(0, "tactus_event_delay_step(&" + state + ", " + node.in(0) + ", tactus_clamp(" + node.in(1) +
                   ", 0.0, 3600.0) * " + node.rate() + ", " + node.in(2) + ")");
  node.give(1, state + ".value");
}

/// The pole of a loss filter; "0" where the loss is a zero.
std::string pole_of(NodeWriter& node) {
  return loss_filter_of(node.setup()) == LossFilter::OnePole
             ? "&" + node.state<tactus_filter>("tactus_filter", "pole")
             : std::string{"0"};
}

/// Design of a string or waveguide, whenever its parameters change.
std::string write_tuning(NodeWriter& node, const std::string& pole, const NodeWriter::WithInputs& design_of) {
  const auto design = node.state<tactus_string_design>("tactus_string_design", "design");
  node.design({1, 2, 3}, [&](const std::vector<std::string>& values) {
    const auto set = design + " = " + design_of(values) + ";";
    return pole == "0" ? set : "{ " + set + "\n    tactus_string_set_pole(" + pole + ", &" + design + "); }";
  });
  return design;
}

void write_string(NodeWriter& node) {
  const double rate = node.setup().sample_rate.value;
  const double lowest = std::min(pitches_of(node.setup()).low, 0.3 * rate);
  const WrittenLine line{node, StringLoop::longest_delay(Hertz{rate}, lowest) + TACTUS_STRING_TAPS,
                         TACTUS_STRING_TAPS};
  const auto pole = pole_of(node);
  const auto one_pole = std::string{pole == "0" ? "0" : "1"};
  const auto kind =
      node.table("tactus_string_kind", "kind", "{" + one_pole + ", 0.9999, 0}", sizeof(tactus_string_kind));
  const auto design = write_tuning(node, pole, [&](const std::vector<std::string>& values) {
    return "tactus_string(" + kind + ", tactus_min(tactus_max(" + NodeWriter::number(lowest) + ", " +
           values[0] + "), " + NodeWriter::number(StringLoop::kHighestPitch) + "), " + values[1] + ", " +
           values[2] + ", " + node.rate() + ")";
  });
  node.call(0, "tactus_string_step(&" + design + ", " + one_pole + ", " + line.text() + ", " + pole + ", " +
                   node.in(0) + ", " + node.position() + ")");
  node.late(line.keep());
}

void write_waveguide(NodeWriter& node) {
  const auto pole = pole_of(node);
  const bool one_pole = pole != "0", fixed_end = node.setting("end") != "free";
  const auto pitches = pitches_of(node.setup());
  const auto guide = tactus_waveguide_between(pitches.low, pitches.high, one_pole, fixed_end,
                                              node.setup().sample_rate.value);
  const WrittenLine line{node, guide.most + 1 + TACTUS_STRING_TAPS, TACTUS_STRING_TAPS};
  const auto state = node.state<tactus_waveguide>("tactus_waveguide");
  node.start(state + " = tactus_waveguide_between(" + NodeWriter::number(pitches.low) + ", " +
             NodeWriter::number(pitches.high) + ", " + (one_pole ? "1" : "0") + ", " +
             (fixed_end ? "1" : "0") + ", " + node.rate() + ");");
  const auto design = write_tuning(node, pole, [&](const std::vector<std::string>& values) {
    return "tactus_waveguide_design(&" + state + ", " + values[0] + ", " + values[1] + ", " + values[2] + ")";
  });
  const auto write = "tactus_line_write(" + line.text() + ", " + node.in(0) + ");";
  node.halves() ? node.late(write) : node.step(write);
  node.late(line.keep());
  const auto newest = design + ".newest" + (node.halves() ? "" : " + 1");
  const auto taken = "tactus_tap_sum(tactus_line_tap(" + line.text() + ", " + newest +
                     ", TACTUS_STRING_TAPS - 1), " + design + ".taps, TACTUS_STRING_TAPS, 0)";
  node.call(0,
            one_pole ? "tactus_filter_step(" + pole + ", 1, " + taken + ", " + node.position() + ")" : taken);
}

constexpr NodeExport kDelays[] = {
    {"align", write_align},
    {"delay", write_delay},
    {"event_delay", write_event_delay},
    {"string", write_string, "", "", nullptr, nullptr, 0},
    {"waveguide", write_waveguide},
};

}  // namespace

std::span<const NodeExport> exported_delays() { return kDelays; }

}  // namespace tactus
