#include <cmath>

#include "engine/nodes/declare.h"
#include "engine/nodes/generators/curve_run_kernel.h"
#include "engine/nodes/generators/curve_setup.h"

namespace tactus {

Breakpoints::Shape curve_shape(const NodeSetup& setup) {
  const auto& name = setup.setting("curve").text;
  return name == "step" ? TACTUS_CURVE_STEP : name == "smooth" ? TACTUS_CURVE_CUBIC : TACTUS_CURVE_LINEAR;
}

Breakpoints::Points curve_points(const NodeSetup& setup) {
  auto points = setup.setting("points").points;
  for (auto& [x, y] : points) {
    x = frames_in(Seconds{x}, setup.sample_rate);
    if (std::abs(x - std::round(x)) < 1e-6) x = std::round(x);
  }
  return points;
}

namespace {

class CurveNode final : public Node {
 public:
  explicit CurveNode(const NodeSetup& setup)
      : points_(curve_points(setup), curve_shape(setup)), waits_(setup.input("trigger").connected) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int i = 0; i < block.frames; ++i) {
      const double place =
          tactus_curve_run_step(&run_, in[kTrigger][i], in[kSpeed][i], in[kLevel][i], waits_ ? 1 : 0);
      block.out[0][i] = run_.level * points_.value(place);
    }
  }
  void reset() noexcept override { run_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  enum Input { kTrigger, kSpeed, kLevel };

  Breakpoints points_;
  bool waits_;
  tactus_curve_run run_{};
};

Interval curve_range(int output, const NodeSetup& setup) {
  return range_of_points(output, setup) * setup.input("level").range;
}

Result<std::unique_ptr<Node>> make_curve(const NodeSetup& setup) {
  if (const char* error = Breakpoints::error_in(curve_points(setup), curve_shape(setup)))
    return fail(Errc::BadArgument, {}, std::string{"'points' is not a curve: "} + error,
                "write [[time, value], ...] with ascending times");
  return std::make_unique<CurveNode>(setup);
}

}  // namespace

NodeType curve_type() {
  return {
      .name = "curve",
      .summary = "Moves through points in time and holds the last value.",
      .equation =
          "t = speed * time since the start, y = level * points(t); between the points (t0, y0) and (t1, "
          "y1), u = (t - t0) / (t1 - t0): "
          "linear y0 + (y1 - y0) u; step y0; smooth: cubic without overshoot, slope continuous",
      .source = "smooth: Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5, 1984",
      .example =
          "stroke = { type = \"curve\", points = [[\"0 s\", \"0 m/s\"], [\"0.1 s\", \"0.1 m/s\"]], unit = "
          "\"m/s\" }",
      .inputs = {{"trigger", "",
                  "restarts the curve; if it is connected, the curve waits for the first trigger", 0},
                 {"speed", "", "factor of the speed, read when the curve starts; 2: half as long", 1, 0, 1e6},
                 {"level", "", "factor of the values, read when the curve starts", 1}},
      .outputs = {{"out", "=unit", "value of the curve"}},
      .settings = {required(
                       {"points",
                        Setting::Kind::Points,
                        "[[time, value], ...] with ascending times; two points at the same time make a jump",
                        {"s", "=unit"}}),
                   choice("curve", "interpolation between two points", {"linear", "step", "smooth"},
                          "linear"),
                   unit_setting("values")},
      .make = make_curve,
      .range = curve_range,
  };
}

}  // namespace tactus
