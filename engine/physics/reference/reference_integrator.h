#pragma once

// Thread: [control]
#include <memory>
#include <span>
#include <vector>

#include "engine/core/units.h"
#include "engine/physics/couplings/contact_law.h"
#include "engine/physics/elements.h"
#include "engine/physics/reference/extrapolation.h"

namespace tactus {

/// The motion of a network itself, from frame to frame: what the solvers are measured against, and
/// nothing that they are made of.
///     m x'' = sum of the forces of `elements.h`,   L i' = V - R i - Bl x'
/// Forces and voltages are held over a frame, driven points go in a straight line from its start to its end.
///
///  - Few points without contacts: by the exponential of the matrix of the system, exact but for rounding
///    (`exact()`).
///  - Otherwise by extrapolation of variable order and step to a local error of `tolerance`, relative to the
///    largest position, velocity or current. A contact that opens or closes, a loss that begins or ends to
///    outweigh the contact's push, a friction that begins or ends to hold, a bond that slips or holds
///    again end a step at that very instant: every step integrates a smooth equation. With a restitution
///    the loss is set by the speed of each impact, at least 0.1 mm/s.
///
/// It is not for real time: a frame takes as long as it needs. Bandwidths of inputs are ignored: the
/// caller filters.
class ReferenceIntegrator {
 public:
  /// Everything that `advance` changes.
  struct State {
    enum class ContactState { Open, Pressing, Releasing };
    std::vector<double> numbers;         ///< positions and velocities of all points, then currents
    std::vector<double> loss;            ///< of each contact: r [s/m]
    std::vector<ContactState> contacts;  ///< of each contact
    /// Of each friction, then of each bond: 0 while it holds, else the sign of the velocity, or of n of a
    /// bond.
    std::vector<double> slide;
    double step_s = 0.0;  ///< what the last frame advises
    Extrapolation extrapolation;
    std::vector<double> next;          ///< numbers at the end of the step
    std::vector<double> inputs;        ///< of the frame: forces, voltages, waves, normal forces, and 1
    std::vector<double> slope;         ///< workspace
    std::vector<double> hold, mutual;  ///< forces of the frictions that hold, and the matrix for them
  };

  /// What acts during a frame, in the order of the elements: applied forces [N], coils [V], ports [N], normal
  /// forces of frictions [N], and where driven points are at its start and at its end [m]. Shorter lists
  /// count as 0, or as rest.
  struct Inputs {
    std::span<const double> forces = {}, voltages = {}, waves = {}, normals = {}, motion_from = {},
                            motion_to = {};
  };

  /// [control] frame > 0.
  ReferenceIntegrator(NetworkElements elements, Seconds frame, double tolerance = 1e-13);

  /// [control] At the start of the network, driven points at rest in `motions`.
  State initial(std::span<const double> motions = {}) const;
  /// [any] The same without allocating, for a state of this network.
  void reset(State& state, std::span<const double> motions = {}) const;
  /// [any] Which contacts press, from positions and velocities: for who has put these into a state.
  void find_contacts(State& state) const;
  /// [any] By one frame. A motion that cannot be followed leaves a state that is not finite.
  void advance(State& state, const Inputs& inputs) const;

  /// [any] As those of `Network`.
  double position(const State& state, int point) const;
  double velocity(const State& state, int point) const;
  double current(const State& state, int coil) const;
  double friction_force(const State& state, int friction) const;
  double friction_velocity(const State& state, int friction) const;
  /// Stored in masses, springs, contacts, bonds and inductances.
  double energy(const State& state) const;

  /// [any] Advances by the exponential of a matrix.
  bool exact() const { return transition_ != nullptr; }

 private:
  using ContactState = State::ContactState;
  struct Transition;

  std::size_t points() const { return elements_.points.size(); }
  std::size_t held() const {
    return elements_.forces.size() + elements_.coils.size() + elements_.ports.size() +
           elements_.frictions.size() + 1;
  }
  double tension_in(const double* numbers, const Spring& spring) const;
  double indentation_in(const double* numbers, std::size_t contact) const;
  double approach_in(const double* numbers, std::size_t contact) const;
  double start_loss(std::size_t contact, double speed) const;
  double current_in(const double* numbers, const double* voltages, std::size_t coil) const;

  void make_transition();
  void multiply(State& state) const;

  void rates(State& state, const double* numbers, double* slope) const;
  void add_springs(const double* numbers, double* force) const;
  void add_contacts(const State& state, const double* numbers, double* force) const;
  void add_held(const State& state, const double* numbers, double* force) const;
  void add_coils(const State& state, const double* numbers, double* slope) const;

  // Frictions and bonds.
  double between(const double* numbers, int lower, int upper) const;
  double push_in(const State& state, const double* numbers, std::size_t contact) const;
  double normal_in(const State& state, const double* numbers, std::size_t friction) const;
  double sliding_force(const State& state, const double* numbers, std::size_t friction, double sign) const;
  double bond_in(const State& state, const double* numbers, std::size_t bond) const;
  void add_slides(const State& state, const double* numbers, double* force) const;
  void hold(State& state, double* force) const;
  void start_slides(State& state) const;
  double friction_margin(State& state, const double* numbers, std::size_t friction) const;
  double bond_margin(const State& state, const double* numbers, std::size_t bond) const;
  void halt(State& state, std::size_t friction) const;
  void switch_friction(State& state, std::size_t friction) const;

  // Steps between events.
  void integrate(State& state) const;
  double try_step(State& state, double longest_s) const;
  void step_again(State& state, double seconds) const;
  double error(const double* numbers, const double* difference) const;
  double contact_margin(const State& state, const double* numbers, std::size_t contact) const;
  double least_margin(State& state, const double* numbers) const;
  double until_event(State& state, double seconds) const;
  double until_turn(State& state, double seconds) const;
  bool turns(const State& state, double seconds, std::size_t contact) const;
  void switch_contact(State& state, std::size_t contact) const;
  void switch_over(State& state) const;

  NetworkElements elements_;
  double frame_s_, tolerance_;
  std::vector<double> inverse_mass_;  // 0: not moved by forces
  std::vector<int> driven_;
  std::vector<ContactLaw> laws_;
  std::vector<double> loss_speed_;  // r v where a restitution sets it, else 0
  std::shared_ptr<const Transition> transition_;
};

}  // namespace tactus
