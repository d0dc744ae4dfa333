#include "engine/dsp/curves/breakpoints.h"
#include "engine/nodes/elementwise.h"
#include "engine/nodes/shapers/shapers.h"

namespace tactus {
namespace {

struct Map {
  static constexpr int kInputs = 1;
  Breakpoints points;
  double value(const double* in) const { return points.value(in[0]); }
  double slope(int, const double* in) const { return points.slope(in[0]); }
};

Breakpoints::Shape shape(const NodeSetup& setup) {
  return setup.setting("curve").text == "exponential" ? Breakpoints::Shape::Exponential
                                                      : Breakpoints::Shape::Linear;
}

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  const auto& points = setup.setting("points").points;
  if (const char* mistake = Breakpoints::mistake(points, shape(setup)))
    return fail(Errc::BadArgument, {}, std::string{"'points' is not a curve: "} + mistake,
                "write [[x, y], ...] with ascending x");
  return std::make_unique<ElementwiseNode<Map>>(Map{Breakpoints{points, shape(setup)}});
}

Interval range(int, const NodeSetup& setup) {
  const auto& points = setup.setting("points").points;
  if (Breakpoints::mistake(points, shape(setup)) != nullptr) return {};
  const Breakpoints curve{points, shape(setup)};
  return {curve.least(), curve.most()};
}

}  // namespace

const NodeType& map_type() {
  static const NodeType type = {
      .name = "map",
      .group = "shapers",
      .summary = "Translates a signal by a table of points; outside them the first or last value holds.",
      .equation =
          "linear: out = y0 + (y1 - y0) u; exponential: out = y0 (y1 / y0)^u; u = (in - x0) / (x1 - x0) "
          "between "
          "the neighbouring points (x0, y0) and (x1, y1)",
      .source = "elementary",
      .example =
          "pitch = { type = \"map\", in = \"ribbon\", points = [[\"0 mm\", \"110 Hz\"], [\"200 mm\", \"440 "
          "Hz\"]], "
          "unit = \"Hz\", curve = \"exponential\" }",
      .inputs = {{.name = "in", .unit = "any", .doc = "signal"}},
      .outputs = {{.name = "out", .unit = "=unit", .doc = "translated signal"}},
      .settings = {{.name = "points",
                    .kind = Setting::Kind::Points,
                    .doc = "[[in, out], ...], in ascending; two points at one place are a jump",
                    .choices = {"=in", "=unit"}},
                   {.name = "curve",
                    .kind = Setting::Kind::Choice,
                    .doc = "way between two points; exponential needs outputs of one sign",
                    .choices = {"linear", "exponential"},
                    .fallback = "linear"},
                   {.name = "unit",
                    .kind = Setting::Kind::Text,
                    .doc = "unit of the output; left out: a plain number",
                    .optional = true,
                    .unit = true}},
      .make = make,
      .stateless = true,
      .range = range,
  };
  return type;
}

}  // namespace tactus
