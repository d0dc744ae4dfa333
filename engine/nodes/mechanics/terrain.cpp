#include <algorithm>

#include "engine/dsp/curves/curve.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/mechanics/terrain_kernel.h"

namespace tactus {
namespace {

class TerrainNode final : public Node {
  enum Input { kPosition, kWeight, kHeight, kLength };
  enum Output { kForce, kZ };

 public:
  TerrainNode(tactus_terrain_profile profile, CubicCurve curve)
      : profile_(profile), curve_(std::move(curve)) {}

  void process(const NodeBlock& block) noexcept override {
    const auto* in = block.in;
    for (int i = 0; i < block.frames; ++i) {
      const auto shape = at(in[kPosition][i], in[kHeight][i], in[kLength][i]);
      block.out[kForce][i] = tactus_terrain_force(in[kWeight][i], shape.slope);
      block.out[kZ][i] = shape.value;
    }
  }
  void reset() noexcept override {}

  std::optional<std::complex<double>> response(int input, int output, std::complex<double>,
                                               std::span<const double> in) const override {
    const auto shape = at(in[kPosition], in[kHeight], in[kLength]);
    if (input == kPosition)
      return output == kForce ? -std::max(0.0, in[kWeight]) * shape.curvature : shape.slope;
    if (input == kWeight) return output == kForce ? -shape.slope : 0.0;
    return std::nullopt;
  }

 private:
  tactus_cubic_point at(double x, double height, double length) const {
    const auto curve = curve_.view();
    return tactus_terrain_at(profile_, &curve, x, height, length);
  }

  tactus_terrain_profile profile_;
  CubicCurve curve_;
};

bool strictly_ascending(const CubicCurve::Points& points) {
  return std::adjacent_find(points.begin(), points.end(),
                            [](const auto& a, const auto& b) { return a.first >= b.first; }) == points.end();
}

Result<std::unique_ptr<Node>> make_terrain(const NodeSetup& setup) {
  const auto& profile = setup.setting("profile").text;
  if (profile != "points")
    return std::make_unique<TerrainNode>(profile == "sine" ? TACTUS_TERRAIN_SINE : TACTUS_TERRAIN_DETENT,
                                         CubicCurve{{}});
  const auto& points = setup.setting("points").points;
  if (points.size() < 2)
    return fail(Errc::Missing, {}, "the profile 'points' needs at least two points",
                "add points = [[x, z], ...]");
  if (!strictly_ascending(points))
    return fail(Errc::BadArgument, {}, "'points' is not a profile: x is not in ascending order",
                "write [[x, z], ...] with ascending x");
  return std::make_unique<TerrainNode>(TACTUS_TERRAIN_POINTS, CubicCurve::spline(points));
}

}  // namespace

NodeType terrain_type() {
  return {
      .name = "terrain",
      .summary = "Detents and textures: the force of sliding without friction over a height profile.",
      .equation =
          "out = -weight dz/dx. detent: z = -height exp(-x^2 / (2 length^2)), near 0 a spring of stiffness "
          "weight height / length^2; sine: z = height cos(2 pi x / length), stiffness at most 4 pi^2 weight "
          "height / length^2; points: cubic spline, level outside. x = position",
      .source = "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.3; spline: de Boor 1978",
      .example =
          "notch = { type = \"terrain\", position = \"fader\", weight = \"1 N\", height = \"1 mm\", length = "
          "\"2 mm\" }",
      .inputs = {{"position", "m", "position of the device"},
                 {"weight", "N", "force that presses the device onto the profile", 1, 0},
                 {"height", "m", "depth of the detent, or amplitude of the sine", 0.001, 0},
                 {"length", "m",
                  "distance between the centre of a detent and its largest force, or period of the sine",
                  0.002, TACTUS_TERRAIN_SHORTEST}},
      .outputs = {{"out", "N", "force on the device"}, {"z", "m", "height of the profile at the position"}},
      .silencers = {{"weight", "out"}},
      .settings = {choice("profile", "shape of the profile; `points` ignores height and length",
                          {"detent", "sine", "points"}, "detent"),
                   {"points", Setting::Kind::Points, "[[x, z], ...] with ascending x", {"m", "m"}},
                   motion_setting()},
      .make = make_terrain,
      .stateless = true,
  };
}

}  // namespace tactus
