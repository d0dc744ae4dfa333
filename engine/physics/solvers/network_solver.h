#pragma once

// Thread: [any], except where a function says otherwise
#include "engine/physics/network_model.h"
#include "engine/physics/network_state.h"

namespace tactus {

/// A way of stepping a network. It owns what is worked out when the network is made; the model outlives it.
class NetworkSolver {
 public:
  virtual ~NetworkSolver() = default;

  /// [realtime] From positions in `state` and the model's velocities to a consistent start.
  virtual void start(NetworkState& state) const noexcept = 0;
  /// [realtime] What the contacts hold follows from where everything is (after an edit of stiffnesses).
  virtual void store_energy(NetworkState& state) const noexcept = 0;
  /// [realtime] One step of k seconds, with forces, voltages, waves, normal forces and the driven points'
  /// next places in `state`. Adds to `wave_back` what goes out of each port.
  virtual void step(NetworkState& state) const noexcept = 0;
  /// [realtime] Stored in masses, springs, contacts, bonds and inductances, in the form that the solver
  /// conserves.
  virtual double energy(const NetworkState& state) const noexcept = 0;
  /// [realtime] Of a slot. [m/s]
  virtual double velocity(const NetworkState& state, int slot) const noexcept = 0;
  /// [realtime] Of a coil. [A]
  virtual double current(const NetworkState& state, int coil) const noexcept = 0;

  /// [any] A step sees a held input at its instant, so between two frames the mean of both.
  virtual bool centred() const = 0;
  /// [any] Springs are averaged over the instants of a step: stable whatever the stiffness.
  virtual bool springs_averaged() const { return false; }
  /// [any] Multiplications of a step without contact, and of each closed contact.
  struct Cost {
    double step, contact;
  };
  virtual Cost cost() const = 0;
};

}  // namespace tactus
