#include <utility>

#include "engine/nodes/declare.h"
#include "engine/nodes/filters/mode_table.h"
#include "engine/nodes/mechanics/modal_body_setup.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

class ModalBodyNode final : public Node {
  enum Output { kWave, kVelocity, kPosition, kForce };

 public:
  ModalBodyNode(Hertz sample_rate, double impedance, std::vector<BodyMode> modes)
      : sample_rate_(sample_rate),
        impedance_(impedance),
        modes_(std::move(modes)),
        body_(modes_, impedance, sample_rate) {}

  void process(const NodeBlock& block) noexcept override {
    for (int n = 0; n < block.frames; ++n) {
      const auto answer = body_.step(block.in[0][n]);
      // What joins two ports pushes both apart; here up is up as for the mass on the other side.
      const double values[] = {answer.wave, -answer.velocity, -answer.position, -answer.force};
      for (std::size_t i = 0; i < std::size(values); ++i)
        if (block.out[i] != nullptr) block.out[i][n] = values[i];
    }
  }
  void reset() noexcept override { body_.reset(); }
  void copy(const Node& other) noexcept override { assign(*this, other); }
  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const ModalBodyNode*>(&before)) body_.adopt(other->body_);
  }

  std::optional<std::complex<double>> response(int input, int output, std::complex<double> z,
                                               std::span<const double>) const override {
    if (input != 0) return std::nullopt;
    const auto delay = 1.0 / z;
    const auto admittance = admittance_at(delay);
    const auto velocity = 2.0 * admittance / (1.0 + impedance_ * admittance);
    switch (output) {
      case kVelocity:
        return -velocity;
      case kPosition:
        return -velocity * (1.0 + delay) / (2 * sample_rate_.value * (1.0 - delay));
      case kForce:
        return impedance_ * velocity - 2.0;
      default:
        return 1.0 - impedance_ * velocity;
    }
  }

 private:
  std::complex<double> admittance_at(std::complex<double> delay) const {
    std::complex<double> sum = 0;
    for (const auto& mode : modes_)
      if (mode.frequency_hz < sample_rate_.value / 2)
        sum += BodyModeDesign{mode, sample_rate_}.admittance(delay);
    return sum;
  }

  Hertz sample_rate_;
  double impedance_;
  std::vector<BodyMode> modes_;
  ModalBody body_;
};

double fixed_value(const NodeSetup& setup, std::string_view name) {
  const auto& port = setup.type->inputs[static_cast<std::size_t>(setup.type->input_index(name))];
  return setup.input(name).constant.value_or(port.fallback.value_or(0));
}

/// As listed, or scaled so that the first is `mass`; without a list all are `mass`.
Result<std::vector<double>> masses_of(const NodeSetup& setup, std::size_t modes) {
  const auto& list = setup.setting("masses");
  const double mass = fixed_value(setup, "mass");
  auto masses = one_each(list, "masses", modes, mass);
  if (!masses) return masses;
  for (const double m : *masses)
    if (!(m > 0))
      return fail(Errc::OutOfRange, {}, "one of 'masses' is not above 0",
                  "omit the modes that do not move at the point of contact");
  if (list.given && setup.input("mass").connected) {
    const double scale = mass / masses->front();
    for (double& m : *masses) m *= scale;
  }
  return masses;
}

Result<std::unique_ptr<Node>> make_modal_body(const NodeSetup& setup) {
  auto body = body_setup(setup);
  if (!body) return tl::unexpected(body.error());
  if (const auto fits = setup.take_memory(12 * body->modes.size()); !fits)
    return tl::unexpected(fits.error());
  return std::make_unique<ModalBodyNode>(setup.sample_rate, body->impedance, std::move(body->modes));
}

}  // namespace

Result<BodySetup> body_setup(const NodeSetup& setup) {
  const auto table = ModeTable::make(setup);
  if (!table) return tl::unexpected(table.error());
  const auto masses = masses_of(setup, table->size());
  if (!masses) return tl::unexpected(masses.error());
  BodySetup body{fixed_value(setup, "impedance"), {}};
  for (std::size_t k = 0; k < table->size(); ++k)
    body.modes.push_back({.frequency_hz = table->frequency_hz(k, fixed_value(setup, "frequency")),
                          .decay_s = table->decay_s(k, fixed_value(setup, "decay")),
                          .mass_kg = (*masses)[k]});
  return body;
}

NodeType modal_body_type() {
  return {
      .name = "modal_body",
      .summary = "A body with many modes, moved by a network's `port`: bar, plate, drum head, sound board.",
      .equation =
          "force = -(wave_in + wave),  wave = wave_in + impedance velocity; up is up as for the mass at the "
          "port\n"
          "mass_k v_k' + c_k v_k + k_k integral of v_k = force,  velocity = sum of v_k,  position = its "
          "integral\n"
          "Each mode rings at f_k and decays by 60 dB in decay_k exactly (trapezoidal rule, with matching "
          "c_k and k_k); modes at or above half the sample rate are omitted. Energy enters only through the "
          "port: the sum of (wave_in^2 - wave^2) / (impedance fs) is the energy stored and lost in the "
          "body.\nConnected to a port of the same impedance, each side responds to the other at most one "
          "frame later, like a thin rod of mass impedance / (2 fs) and stiffness 2 impedance fs between them",
      .source =
          "Bilbao, Wave and Scattering Methods for Numerical Simulation, 2004, chapter 2; series: Fletcher & "
          "Rossing, The Physics of Musical Instruments, 2nd ed. 1998",
      .example =
          "{ type = \"modal_body\", wave = \"mallet.felt.wave\", impedance = \"20 N s/m\", frequency = \"220 "
          "Hz\", series = \"bar\", modes = 12, decay = \"1 s\", mass = \"50 g\" }",
      .inputs =
          {{"wave", "N", "incoming force wave: the `wave` of a network's port"},
           fixed(
               {"impedance", "N s/m", "wave impedance, equal to that of the connected port", {}, 1e-9, 1e9}),
           fixed(mode_frequency_input()),
           fixed(mode_decay_input()),
           fixed({"mass", "kg",
                  "effective mass of the first mode at the point of contact; without `masses`, of all modes",
                  1, 1e-9, 1e9})},
      .outputs = {{"wave", "N", "outgoing force wave"},
                  {"velocity", "m/s", "velocity of the point of contact"},
                  {"position", "m", "position of the point of contact"},
                  {"force", "N", "force on the body"}},
      .silencers = {{"wave"}},
      .settings = mode_settings(
          {{"masses",
            Setting::Kind::Numbers,
            "effective masses of the modes at the point of contact: one number for all, or one per mode",
            {"kg"}}}),
      .make = make_modal_body,
      .skips_unused_outputs = true};
}

}  // namespace tactus
