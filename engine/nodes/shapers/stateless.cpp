#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/dsp/curves/curve.h"
#include "engine/dsp/curves/curve_kernel.h"
#include "engine/nodes/kernel_node.h"
#include "engine/nodes/shapers/shaper_kernel.h"

namespace tactus {
namespace {

struct ClipFunction {
  static constexpr int kInputs = 3;
  double value(const double* in) const { return tactus_clip(in[0], in[1], in[2]); }
  Lanes value(const Lanes* in) const { return max(in[1], min(in[2], in[0])); }
  double slope(int input, const double* in) const {
    const int decides = in[1] >= std::min(in[2], in[0]) ? 1 : in[0] > in[2] ? 2 : 0;
    return input == decides ? 1 : 0;
  }
};

struct MapFunction {
  static constexpr int kInputs = 1;
  Breakpoints points;
  double value(const double* in) const { return points.value(in[0]); }
  double slope(int, const double* in) const { return points.slope(in[0]); }
};

Breakpoints::Shape map_shape(const NodeSetup& setup) {
  return setup.setting("curve").text == "exponential" ? TACTUS_CURVE_EXPONENTIAL : TACTUS_CURVE_LINEAR;
}

Result<std::unique_ptr<Node>> make_map(const NodeSetup& setup) {
  const auto& points = setup.setting("points").points;
  if (const char* error = Breakpoints::error_in(points, map_shape(setup)))
    return fail(Errc::BadArgument, {}, std::string{"'points' is not a curve: "} + error,
                "write [[x, y], ...] with ascending x");
  return std::make_unique<ElementwiseNode<MapFunction>>(MapFunction{Breakpoints{points, map_shape(setup)}});
}

struct CrossfadeFunction {
  static constexpr int kInputs = 3;
  bool equal_power = false;
  double value(const double* in) const { return tactus_crossfade(in[0], in[1], in[2], equal_power); }
  double slope(int input, const double* in) const {
    if (input == 0) return tactus_crossfade(1, 0, in[2], equal_power);
    if (input == 1) return tactus_crossfade(0, 1, in[2], equal_power);
    if (in[2] < 0 || in[2] > 1) return 0;
    if (!equal_power) return in[1] - in[0];
    constexpr double kQuarter = std::numbers::pi / 2;
    return kQuarter * (in[1] * std::cos(kQuarter * in[2]) - in[0] * std::sin(kQuarter * in[2]));
  }
};

struct MixFunction {
  static constexpr int kInputs = 1;
  double value(const double* in) const {
    double lane = in[0];
    return tactus_mix(&lane, 1);
  }
  double slope(int, const double*) const { return 1; }
};

}  // namespace

NodeType clip_type() {
  return {
      .name = "clip",
      .summary = "Limits a signal to the range from `low` to `high`.",
      .equation = "out = max(low, min(high, in))",
      .source = "elementary",
      .example = "safe = { type = \"clip\", in = \"force\", low = \"-2 N\", high = \"2 N\" }",
      .inputs = {{"in", "any", "signal"},
                 {"low", "=in", "lower limit; has priority if it is above `high`", -1},
                 {"high", "=in", "largest output", 1}},
      .outputs = {{"out", "=in", "limited signal"}},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        const auto low = setup.input("low").constant, high = setup.input("high").constant;
        if (low && high && *low > *high)
          return fail(Errc::OutOfRange, {}, "'low' is above 'high', so the output is always 'low'",
                      "exchange them");
        return std::make_unique<ElementwiseNode<ClipFunction>>(ClipFunction{});
      },
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            return max(setup.input("low").range, min(setup.input("high").range, setup.input("in").range));
          },
  };
}

NodeType map_type() {
  return {
      .name = "map",
      .summary =
          "Maps a signal through a table of points; outside the table, the first or last value is used.",
      .equation =
          "linear: out = y0 + (y1 - y0) u; exponential: out = y0 (y1 / y0)^u; u = (in - x0) / (x1 - x0) "
          "between the neighbouring points (x0, y0) and (x1, y1)",
      .source = "elementary",
      .example =
          "pitch = { type = \"map\", in = \"ribbon\", points = [[\"0 mm\", \"110 Hz\"], [\"200 mm\", \"440 "
          "Hz\"]], unit = \"Hz\", curve = \"exponential\" }",
      .inputs = {{"in", "any", "signal"}},
      .outputs = {{"out", "=unit", "mapped signal"}},
      .settings = {required({"points",
                             Setting::Kind::Points,
                             "[[in, out], ...] with ascending in; two points with the same in make a jump",
                             {"=in", "=unit"}}),
                   choice("curve",
                          "interpolation between two points; exponential requires outputs of one sign",
                          {"linear", "exponential"}, "linear"),
                   unit_setting("output")},
      .make = make_map,
      .stateless = true,
      .range = range_of_points,
  };
}

NodeType mix_type() {
  return {
      .name = "mix",
      .summary = "Sums all lanes (parallel signals) of a signal.",
      .equation =
          "out = sum of in over its lanes; lanes k + 8, k + 16, ... are added to lane k, then the remaining "
          "8 lanes\nin halves: k and k + 4, k and k + 2, k and k + 1",
      .source = "elementary",
      .example = "sum = { type = \"mix\", in = \"voices\" }",
      .inputs = {{"in", "any", "signal of any number of lanes"}},
      .outputs = {{"out", "=in", "sum, one lane"}},
      .make = make_elementwise<MixFunction>,
      .stateless = true,
      .reduces_lanes = true,
  };
}

NodeType crossfade_type() {
  return {
      .name = "crossfade",
      .summary = "Fades from one signal to another.",
      .equation =
          "linear: out = a + (b - a) position; equal_power: out = a cos(pi/2 position) + b sin(pi/2 "
          "position)",
      .source = "elementary",
      .example =
          "surface = { type = \"crossfade\", a = \"smooth\", b = \"rough\", position = \"roughness\" }",
      .inputs = {{"a", "any", "signal at position 0"},
                 {"b", "=a", "signal at position 1"},
                 {"position", "", "place between both", {}, 0, 1}},
      .outputs = {{"out", "=a", "the mixture"}},
      .settings = {choice("law",
                          "linear for signals that are alike; equal_power for signals that have nothing in "
                          "common: it keeps their level",
                          {"linear", "equal_power"}, "linear")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        return std::make_unique<ElementwiseNode<CrossfadeFunction>>(
            CrossfadeFunction{setup.setting("law").text == "equal_power"});
      },
      .stateless = true,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval a = setup.input("a").range, b = setup.input("b").range;
            if (setup.setting("law").text == "linear") return a.joined(b);
            // a cos + b sin is at most a length: sqrt(2) times the larger.
            return (a.joined(b).joined(Interval::exactly(0))) * Interval{0, std::numbers::sqrt2};
          },
  };
}

NodeType quantiser_type() {
  return {
      .name = "quantiser",
      .summary = "Rounds a signal to multiples of a step, as an encoder or a converter does.",
      .equation =
          "nearest: out = step * round(in / step), halves to the even multiple; floor: out = step * floor(in "
          "/ step)",
      .source = "Widrow & Kollar, Quantization Noise, 2008",
      .example =
          "encoder = { type = \"quantiser\", in = \"angle\", step = \"0.09 deg\", rounding = \"floor\" }",
      .inputs = {{"in", "any", "signal"},
                 {"step", "=in", "step size; if a signal sets it to 0, nothing is rounded", {}, 0}},
      .outputs = {{"out", "=in", "rounded signal"}},
      .settings = {choice("rounding", "rounding: to the nearest or to the lower multiple of the step",
                          {"nearest", "floor"}, "nearest")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        if (setup.input("step").constant == 0.0)
          return fail(Errc::OutOfRange, {}, "its 'step' is 0, so nothing is rounded",
                      "give a step above 0, or remove the node");
        struct None {};
        const bool nearest = setup.setting("rounding").text == "nearest";
        // Not an `ElementwiseNode`: a staircase has no useful linearisation.
        return make_step_node<2, None>([nearest](None, double in, double step) {
          return nearest ? tactus_quantise_nearest(in, step) : tactus_quantise_floor(in, step);
        });
      },
      .stateless = true,
      .small_signal_gain = 1,
      .range =
          [](int, const NodeSetup& setup) {
            const Interval step = max(setup.input("step").range, Interval::exactly(0));
            return setup.input("in").range + Interval{-step.high, step.high};
          },
  };
}

}  // namespace tactus
