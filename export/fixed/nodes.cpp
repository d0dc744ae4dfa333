#include "export/fixed/nodes.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "engine/dsp/curves/curve.h"
#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/dsp/filters/filter_kernel.h"
#include "engine/nodes/mechanics/terrain_kernel.h"

namespace tactus {
namespace {

// Memoryless.

void write_spring(FixedNode& node) {
  auto& a = node.arithmetic();
  const auto stiffness = a.larger(node.in(1), a.number(0));
  node.give(0, a.negative(a.product(stiffness, a.difference(node.word(0), node.word(2)), node.wide())));
}

void write_damper(FixedNode& node) {
  auto& a = node.arithmetic();
  node.give(0, a.negative(a.product(a.larger(node.in(1), a.number(0)), node.word(0), node.wide())));
}

void write_wall(FixedNode& node) {
  enum Input { kPosition, kVelocity, kStiffness, kDamping, kAt };
  auto& a = node.arithmetic();
  const auto zero = a.number(0);
  const auto spring = a.product(a.larger(node.in(kStiffness), zero),
                                a.difference(node.word(kPosition), node.word(kAt)), true);
  const auto damper = a.product(a.larger(node.in(kDamping), zero), node.word(kVelocity), true);
  const auto pushed = a.negative(a.larger(a.sum(spring, damper, true), zero, true));
  const auto inside = a.comparison(">", node.word(kPosition), node.word(kAt));
  node.give(0, a.choice(inside, pushed, zero, node.wide()));
}

void write_terrain(FixedNode& node) {
  enum Input { kPosition, kWeight, kHeight, kLength };
  auto& a = node.arithmetic();
  const auto& profile = node.setting("profile");
  const auto curve =
      CubicCurve::spline(profile == "points" ? node.setup().setting("points").points : CubicCurve::Points{});
  const auto shape = profile == "points" ? TACTUS_TERRAIN_POINTS
                     : profile == "sine" ? TACTUS_TERRAIN_SINE
                                         : TACTUS_TERRAIN_DETENT;
  const double height = shape == TACTUS_TERRAIN_POINTS ? 0 : node.constant(kHeight);
  const double length = shape == TACTUS_TERRAIN_POINTS ? 1 : node.constant(kLength);
  const auto at = [=](double x) {
    const auto view = curve.view();
    return tactus_terrain_at(shape, &view, x, height, length);
  };
  const auto position = node.word(kPosition);
  if (node.reads(0)) {
    const auto slope =
        node.around.local(tabulated(
                              a, [&](double x) { return at(x).slope; }, position, node.around.table),
                          "slope");
    node.give(0, a.negative(a.product(a.larger(node.in(kWeight), a.number(0)), slope, node.wide())));
  }
  if (node.reads(1))
    node.give(1, tabulated(
                     a, [&](double x) { return at(x).value; }, position, node.around.table));
}

void write_clip(FixedNode& node) {
  auto& a = node.arithmetic();
  node.give(0, a.larger(a.smaller(node.in(0), node.in(2), true), node.in(1), node.wide()));
}

void write_map(FixedNode& node) {
  const auto shape = node.setting("curve") == "exponential" ? TACTUS_CURVE_EXPONENTIAL : TACTUS_CURVE_LINEAR;
  const Breakpoints points{node.setup().setting("points").points, shape};
  node.give(0,
            tabulated(
                node.arithmetic(), [&](double x) { return points.value(x); }, node.in(0), node.around.table));
}

void write_mix(FixedNode& node) { node.give(0, node.word(0)); }

// Filters.

/// A member that follows `in` as far as the share `gain` in each frame, with as many bits again below a word:
///   u += gain (in - u)
/// Returns the word above, and how the member is written.
struct Follower {
  FixedValue value, distance;
  std::string update;
};
Follower follow(FixedNode& node, const std::string& suffix, const FixedValue& in, double gain) {
  auto& a = node.arithmetic();
  const auto range = in.range.joined(Interval::exactly(0));
  const int of_gain = a.fitting(Interval::exactly(gain));
  const double off = std::abs(gain - std::ldexp(std::nearbyint(std::ldexp(gain, of_gain)), -of_gain));
  const auto state = node.around.state("tactus_wide", suffix, 0);
  Follower result;
  auto& value = result.value;
  for (int exponent = a.fitting(range);; --exponent) {
    const double step = std::ldexp(1.0, -exponent);
    value = {fmt::format("tactus_narrow({}, {})", state, a.bits()), exponent, widened_by(range, step)};
    const auto distance = a.difference(in, value);
    const double rounding = distance.error - in.error - value.error;
    // What each update adds to the error, times gain, and what the recurrence makes of it.
    const double added =
        0.5 * step + rounding + (off * distance.size() + std::ldexp(1.0, -exponent - a.bits())) / gain;
    value.range = widened_by(range, added + 0.5 * step);
    value.error = in.error + added + 0.5 * step;
    if (a.fitting(value.range) >= exponent) break;
  }
  value = node.around.local(value, suffix + "_now");
  result.distance = node.around.local(a.difference(in, value), suffix + "_distance");
  double rounding = 0;
  const auto added =
      a.aligned(a.product(result.distance, a.number(gain), true), value.exponent + a.bits(), true, rounding);
  result.update = fmt::format("{0} = tactus_wide_sum({0}, {1});", state, added);
  return result;
}

/// y = b0 x + b1 x1 + a1 y1 as y = dc u + b0 (x - u), u[n] = u[n - 1] + (1 - a1) (x[n - 1] - u[n - 1]), dc
/// the gain at 0 Hz, 0 or 1.
FixedValue first_order(FixedNode& node, const tactus_filter_design& design) {
  auto& a = node.arithmetic();
  const double gain = 1 - design.a[0], dc = std::nearbyint((design.b[0] + design.b[1]) / gain);
  const auto in = node.word(0);
  auto low = follow(node, "low", in, gain);
  node.around.late(low.update);
  const auto rest = a.product(low.distance, a.number(design.b[0]), dc == 0 && node.wide());
  if (dc == 0) return rest;
  auto result = a.sum(low.value, rest, node.wide());
  // The sum lies between what comes in and what is kept.
  result.range = widened_by(in.range.joined(Interval::exactly(0)), result.error);
  return result;
}

double radians(FixedNode& node, int input) {
  return tactus_filter_radians(node.constant(input), node.rate());
}

void write_one_pole(FixedNode& node) {
  auto& a = node.arithmetic();
  const double w = radians(node, 1);
  const auto low = node.around.local(
      first_order(node, node.setting("form") == "matched" ? tactus_matched_one_pole(w) : tactus_one_pole(w)),
      "low_out");
  node.give(0, low);
  if (node.reads(1)) node.give(1, a.difference(node.word(0), low));
}
void write_velocity(FixedNode& node) {
  node.give(0, first_order(node, tactus_filtered_velocity(radians(node, 1), node.rate())));
}
void write_dc_blocker(FixedNode& node) {
  node.give(0, first_order(node, tactus_dc_blocker(radians(node, 1))));
}

void write_difference(FixedNode& node) {
  auto& a = node.arithmetic();
  const auto in = node.word(0);
  const auto before = node.around.state("tactus_word", "before", 0);
  FixedValue last{before, in.exponent, in.range.joined(Interval::exactly(0)), in.error};
  node.give(0, a.product(a.difference(in, last), a.number(node.rate()), node.wide()));
  node.around.late(before + " = " + in.text + ";");
}

/// Sums of the sizes of impulse responses: what they can make of an input of size 1.
struct Responses {
  double all = 0, poles = 0, changed = 0;
};
Responses responses(const tactus_filter_design& d, const tactus_filter_design& r) {
  Responses sum;
  std::array<double, 2> y{}, p{}, z{};
  double largest = 0;
  for (int n = 0; n < 4'000'000; ++n) {
    const auto next = [&](const tactus_filter_design& f, std::array<double, 2>& s, double in) {
      const double out = in + f.a[0] * s[0] + f.a[1] * s[1];
      s[1] = s[0];
      return s[0] = out;
    };
    const double exact = next(d, y, n < 3 ? d.b[n] : 0), pole = next(d, p, n == 0 ? 1 : 0),
                 rounded = next(r, z, n < 3 ? r.b[n] : 0);
    sum.all += std::abs(exact);
    sum.poles += std::abs(pole);
    sum.changed += std::abs(exact - rounded);
    largest = std::max(largest, std::abs(pole));
    if (n > 64 && std::abs(p[0]) + std::abs(p[1]) < 1e-9 * largest) break;
  }
  return sum;
}

void write_biquad(FixedNode& node, tactus_filter_design (*shape)(double, double)) {
  auto& a = node.arithmetic();
  const auto design = shape(radians(node, 1), tactus_filter_q(node.constant(2)));
  const auto in = node.word(0);
  const int x_exponent = in.exponent + (a.bits() == 16 ? 14 : 0);
  auto rounded = design;
  const double most_b = std::max({std::abs(design.b[0]), std::abs(design.b[1]), std::abs(design.b[2]), 1e-9});
  const int b_exponent = static_cast<int>(std::floor(std::log2(1073741823.0 / most_b))), a_exponent = 29;
  const auto whole = [](double value, int exponent) { return std::nearbyint(std::ldexp(value, exponent)); };
  for (auto& b : rounded.b) b = std::ldexp(whole(b, b_exponent), -b_exponent);
  for (auto& p : rounded.a) p = std::ldexp(whole(p, a_exponent), -a_exponent);
  const auto gains = responses(design, rounded);
  const double size = in.size() * (gains.all + gains.changed);
  int y_exponent = static_cast<int>(std::floor(std::log2(1073741823.0 / std::max(size, 1e-12))));
  const double step = std::ldexp(1.0, -y_exponent);
  const int by_x = x_exponent + b_exponent - y_exponent - a_exponent;
  FixedValue result;
  const auto state = node.around.state("tactus_biquad", "", 0);
  const auto list = [&](const double* values, int count, int exponent) {
    std::string text = "{";
    for (int i = 0; i < count; ++i)
      text += fmt::format("{}{:.0f}", i == 0 ? "" : ", ", whole(values[i], exponent));
    return text + "}";
  };
  const auto forward = node.around.declare("int32_t", "forward[3]", list(design.b, 3, b_exponent));
  const auto back = node.around.declare("int32_t", "back[2]", list(design.a, 2, a_exponent));
  const double off =
      (step + std::ldexp(1.0, -x_exponent)) * gains.poles + gains.changed * in.size() + gains.all * in.error;
  result = {fmt::format("tactus_biquad_step(&{}, {}, {}, {}, {}, {})", state,
                        a.bits() == 16 ? fmt::format("tactus_wide_more({}, 14)", in.text) : in.text, forward,
                        back, by_x, a_exponent),
            y_exponent,
            {-size - off, size + off},
            off};
  // 32 bits: wide for words of 16, a word for those of 32.
  result.wide = a.bits() == 16;
  result = node.around.local(result, "filtered");
  node.give(0, node.wide() ? result : a.word(result));
}
void write_low_pass(FixedNode& node) { write_biquad(node, tactus_low_pass); }
void write_high_pass(FixedNode& node) { write_biquad(node, tactus_high_pass); }
void write_band_pass(FixedNode& node) { write_biquad(node, tactus_band_pass); }

void write_envelope(FixedNode& node) {
  auto& a = node.arithmetic();
  const auto keep = [&](int input) { return tactus_keep(node.constant(input), node.rate()); };
  const double attack = 1 - keep(1), release = 1 - keep(2);
  const auto size = node.around.local(a.size(node.in(0)), "size");
  auto slow = follow(node, "level", size, std::min(attack, release));
  const auto& distance = slow.distance;
  const auto state = slow.update.substr(0, slow.update.find(' '));
  const int inner = slow.value.exponent + a.bits();
  double rounding = 0;
  const auto added = [&](double gain) {
    return a.aligned(a.product(distance, a.number(gain), true), inner, true, rounding);
  };
  node.around.step(fmt::format("{0} = tactus_wide_sum({0}, {1} > 0 ? {2} : {3});", state, distance.text,
                               added(attack), added(release)));
  FixedValue result = slow.value;
  result.text = fmt::format("tactus_narrow({}, {})", state, a.bits());
  result.range = widened_by({0, size.range.high}, result.step());
  node.give(0, result);
}

// Memory.

std::string as_flag(const FixedValue& value) {
  return value.constant ? std::string{*value.constant >= 0.5 ? "1" : "0"} : value.text;
}

FixedValue flag_of(std::string text) {
  FixedValue result{std::move(text), 0, {0, 1}};
  result.flag = true;
  return result;
}

/// What a state holds that takes over an input: of the exponent that fits what it may come to hold.
FixedValue held(FixedNode& node, const std::string& member, const FixedValue& input, Interval at_first) {
  auto& a = node.arithmetic();
  FixedValue result = node.around.kept(input.range.joined(at_first), input.error);
  result.text = member;
  int exponent = a.fitting(result.range);
  if (!input.constant) exponent = std::min(exponent, input.exponent);
  const double rounding = std::ldexp(0.5, -exponent);
  if (input.constant || input.exponent > exponent) {
    result.error += rounding;
    result.range = widened_by(result.range, rounding);
    exponent = std::min(exponent, a.fitting(result.range));
  }
  result.exponent = exponent;
  return result;
}
std::string taken(FixedNode& node, const FixedValue& input, const FixedValue& member) {
  double rounding = 0;
  return node.arithmetic().aligned(input, member.exponent, false, rounding);
}

void write_delay(FixedNode& node) {
  const double frames = std::nearbyint(node.constant(1) * node.rate());
  if (node.setting("interpolation") != "none" && std::abs(node.constant(1) * node.rate() - frames) > 1e-6) {
    node.around.refuse("its time is no whole number of frames", "set interpolation = \"none\"");
    return;
  }
  const int length = static_cast<int>(frames);
  const auto in = node.word(0);
  if (length == 0) return node.give(0, in);
  const auto line = node.around.state("tactus_word", "line", length);
  const auto place = length > 1 ? node.around.state("uint16_t", "place", 0) : std::string{};
  const auto at = length > 1 ? line + "[" + place + "]" : line + "[0]";
  const auto value = held(node, at, in, {0, 0});
  node.give(0, node.around.local(value, "delayed"));
  node.around.late(fmt::format("{} = {};", at, taken(node, in, value)));
  if (length > 1) node.around.late(fmt::format("if (++{0} == {1}) {0} = 0;", place, length));
}

std::string rise(FixedNode& node, int input, const std::string& suffix) {
  const auto was = node.around.state("unsigned char", suffix + "_was", 0);
  return fmt::format("tactus_rise(&{}, {})", was, as_flag(node.arithmetic().trigger(node.in(input))));
}

void write_state(FixedNode& node) {
  const double initial = node.constant(2);
  const auto member = node.around.state("tactus_word", "value", 0);
  const auto in = node.word(0);
  auto value = held(node, member, in, Interval::exactly(initial));
  double rounding = 0;
  node.around.start(fmt::format("{} = {};", member, node.arithmetic().literal(initial, value.exponent)));
  node.arithmetic().aligned(node.arithmetic().number(initial), value.exponent, false, rounding);
  value.error = std::max(value.error, rounding);
  node.give(0, node.around.local(value, "held"));
  node.around.late(fmt::format("if ({}) {} = {};", rise(node, 1, "trigger"), member, taken(node, in, value)));
}

void write_sample_hold(FixedNode& node) {
  const auto member = node.around.state("tactus_word", "value", 0);
  const auto in = node.word(0);
  const auto value = held(node, member, in, {0, 0});
  node.around.step(fmt::format("if ({}) {} = {};", rise(node, 1, "trigger"), member, taken(node, in, value)));
  node.give(0, value);
}

void write_latch(FixedNode& node) {
  const auto on = node.around.state("unsigned char", "on", 0);
  node.around.step(fmt::format("if ({}) {} = 1;", rise(node, 0, "set"), on));
  node.around.step(fmt::format("if ({}) {} = 0;", rise(node, 1, "reset"), on));
  node.give(0, flag_of(on));
}

void write_toggle(FixedNode& node) {
  const auto on = node.around.state("unsigned char", "on", 0);
  node.around.step(fmt::format("if ({}) {} = !{};", rise(node, 0, "trigger"), on, on));
  node.around.step(fmt::format("if ({}) {} = 0;", rise(node, 1, "reset"), on));
  node.give(0, flag_of(on));
}

void write_threshold(FixedNode& node) {
  auto& a = node.arithmetic();
  const auto state = node.around.state("tactus_threshold", "", 0);
  const double hold = std::clamp(node.constant(3), 0.0, 3600.0) * node.rate();
  const auto in = node.word(0), level = node.word(1);
  const auto lower = a.difference(level, a.larger(node.in(2), a.number(0)));
  const auto fires =
      fmt::format("tactus_threshold_step(&{}, {}, {}, {:.0f})", state, a.comparison(">=", in, level).text,
                  a.comparison(">=", in, lower).text, std::nearbyint(hold));
  node.give(0, node.around.local(flag_of(fires), "fires"));
  if (node.reads(1)) node.give(1, flag_of(state + ".high"));
}

void write_decay(FixedNode& node) {
  enum Input { kTrigger, kTime, kLevel, kLength };
  auto& a = node.arithmetic();
  const double length = node.constant(kLength), keep = tactus_keep(node.constant(kTime), node.rate());
  const auto level = node.word(kLevel);
  const auto range = level.range.joined(Interval::exactly(0));
  const int exponent = std::min(a.fitting(widened_by(range, 2 * std::ldexp(1.0, -a.fitting(range)))),
                                level.constant ? 99 : level.exponent);
  const int inner = exponent + a.bits() - 1;
  const auto state = node.around.state("tactus_wide", "value", 0);
  double rounding = 0;
  const auto started = a.aligned(level, inner, true, rounding);
  const auto age = length > 0 ? node.around.state("uint32_t", "age", 0) : std::string{};
  node.around.step(fmt::format("if ({}) {{\n  {} = {};\n{}}}", rise(node, kTrigger, "trigger"), state,
                               started, length > 0 ? "  " + age + " = 0;\n" : ""));
  if (length > 0)
    node.around.step(
        fmt::format("if ({} >= {:.0f}UL) {} = 0;", age, std::ceil(length * node.rate() - 0.5), state));
  const double step = std::ldexp(1.0, -exponent), gain = 1 - keep;
  FixedValue value{fmt::format("tactus_narrow({}, {})", state, a.bits() - 1), exponent,
                   widened_by(range, step)};
  const auto now = node.around.local(value, "now");
  const auto lost = a.product(now, a.number(gain), true);
  const int fits = a.fitting(Interval::exactly(gain));
  const double share =
      gain > 0 ? std::abs(gain - std::ldexp(std::nearbyint(std::ldexp(gain, fits)), -fits)) / gain : 0;
  auto result = now;
  // Half a step of the word that the recurrence sees, half a one of what is given, and what updates round.
  result.error =
      level.error + rounding + step + share * level.size() + (gain > 0 ? std::ldexp(1.0, -inner) / gain : 0);
  node.give(0, result);
  node.around.late(
      fmt::format("{0} = tactus_wide_difference({0}, {1});", state, a.aligned(lost, inner, true, rounding)));
  if (length > 0) node.around.late(fmt::format("++{};", age));
}

void write_hysteresis(FixedNode& node) {
  auto& a = node.arithmetic();
  const auto in = node.word(0);
  const auto half = node.around.local(a.product(a.larger(node.in(1), a.number(0)), a.number(0.5)), "half");
  const auto low = node.around.local(a.difference(in, half), "low"),
             high = node.around.local(a.sum(in, half), "high");
  const auto member = node.around.state("tactus_word", "value", 0);
  FixedValue last{member, std::min(low.exponent, high.exponent), in.range.joined(Interval::exactly(0))};
  last.error = std::max(low.error, high.error);
  const auto moved = a.larger(a.smaller(last, high), low);
  double rounding = 0;
  node.around.step(fmt::format("{} = {};", member, a.aligned(moved, last.exponent, false, rounding)));
  last.error += 2 * last.step();
  last.range = widened_by(last.range, 2 * last.step());
  node.give(0, node.around.local(last, "moved"));
}

constexpr auto kNodes = std::to_array<FixedNodeType>({
    {"spring", write_spring},
    {"damper", write_damper},
    {"wall", write_wall},
    {"terrain", write_terrain},
    {"clip", write_clip, true},
    {"map", write_map},
    {"mix", write_mix},
    {"one_pole", write_one_pole},
    {"velocity", write_velocity},
    {"dc_blocker", write_dc_blocker},
    {"difference", write_difference},
    {"low_pass", write_low_pass},
    {"high_pass", write_high_pass},
    {"band_pass", write_band_pass},
    {"envelope", write_envelope},
    {"delay", write_delay},
    {"state", write_state},
    {"sample_hold", write_sample_hold},
    {"latch", write_latch},
    {"toggle", write_toggle},
    {"threshold", write_threshold},
    {"decay", write_decay},
    {"hysteresis", write_hysteresis},
});

}  // namespace

double FixedNode::constant(int input) {
  const auto& value = in(input);
  if (value.constant) return *value.constant;
  if (const auto frozen = around.freeze(input)) return *frozen;
  if (!refused)
    around.refuse(
        fmt::format("its '{}' changes, and integers need it fixed", setup_.type->inputs[index(input)].name),
        "give a number, or export with --number float");
  refused = true;
  return 1;
}

const FixedNodeType* find_fixed_node(std::string_view type) {
  for (const auto& entry : kNodes)
    if (type == entry.type) return &entry;
  return nullptr;
}

std::vector<std::string> fixed_node_names() {
  std::vector<std::string> names;
  for (const auto& entry : kNodes) names.emplace_back(entry.type);
  return names;
}

}  // namespace tactus
