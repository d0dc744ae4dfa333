#include <cmath>
#include <memory>
#include <numbers>

#include "engine/nodes/networks/element_types.h"

// A magnet: Coulomb's law of two poles, softened after Plummer (Mon. Not. R. Astron. Soc. 71, 1911), as
// N-body simulations soften gravity:
//   V(n) = -E / w,  w = sqrt(1 + s^2),  s = n / a;   F = dV/dn = (E / a) s / w^3
// F is largest at s = 1/sqrt(2), where it is 2 E / (sqrt(27) a), and falls as 1/n^2 far away.
namespace tactus {
namespace {

class PlummerBond final : public BondLaw {
 public:
  /// The largest force is at the distance `reach`.
  PlummerBond(double strength, double reach)
      : length_(std::numbers::sqrt2 * reach),
        depth_(0.5 * std::sqrt(27.0) * length_ * strength),
        root_depth_(std::sqrt(2.0 * depth_)) {}

  /// psi^2 / 2 = V - V(0) = E (1 - 1/w), with 1 - 1/w = s^2 / (w (1 + w)).
  double root(double n) const noexcept override {
    const double s = n / length_, w = std::sqrt(1.0 + s * s);
    return root_depth_ * s / std::sqrt(w * (1.0 + w));
  }
  double root_slope(double n) const noexcept override {
    const double w = std::sqrt(1.0 + (n / length_) * (n / length_));
    return 0.5 * root_depth_ / length_ * std::sqrt(w * (1.0 + w)) / (w * w * w);
  }
  double force(double n) const noexcept override {
    const double s = n / length_, w = std::sqrt(1.0 + s * s);
    return depth_ / length_ * s / (w * w * w);
  }
  /// On one side (psi2 - psi1)(psi2 + psi1) / 2 = E (s2 - s1)(s2 + s1) / (w1 w2 (w1 + w2)).
  Chord chord(double from, double to) const noexcept override {
    const double s = from / length_, t = to / length_, v = std::sqrt(1.0 + s * s), w = std::sqrt(1.0 + t * t);
    double slope = root_slope(from);
    if (s * t > 0.0)
      slope = 2.0 * depth_ / length_ * (s + t) / (v * w * (v + w) * (root(from) + root(to)));
    else if (from != to)
      slope = (root(to) - root(from)) / (to - from);
    return {slope, slope * slope};
  }
  double stiffness(double n) const noexcept override {
    const double s = n / length_, w = std::sqrt(1.0 + s * s);
    return largest_stiffness() * (1.0 - 2.0 * s * s) / std::pow(w, 5);
  }
  double largest_stiffness() const noexcept override { return depth_ / (length_ * length_); }
  double largest_energy(double) const noexcept override { return depth_; }
  Well well() const noexcept override { return {length_, depth_}; }

 private:
  double length_, depth_, root_depth_;  ///< a [m], E [J], sqrt(2 E)
};

void build_attraction(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.bond = b.append(b.elements.bonds,
                        Bond{b.end(e, 1), b.end(e, 0),
                             std::make_shared<PlummerBond>(b.number(e, "strength"), b.number(e, "reach"))});
}

}  // namespace

std::vector<ElementType> attraction_elements() {
  return {{.name = "attraction",
           .doc = "A magnet: pulls two points together, with the largest force at the distance `reach` and "
                  "an inverse-square decrease beyond it; the force at distance 0 is 0. Lossless: add a "
                  "damper in parallel.",
           .equation = "force = strength x (3 / (2 + x^2))^(3/2),  x = (x_second - x_first) / reach",
           .ends = ElementType::Ends::Between,
           .fields = {required("strength", "N", "largest force", kTiny),
                      required("reach", "m", "distance at which the force is largest", kTiny)},
           .quantities = {{"force", "N", "force, positive if it pulls the ends together",
                           read_part<&Network::bond_force, &ElementParts::bond>()},
                          {"distance", "m", "second end - first end",
                           read_part<&Network::bond_distance, &ElementParts::bond>()}},
           .example =
               "magnet = { type = \"attraction\", between = [\"base\", \"stick\"], strength = \"2 N\", "
               "reach = \"3 mm\" }",
           .build = build_attraction,
           .linear = false}};
}

}  // namespace tactus
