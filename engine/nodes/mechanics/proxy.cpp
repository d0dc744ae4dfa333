#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "engine/core/index.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/mechanics/proxy_setup.h"

namespace tactus {
namespace {

class ProxyNode final : public Node {
  enum Output { kForce, kProxy = 3, kDepth = 6, kTouches, kSlips, kOutputs };
  using Inputs = std::array<double, kProxyInputs>;

 public:
  explicit ProxyNode(ProxySetup setup) : setup_(std::move(setup)) {}

  void process(const NodeBlock& block) noexcept override {
    Inputs in;
    std::array<double, kOutputs> out;
    for (int n = 0; n < block.frames; ++n) {
      for (std::size_t i = 0; i < in.size(); ++i) in[i] = block.in[i][n];
      step(state_, in, out);
      for (std::size_t o = 0; o < out.size(); ++o) block.out[o][n] = out[o];
    }
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override {
    if (const auto* same = dynamic_cast<const ProxyNode*>(&other)) state_ = same->state_;
  }

  /// Of the position, where the proxy is now: none out of touch; in touch that of the spring, which friction
  /// holds sideways. nullopt where the proxy follows late, far towards the centre of a sphere.
  std::optional<std::complex<double>> response(int input, int output, std::complex<double>,
                                               std::span<const double> at) const override {
    if (input >= 3 || output >= kDepth) return std::nullopt;
    constexpr int kSettle = 64;
    constexpr double kStep = 1e-7, kLate = 0.01;
    Inputs in;
    std::copy_n(at.begin(), in.size(), in.begin());
    std::array<double, kOutputs> out;
    const auto after = [&](tactus_proxy& state, const Inputs& there, int frames) {
      for (int n = 0; n < frames; ++n) step(state, there, out);
      return out[index(output)];
    };
    auto rest = state_;
    after(rest, in, kSettle);
    const auto slope = [&](int frames) {
      auto above = rest, below = rest;
      auto up = in, down = in;
      up[index(input)] += kStep;
      down[index(input)] -= kStep;
      return (after(above, up, frames) - after(below, down, frames)) / (2 * kStep);
    };
    const double soon = slope(1), settled = slope(kSettle);
    if (std::abs(soon - settled) > kLate * std::max(std::abs(soon), std::abs(settled))) return std::nullopt;
    return settled;
  }

 private:
  void step(tactus_proxy& state, const Inputs& in, std::array<double, kOutputs>& out) const noexcept {
    const auto solid =
        tactus_solid_of(setup_.shape, &in[kProxySolid], setup_.heights.data(), setup_.rows, setup_.columns);
    const double* const centre = &in[kProxyPlace];
    const double device[] = {in[0] - centre[0], in[1] - centre[1], in[2] - centre[2]};
    const auto felt = tactus_proxy_step(&state, &solid, device, in[3], in[4]);
    for (std::size_t i = 0; i < 3; ++i) {
      out[kForce + i] = felt.force[i];
      out[kProxy + i] = state.at[i] + centre[i];
    }
    out[kDepth] = felt.depth;
    out[kTouches] = state.side > 0;
    out[kSlips] = state.slips;
  }

  ProxySetup setup_;
  tactus_proxy state_{};
};

InputPort at_least(double low, InputPort port) { return port.low = low, port; }

}  // namespace

Result<ProxySetup> proxy_setup(const NodeSetup& setup) {
  const std::string shape = setup.setting("shape").text;
  ProxySetup made;
  made.shape = shape == "sphere"    ? TACTUS_SOLID_SPHERE
               : shape == "box"     ? TACTUS_SOLID_BOX
               : shape == "heights" ? TACTUS_SOLID_HEIGHTS
                                    : TACTUS_SOLID_PLANE;
  if (made.shape != TACTUS_SOLID_HEIGHTS) return made;
  made.heights = setup.setting("heights").numbers;
  const auto count = static_cast<int>(std::ssize(made.heights));
  const auto& columns = setup.setting("columns");
  made.columns = columns.number > 0 ? static_cast<int>(columns.number) : count;
  if (count < 2)
    return fail(Errc::Missing, {}, "the shape 'heights' needs at least two heights",
                "add heights = [\"0 mm\", \"2 mm\", ...]");
  if (made.columns < 2 || count % made.columns != 0)
    return fail(Errc::BadArgument, {},
                std::to_string(count) + " heights do not make whole rows of " + std::to_string(made.columns),
                "let 'columns' be the number of heights in each row, at least 2");
  made.rows = count / made.columns;
  return made;
}

NodeType proxy_type() {
  return {
      .name = "proxy",
      .summary =
          "Contact with a solid, in two or three axes: a proxy stays on its surface, held by friction, and a "
          "spring pulls the device to it.",
      .equation =
          "force = stiffness (proxy - device) while in touch, else 0\n"
          "proxy: the place of the surface nearest to the device, reached along the surface; it moves only\n"
          "as far as the part of the force along the surface is at most friction times that across it\n"
          "plane: all behind the plane through at_*, across normal_*;  sphere: radius size_x\n"
          "box: half sides size_*;  heights: all below z = at_z + h(x, y), h from a grid of `pitch` about\n"
          "at_x, at_y, linear between its points and level beyond. In two axes leave the third out",
      .source =
          "Zilles & Salisbury, A constraint-based god-object method for haptic display, IROS 1995; friction: "
          "Ruspini, Kolarov & Khatib, SIGGRAPH 1997",
      .example =
          "touch = { type = \"proxy\", shape = \"sphere\", x = \"tip_x\", y = \"tip_y\", z = \"tip_z\", "
          "stiffness = \"500 N/m\", friction = 0.3, size_x = \"20 mm\" }",
      .inputs = {{"x", "m", "position of the device", 0},
                 {"y", "m", "position of the device", 0},
                 {"z", "m", "position of the device", 0},
                 {"stiffness", "N/m", "stiffness (force per distance from the proxy)", {}, 0},
                 {"friction", "", "coefficient of friction, at rest and sliding", 0, 0},
                 {"at_x", "m", "place of the solid: its centre, or a point of the plane", 0},
                 {"at_y", "m", "place of the solid", 0},
                 {"at_z", "m", "place of the solid", 0},
                 {"normal_x", "", "direction out of the plane, of any length", 0},
                 {"normal_y", "", "direction out of the plane", 0},
                 {"normal_z", "", "direction out of the plane; all three 0: z", 0},
                 at_least(TACTUS_SOLID_SMALLEST,
                          {"size_x", "m", "radius of the sphere, half a side of the box", 0.02}),
                 at_least(TACTUS_SOLID_SMALLEST, {"size_y", "m", "half a side of the box", 0.02}),
                 at_least(TACTUS_SOLID_SMALLEST, {"size_z", "m", "half a side of the box", 0.02}),
                 at_least(TACTUS_SOLID_SMALLEST,
                          {"pitch", "m", "distance between heights, in x and y", 0.01})},
      .outputs = {{"force_x", "N", "force on the device"},
                  {"force_y", "N", "force on the device"},
                  {"force_z", "N", "force on the device"},
                  {"proxy_x", "m", "position of the proxy; out of touch that of the device"},
                  {"proxy_y", "m", "position of the proxy"},
                  {"proxy_z", "m", "position of the proxy"},
                  bounded(0, kUnlimited, {"depth", "m", "how far the device is behind the surface"}),
                  bounded(0, 1, {"touches", "", "1 while in touch"}),
                  bounded(0, 1, {"slips", "", "1 while the proxy slides"})},
      .silencers = {{"stiffness", "force_x"}, {"stiffness", "force_y"}, {"stiffness", "force_z"}},
      .settings = {choice("shape", "of the solid", {"plane", "sphere", "box", "heights"}, "plane"),
                   {"heights", Setting::Kind::Numbers, "of the surface, row by row in y", {"m"}},
                   {"columns",
                    Setting::Kind::Integer,
                    "heights in each row; 0: all, the surface does not depend on y",
                    {},
                    "0",
                    false,
                    0,
                    100000}},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        auto made = proxy_setup(setup);
        if (!made) return tl::unexpected(made.error());
        return std::make_unique<ProxyNode>(std::move(*made));
      },
  };
}

}  // namespace tactus
