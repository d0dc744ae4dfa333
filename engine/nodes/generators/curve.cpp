#include "engine/dsp/curves/curve.h"

#include <cmath>

#include "engine/dsp/envelopes/envelope_kernel.h"
#include "engine/nodes/declare.h"

namespace tactus {
namespace {

Breakpoints::Shape curve_shape(const NodeSetup& setup) {
  const auto& name = setup.setting("curve").text;
  return name == "step" ? TACTUS_CURVE_STEP : name == "smooth" ? TACTUS_CURVE_CUBIC : TACTUS_CURVE_LINEAR;
}

/// Times become frames; those within a millionth of a frame of a whole one become whole, so that "3 ms" at 48
/// kHz is frame 144 and not a rounding error later.
Breakpoints::Points in_frames(Breakpoints::Points points, Hertz sample_rate) {
  for (auto& [x, y] : points) {
    x = frames_in(Seconds{x}, sample_rate);
    if (std::abs(x - std::round(x)) < 1e-6) x = std::round(x);
  }
  return points;
}

class CurveNode final : public Node {
 public:
  CurveNode(const NodeSetup& setup, const Breakpoints::Points& points)
      : points_(in_frames(points, setup.sample_rate), curve_shape(setup)),
        waits_(setup.input("trigger").connected) {}

  void process(const NodeBlock& block) noexcept override {
    for (int i = 0; i < block.frames; ++i) {
      const std::int64_t frame = block.first_frame + i;
      if (tactus_rise_step(&rise_, block.in[0][i]) != 0) {
        start_ = frame;
        started_ = true;
      }
      const bool waiting = waits_ && !started_;
      block.out[0][i] = points_.value(waiting ? 0.0 : static_cast<double>(frame - start_));
    }
  }
  void reset() noexcept override {
    rise_ = {};
    start_ = 0;
    started_ = false;
  }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  Breakpoints points_;
  bool waits_;
  tactus_rise rise_{};
  std::int64_t start_ = 0;
  bool started_ = false;
};

Result<std::unique_ptr<Node>> make_curve(const NodeSetup& setup) {
  const auto& points = setup.setting("points").points;
  if (const char* error = Breakpoints::error_in(in_frames(points, setup.sample_rate), curve_shape(setup)))
    return fail(Errc::BadArgument, {}, std::string{"'points' is not a curve: "} + error,
                "write [[time, value], ...] with ascending times");
  return std::make_unique<CurveNode>(setup, points);
}

}  // namespace

NodeType curve_type() {
  return {
      .name = "curve",
      .summary = "Moves through points in time and holds the last value.",
      .equation =
          "t = time since the start; between the points (t0, y0) and (t1, y1), u = (t - t0) / (t1 - t0): "
          "linear y0 + (y1 - y0) u; step y0; smooth: cubic without overshoot, slope continuous",
      .source = "smooth: Fritsch & Butland, SIAM J. Sci. Stat. Comput. 5, 1984",
      .example =
          "stroke = { type = \"curve\", points = [[\"0 s\", \"0 m/s\"], [\"0.1 s\", \"0.1 m/s\"]], unit = "
          "\"m/s\" }",
      .inputs = {{"trigger", "",
                  "restarts the curve; if it is connected, the curve waits for the first trigger", 0}},
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
      .range = range_of_points,
  };
}

}  // namespace tactus
