#include <cmath>

#include "engine/nodes/declare.h"
#include "engine/nodes/mechanics/actuator_inverse_kernel.h"

namespace tactus {
namespace {

class ActuatorInverseNode final : public Node {
  enum Input {
    kVelocity,
    kResistance,
    kInductance,
    kForceFactor,
    kMass,
    kDamping,
    kStiffness,
    kSmoothing,
    kCentring
  };
  enum Output { kVolts, kMovedVelocity, kMovedPosition };

 public:
  explicit ActuatorInverseNode(const NodeSetup& setup) : rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int n = 0; n < block.frames; ++n) {
      const tactus_actuator actuator{in[kResistance][n], in[kInductance][n], in[kForceFactor][n],
                                     in[kMass][n],       in[kDamping][n],    in[kStiffness][n]};
      block.out[kVolts][n] = tactus_actuator_inverse_step(&state_, in[kVelocity][n], &actuator,
                                                          in[kSmoothing][n], in[kCentring][n], rate_);
      block.out[kMovedVelocity][n] = state_.smooth[2];
      block.out[kMovedPosition][n] = state_.position;
    }
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

  std::optional<std::complex<double>> response(int input, int output, std::complex<double> z,
                                               std::span<const double> at) const override {
    if (input != kVelocity) return std::nullopt;
    const double keep = tactus_keep(at[kSmoothing], rate_), stays = tactus_keep(at[kCentring], rate_);
    const auto velocity = std::pow((1 - keep) / (1.0 - keep / z), 3);
    if (output == kMovedVelocity) return velocity;
    const auto position = 1.0 / (rate_ * (1.0 - stays / z)), s = (1.0 - 1.0 / z) * rate_;
    if (output == kMovedPosition) return velocity * position;
    const auto& bl = at[kForceFactor];
    const auto current = (at[kMass] * s + at[kDamping] + at[kStiffness] * position) / bl;
    const auto current_rate = (at[kMass] * s * s + at[kDamping] * s + at[kStiffness]) / bl;
    return velocity * (at[kResistance] * current + at[kInductance] * current_rate + bl);
  }

 private:
  double rate_;
  tactus_actuator_inverse state_{};
};

}  // namespace

NodeType actuator_inverse_type() {
  return {
      .name = "actuator_inverse",
      .summary = "The voltage that moves a voice-coil actuator as planned.",
      .equation =
          "v = planned velocity after three one-pole low-passes of time constant `smoothing`;\n"
          "x = sum of v / rate, which decays within `centring`;\n"
          "i = (mass v' + damping v + stiffness x) / force_factor,\n"
          "out = resistance i + inductance i' + force_factor v;  v' = (v[n] - v[n - 1]) rate.\n"
          "The actuator follows the plan 3 `smoothing` later. What is not in the equation, such as forces of "
          "contact, moves it off the plan",
      .source = "equations of a loudspeaker (Small, J. Audio Eng. Soc. 20, 1972), solved for the voltage",
      .example =
          "cone = { type = \"actuator_inverse\", velocity = \"plan\", resistance = \"6.5 ohm\", force_factor "
          "= \"6 T m\", mass = \"35 g\", damping = \"1.2 N s/m\", stiffness = \"1000 N/m\" }",
      .inputs = {{"velocity", "m/s", "planned velocity of the moving mass"},
                 {"resistance", "ohm", "of the coil", {}, 0, 1e6},
                 {"inductance", "H", "of the coil", 0, 0, 1e3},
                 {"force_factor", "T m", "force per current", {}, 1e-3, 1e6},
                 {"mass", "kg", "moving mass", {}, 0, 1e6},
                 {"damping", "N s/m", "of the suspension", 0, 0, 1e9},
                 {"stiffness", "N/m", "of the suspension", 0, 0, 1e9},
                 {"smoothing", "s",
                  "time constant of each low-pass; longer: lower peaks at corners of the plan", 0.0001, 0, 1},
                 {"centring", "s",
                  "time in which an offset of the position decays; much longer than a motion", 0.2, 0, 1e3}},
      .outputs = {{"out", "V", "voltage at the coil"},
                  {"velocity", "m/s", "planned velocity after the low-passes"},
                  {"position", "m", "planned position"}},
      .silencers = {{"velocity"}},
      .make = make_node<ActuatorInverseNode>,
  };
}

}  // namespace tactus
