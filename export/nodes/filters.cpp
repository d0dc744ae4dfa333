#include <fmt/format.h>

#include <functional>
#include <numeric>
#include <optional>

#include "engine/dsp/delays/resample.h"
#include "engine/dsp/delays/taps_kernel.h"
#include "engine/dsp/filters/filter_kernel.h"
#include "engine/dsp/resonators/modal_kernel.h"
#include "engine/nodes/filters/modal_setup.h"
#include "export/nodes/line.h"
#include "export/nodes/table.h"

namespace tactus {
namespace {

std::string design_text(const tactus_filter_design& design) {
  const auto text = [](double value) { return NodeWriter::number(value); };
  return fmt::format("{{{}, {{{}, {}, {}}}, {{{}, {}}}}}", design.order, text(design.b[0]), text(design.b[1]),
                     text(design.b[2]), text(design.a[0]), text(design.a[1]));
}

/// Of a filter whose parameters are all its inputs but the first.
struct Coefficients {
  int order = 1;
  std::optional<tactus_filter_design> constant;
};

Coefficients coefficients_of(const NodeWriter& node) {
  const auto& entry = *find_node_export(node.setup().type->name);
  const double rate = node.setup().sample_rate.value;
  const auto design = [&](double cutoff, double q) {
    return entry.coefficients(node.setup(), tactus_filter_radians(cutoff, rate), tactus_filter_q(q), rate);
  };
  const int inputs = static_cast<int>(node.setup().inputs.size());
  for (int i = 1; i < inputs; ++i)
    if (!node.constant(i)) return {design(rate / 8, 1).order, {}};
  const auto constant = design(*node.constant(1), inputs > 2 ? *node.constant(2) : 1);
  return {constant.order, constant};
}

/// Works them out whenever the parameters change: `set` is given the C text of the design.
void follow_parameters(NodeWriter& node, const std::function<std::string(const std::string&)>& set) {
  std::vector<int> parameters(node.setup().inputs.size() - 1);
  std::iota(parameters.begin(), parameters.end(), 1);
  node.design(parameters, [&](const std::vector<std::string>& values) {
    return set(filter_design(node.kernel(), values, node.rate()));
  });
}

/// A step on the grid of eight frames.
std::string filter_on_grid(NodeWriter& node, const Coefficients& coefficients, const std::string& in) {
  const auto filter = node.state<tactus_filter>("tactus_filter");
  const auto set = [&](const std::string& design) {
    return "tactus_filter_set(&" + filter + ", " + design + ");";
  };
  if (coefficients.constant)
    node.start(set(node.table("tactus_filter_design", "design", design_text(*coefficients.constant),
                              sizeof(tactus_filter_design))));
  else
    follow_parameters(node, set);
  return "tactus_filter_step(&" + filter + ", " + std::to_string(coefficients.order) + ", " + in + ", " +
         node.position() + ")";
}

/// A step frame by frame: with the numbers themselves where they are constant, and no more state than needed.
std::string plain_filter(NodeWriter& node, const Coefficients& coefficients, const std::string& in) {
  const auto before = [&](const char* name) { return "&" + node.state<double>("tactus_real", name); };
  std::string b[3], a[2];
  if (const auto& design = coefficients.constant) {
    for (int k = 0; k < 3; ++k) b[k] = NodeWriter::number(design->b[k]);
    for (int k = 0; k < 2; ++k) a[k] = NodeWriter::number(design->a[k]);
    if (design->order == 1 && design->b[1] == 0)
      return fmt::format("tactus_recurrence_pole({}, {}, {}, {})", b[0], a[0], in, before("y1"));
  } else {
    const auto member = node.state<tactus_filter_design>("tactus_filter_design", "design");
    follow_parameters(node, [&](const std::string& text) { return member + " = " + text + ";"; });
    for (int k = 0; k < 3; ++k) b[k] = fmt::format("{}.b[{}]", member, k);
    for (int k = 0; k < 2; ++k) a[k] = fmt::format("{}.a[{}]", member, k);
  }
  const auto x1 = before("x1");
  if (coefficients.order == 1)
    return fmt::format("tactus_recurrence_1({}, {}, {}, {}, {}, {})", b[0], b[1], a[0], in, x1, before("y1"));
  const auto x2 = before("x2"), y1 = before("y1"), y2 = before("y2");
  return fmt::format("tactus_recurrence_2({}, {}, {}, {}, {}, {}, {}, {}, {}, {})", b[0], b[1], b[2], a[0],
                     a[1], in, x1, x2, y1, y2);
}

/// A recursive filter. Its kernel is the design, with $1 and $2 for its parameters and $rate.
void write_filter(NodeWriter& node) {
  const auto coefficients = coefficients_of(node);
  const bool remainder = node.setup().type->outputs.size() > 1 && node.reads(1);
  const auto in = remainder ? node.variable(0) : node.in(0);
  const auto step =
      node.plain() ? plain_filter(node, coefficients, in) : filter_on_grid(node, coefficients, in);
  if (!remainder) return node.give(0, step);
  if (!node.reads(0)) return node.give(1, in + " - " + step);
  const auto filtered = node.local("low", step);
  node.give(0, filtered);
  node.give(1, in + " - " + filtered);
}

std::string own_design(const NodeExport& entry, const NodeSetup&) { return entry.kernel; }

std::string one_pole_design(const NodeExport&, const NodeSetup& setup) {
  return setup.setting("form").text == "matched" ? "tactus_matched_one_pole($1)" : "tactus_one_pole($1)";
}

tactus_filter_design one_pole_coefficients(const NodeSetup& setup, double radians, double, double) {
  return setup.setting("form").text == "matched" ? tactus_matched_one_pole(radians)
                                                 : tactus_one_pole(radians);
}

void write_one_pole(NodeWriter& node) {
  node.set_kernel(one_pole_design({}, node.setup()));
  write_filter(node);
}

void write_fir(NodeWriter& node) {
  const auto& rate = node.setup().setting("rate");
  auto taps =
      taps_at_rate(node.setup().setting("taps").numbers,
                   rate.given ? Hertz{rate.number} : node.setup().sample_rate, node.setup().sample_rate);
  taps.resize((taps.size() + TACTUS_FIR_SUMS - 1) / TACTUS_FIR_SUMS * TACTUS_FIR_SUMS);
  std::ranges::reverse(taps);
  const int count = static_cast<int>(taps.size());
  const WrittenLine line{node, count, count};
  node.step("tactus_line_write(" + line.text() + ", " + node.in(0) + ");");
  node.late(line.keep());
  const auto taken = std::to_string(count);
  node.give(0, "tactus_fir_frame(" + node.table("taps", taps) + ", " + taken + ", tactus_line_tap(" +
                   line.text() + ", 1, " + std::to_string(count - 1) + ") - " + std::to_string(count - 1) +
                   ")");
}

/// A table of one number for all modes is that number.
std::string of_mode(NodeWriter& node, const std::string& name, const std::vector<double>& values) {
  if (std::ranges::all_of(values, [&](double value) { return value == values[0]; }))
    return NodeWriter::number(values[0]);
  return node.table(name, values) + "[k]";
}

void write_modal(NodeWriter& node) {
  enum Input { kIn, kFrequency, kDecay };
  const auto modal = *modal_setup(node.setup());
  const int count = static_cast<int>(modal.modes.size()), groups = (count + 7) / 8;
  const auto last = node.state<double>("tactus_real", "last_in");
  if (count == 0) return node.give(0, "0.0");
  const auto bank = node.state<tactus_modes>("tactus_modes", "modes", groups);
  std::vector<double> frequencies, decays, gains;
  for (const auto k : modal.modes) {
    frequencies.push_back(modal.table.frequency_hz(k, 1));
    decays.push_back(modal.table.decay_s(k, 1));
    gains.push_back(modal.gains[k]);
  }
  const auto frequency = of_mode(node, "ratios", frequencies), decay = of_mode(node, "decays", decays),
             gain = of_mode(node, "gains", gains);
  node.start("for (int k = 0; k < " + std::to_string(8 * groups) + "; ++k)\n  tactus_modes_set(&" + bank +
             "[k / 8], k % 8, tactus_mode_design(0, 1, 0, 1));");
  const bool tuned = modal.table.frequency_hz(0, 1) != modal.table.frequency_hz(0, 2);
  const bool damped = modal.table.decay_s(0, 1) != modal.table.decay_s(0, 2);
  std::vector<int> moving;
  if (tuned) moving.push_back(kFrequency);
  if (damped) moving.push_back(kDecay);
  node.design(moving, [&](const std::vector<std::string>& values) {
    const auto f = tuned ? "tactus_within(" + values.front() + ", 1.0, 1e6) * " + frequency : frequency;
    const auto d = damped ? "tactus_within(" + values.back() + ", 1e-4, 1e4) * " + decay : decay;
    return "for (int k = 0; k < " + std::to_string(count) + "; ++k)\n    tactus_modes_set(&" + bank +
           "[k / 8], k % 8, tactus_mode_design(" + f + ", " + d + ", " + gain + ", " + node.rate() + "));";
  });
  node.call(0, "tactus_modal_step(" + bank + ", " + std::to_string(groups) + ", " + last + ")");
  node.late(last + " = " + node.in(kIn) + ";");
}

constexpr NodeExport kFilters[] = {
    {"one_pole", write_one_pole, "", "", one_pole_design, one_pole_coefficients, 0},
    {"dc_blocker", write_filter, "tactus_dc_blocker($1)", "", own_design,
     [](const NodeSetup&, double radians, double, double) { return tactus_dc_blocker(radians); }, 0},
    {"velocity", write_filter, "tactus_filtered_velocity($1, $rate)", "", own_design,
     [](const NodeSetup&, double radians, double, double rate) {
       return tactus_filtered_velocity(radians, rate);
     },
     0},
    {"low_pass", write_filter, "tactus_low_pass($1, $2)", "", own_design,
     [](const NodeSetup&, double radians, double q, double) { return tactus_low_pass(radians, q); }, 0},
    {"high_pass", write_filter, "tactus_high_pass($1, $2)", "", own_design,
     [](const NodeSetup&, double radians, double q, double) { return tactus_high_pass(radians, q); }, 0},
    {"band_pass", write_filter, "tactus_band_pass($1, $2)", "", own_design,
     [](const NodeSetup&, double radians, double q, double) { return tactus_band_pass(radians, q); }, 0},
    {"difference", write_step_at_rate<tactus_difference>, "tactus_difference_step", "tactus_difference"},
    {"fir", write_fir},
    {"modal", write_modal},
};

}  // namespace

std::string filter_design(const std::string& kernel, const std::vector<std::string>& parameters,
                          const std::string& rate) {
  std::string text = kernel;
  const auto replace = [&](const std::string& what, const std::string& with) {
    if (const auto at = text.find(what); at != std::string::npos) text.replace(at, what.size(), with);
  };
  replace("$rate", rate);
  replace("$1", "tactus_filter_radians(" + parameters[0] + ", " + rate + ")");
  if (parameters.size() > 1) replace("$2", "tactus_filter_q(" + parameters[1] + ")");
  return text;
}

std::span<const NodeExport> exported_filters() { return kFilters; }

}  // namespace tactus
