#include "engine/dsp/curves/curve.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

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

}  // namespace

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

}  // namespace tactus
