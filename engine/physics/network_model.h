#pragma once

// Thread: [control]
#include <optional>
#include <vector>

#include "engine/physics/couplings/contact_law.h"
#include "engine/physics/elements.h"
#include "engine/physics/solvers/critical_low_pass.h"
#include "engine/physics/solvers/link_operator.h"

namespace tactus {

/// The elements of a network as all solvers use them. Places are *slots*: masses in the
/// order of the elements, then driven points, then fixed ones. Never changes once it is made.
struct NetworkModel {
  struct Contact {
    int lower, upper;
    double offset, loss;
    double loss_speed;  ///< r v where a restitution sets it, else 0
    ContactLaw law;
  };
  /// A signal that acts on a slot; `low_pass` is its place in `low_passes`, or -1.
  struct Driven {
    int slot;
    NetworkInput input;
    int low_pass;
  };
  struct Coil {
    int on, against;
    double force_factor, inductance, resistance;
    double memory, impedance;  ///< 2L/k, 2L/k + R
    double half_step_decay;    ///< exp(-R k / 2L)
    Driven voltage;
  };
  struct Friction {
    int lower, upper;
    FrictionLaw law;
    double viscous;
    Driven normal;
    int normal_contact, normal_spring;
  };
  struct Port {
    double impedance;
    Driven wave;
  };

  /// [control] Steps of `step_s` seconds; `signals` inputs are handed to each frame.
  NetworkModel(NetworkElements elements, int signals, double step_s);

  /// K and C as entries: rows are masses, columns masses and driven points; what fixed points do is constant.
  /// `LinkOperator::Entry::b` is C/k.
  struct Links {
    std::vector<LinkOperator::Entry> entries;
    std::vector<double> constant;
  };
  /// [control] Coils with an inductance hold a current of their own: with `eliminated`, as the damper that
  /// centred steps leave of them; else not at all.
  Links links(bool eliminated = true) const;
  /// [control] An upper bound of the largest eigenvalue of M^-1 (k_share K + b_share C/k), exact for small
  /// networks.
  double stiffest(double k_share, double b_share) const;

  bool is_mass(int of) const { return of < masses; }
  bool moves(int of) const { return of < masses + static_cast<int>(motions.size()); }

  double k;  ///< seconds a step
  int signals = 0, masses = 0;
  std::vector<int> slot;                                            ///< of each point of the elements
  std::vector<double> mass, scale, start_position, start_velocity;  ///< scale: k^2 / mass
  std::vector<Spring> springs;                                      ///< these and all that follow name slots
  std::vector<Contact> contacts;
  std::vector<Coil> coils;
  std::vector<Driven> forces, motions;
  std::vector<Friction> frictions;
  std::vector<Bond> bonds;
  std::vector<Port> ports;
  std::vector<CriticalLowPass> low_passes;

 private:
  Driven driven(int of, const NetworkInput& input);
  void take_points(NetworkElements& elements);
  void take_links(NetworkElements& elements);
};

}  // namespace tactus
