
#include <algorithm>

#include "engine/dsp/curves/cubic_curve.h"
#include "engine/nodes/mechanics/mechanics.h"
#include "engine/nodes/mechanics/terrain_kernel.h"

namespace tactus {
namespace {

constexpr double kShortest = 1e-6;
enum Input { kPosition, kWeight, kHeight, kLength };
enum Output { kForce, kZ };

using Shape = tactus_terrain_shape;

/// Each profile: what it looks like at a place, given `height` and `length`.
struct Detent {
  Shape at(double x, double height, double length) const { return tactus_terrain_detent(x, height, length); }
};
struct Sine {
  Shape at(double x, double height, double length) const { return tactus_terrain_sine(x, height, length); }
};
struct Drawn {
  CubicCurve curve;
  Shape at(double x, double, double) const {
    const auto view = curve.view();
    return tactus_terrain_points(&view, x);
  }
};

template <class Profile>
class Terrain final : public Node {
 public:
  explicit Terrain(Profile profile) : profile_(std::move(profile)) {}

  void process(const NodeBlock& block) noexcept override {
    for (int i = 0; i < block.frames; ++i) {
      const Shape shape = at(block.in[kPosition][i], block.in[kHeight][i], block.in[kLength][i]);
      block.out[kForce][i] = tactus_terrain_force(block.in[kWeight][i], shape.slope);
      block.out[kZ][i] = shape.height;
    }
  }
  void reset() noexcept override {}

  std::optional<std::complex<double>> response(int input, int output, std::complex<double>,
                                               std::span<const double> in) const override {
    const Shape shape = at(in[kPosition], in[kHeight], in[kLength]);
    if (input == kPosition)
      return output == kForce ? -std::max(0.0, in[kWeight]) * shape.curvature : shape.slope;
    if (input == kWeight) return output == kForce ? -shape.slope : 0.0;
    return std::nullopt;
  }

 private:
  Shape at(double x, double height, double length) const {
    return profile_.at(x, std::max(0.0, height), std::max(kShortest, length));
  }
  Profile profile_;
};

bool strictly_ascending(const CubicCurve::Points& points) {
  return std::adjacent_find(points.begin(), points.end(),
                            [](const auto& a, const auto& b) { return a.first >= b.first; }) == points.end();
}

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  const auto& profile = setup.setting("profile").text;
  if (profile == "detent") return std::make_unique<Terrain<Detent>>(Detent{});
  if (profile == "sine") return std::make_unique<Terrain<Sine>>(Sine{});
  const auto& points = setup.setting("points").points;
  if (points.size() < 2)
    return fail(Errc::Missing, {}, "the profile 'points' needs at least two points",
                "add points = [[x, z], ...]");
  if (!strictly_ascending(points))
    return fail(Errc::BadArgument, {}, "'points' is not a profile: x does not ascend",
                "write [[x, z], ...] with ascending x");
  return std::make_unique<Terrain<Drawn>>(Drawn{CubicCurve::spline(points)});
}

}  // namespace

const NodeType& terrain_type() {
  static const NodeType type = {
      .name = "terrain",
      .group = "mechanics",
      .summary = "Detents and textures: the force of sliding over a profile of heights, without friction.",
      .equation =
          "out = -weight dz/dx. detent: z = -height exp(-x^2 / (2 length^2)), near 0 a spring of stiffness "
          "weight height / "
          "length^2; sine: z = height cos(2 pi x / length), stiffness at most 4 pi^2 weight height / "
          "length^2; points: "
          "cubic spline, level outside. x = position",
      .source = "Berdahl, Steiner & Oldham, NIME 2008, section 6.1.3; spline: de Boor 1978",
      .example =
          "notch = { type = \"terrain\", position = \"fader\", weight = \"1 N\", height = \"1 mm\", length = "
          "\"2 mm\" }",
      .inputs = {{.name = "position", .unit = "m", .doc = "position of the device"},
                 {.name = "weight",
                  .unit = "N",
                  .doc = "presses the device onto the profile",
                  .fallback = 1,
                  .low = 0},
                 {.name = "height",
                  .unit = "m",
                  .doc = "depth of the detent, amplitude of the sine",
                  .fallback = 0.001,
                  .low = 0},
                 {.name = "length",
                  .unit = "m",
                  .doc = "distance of a detent's strongest force from its centre, period of the sine",
                  .fallback = 0.002,
                  .low = kShortest}},
      .outputs = {{.name = "out", .unit = "N", .doc = "force on the device"},
                  {.name = "z", .unit = "m", .doc = "height of the profile at the position"}},
      .settings = {{.name = "profile",
                    .kind = Setting::Kind::Choice,
                    .doc = "shape of the ground; `points` makes no use of height and length",
                    .choices = {"detent", "sine", "points"},
                    .fallback = "detent"},
                   {.name = "points",
                    .kind = Setting::Kind::Points,
                    .doc = "[[x, z], ...], x ascending",
                    .choices = {"m", "m"},
                    .optional = true}},
      .make = make,
      .stateless = true,
  };
  return type;
}

}  // namespace tactus
