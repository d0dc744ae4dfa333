#pragma once

// Thread: [control].

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "engine/physics/solvers/solver_choice.h"
#include "engine/study/stability/models/stability_roots.h"
#include "engine/study/stability/stability_world.h"

namespace tactus {

/// What an analysis concludes; of several conclusions the last in this order counts.
enum class Stability { Stable, Undecided, Unstable };
inline Stability worse(Stability a, Stability b) { return a < b ? b : a; }
/// "stable", "undecided", "unstable"
inline const char* name_of(Stability stability) {
  return stability == Stability::Stable      ? "stable"
         : stability == Stability::Undecided ? "undecided"
                                             : "unstable";
}

/// The stability of a network by itself.
struct NetworkVerdict {
  std::string path, regime;
  Solver solver = Solver::Passive;
  bool has_friction = false;             ///< has frictions, which are left out
  double radius = 0;                     ///< of one frame
  double rate_hz = 0;                    ///< that it runs at: rate times oversample
  std::optional<double> needed_hz = {};  ///< the least stable rate; nullopt: every rate, infinite: none
  std::string weakest = {};              ///< the mode that would grow first
  /// Steps in the strike at 1 m/s that lasts the fewest for what it needs (`ContactDemand::Strike`); with
  /// fewer explicit contacts add energy. Infinite without explicit contacts.
  double contact_steps = std::numeric_limits<double>::infinity();
  double needed_contact_steps = kFewestContactSteps;
  bool too_deep = false;  ///< its initial state presses an explicit contact too stiff for the rate
  /// Where its contacts are the sides of cubic springs and have too few steps: found by throwing its masses,
  /// at 1 m/s, and at 1.2 times that and the start. Stable, if neither grows.
  std::optional<Stability> thrown = {};
  bool within_steps() const { return contact_steps >= needed_contact_steps && !too_deep; }
  bool grows = false;  ///< its linear part
  Stability stability() const;
};

/// A place where a loop was cut open.
struct LoopVerdict {
  std::string at;
  std::vector<std::string> way;  ///< once around
  bool drive = false;            ///< one of the instrument's outputs: its delay is the system's
  bool wave_port = false;        ///< the port of a network: passive
  CutMargin margin;
  /// An integrator: its root at z = 1 is intended.
  bool integrates() const { return margin.border_hz == 0 && margin.border >= 1 && margin.border < 1 + 1e-6; }
  /// Of the root that crosses, a fiftieth below and above the border [1/s].
  double growth_below = 0, growth_above = 0;
  double growing_hz = 0;  ///< of that root above it
};

/// A force that depends on a position: its stiffness, and the limits of it.
struct StiffVerdict : StiffPlace {
  double stable_up_to = 0;  ///< as `stiffness`; infinite: any
  double border_hz = 0;
  std::optional<double>
      passive_up_to;  ///< as `stiffness`; nullopt unless the device is driven by one drive alone
};

/// The stability at one operating point.
struct RegimeVerdict {
  std::string name;
  bool certain = true;  ///< false: its nonlinearities may never be where they are taken together
  bool held = false;    ///< by a fingertip
  int growing = 0;      ///< roots that grow
  std::vector<LoopRoot> roots = {};
  std::vector<LoopVerdict> loops = {};
  std::vector<StiffVerdict> stiff = {};
  std::optional<double> device_damping = {};  ///< [N s/m] of the device, near 0 Hz
  std::vector<std::string> unstable_equilibria =
      {};  ///< nonlinearities whose force pushes away here and restores elsewhere: left out
  bool is_stable() const { return growing == 0; }
};

/// The range of a control in which the system is stable, all others unchanged.
struct ControlVerdict {
  FlatControl control;
  bool stable_low = true, stable_high = true;
  std::optional<double> border = {};  ///< of the stable range, if one end is unstable
};

/// Why there is no verdict, and what to do about it.
struct Doubt {
  std::string reason, remedy;
  bool until_played = false;  ///< runs decide it
  bool operator==(const Doubt&) const = default;
};

/// The stability with the gains that loops have while an input of the instrument is held, where these are
/// others than at rest.
struct HeldVerdict {
  std::string input;
  double level = 0;                  ///< SI
  bool alternates = false;           ///< between this level and its opposite
  std::optional<double> place = {};  ///< that the scene comes to, where the input is then; SI
  std::string unit = {};             ///< of the place: "m", "rad"
  Stability stability = Stability::Stable;
};

/// The stability where the gestures of a scene take a control to its highest or lowest value, with all others
/// as they are then.
struct GestureVerdict {
  std::string control;
  Unit unit;         ///< how people read it
  double value = 0;  ///< SI
  double seconds = 0;
  Stability stability = Stability::Stable;
};

struct StabilityVerdict {
  Hertz rate;
  double delay_s = 0;
  std::vector<NetworkVerdict> networks;
  std::vector<RegimeVerdict> regimes;
  std::vector<EventPlace> events;
  std::vector<ControlVerdict> controls;
  std::vector<GestureVerdict> gestures;
  std::vector<HeldVerdict> held;
  std::vector<OpenPair> open;
  bool nonlinear = false;     ///< the stiffness of some force depends on the position
  bool sampled = false;       ///< something in a loop is sampled less often than once a frame
  bool outside_known = true;  ///< false: an instrument alone; only its inner loops are analysed
  std::vector<Doubt> doubts;  ///< what could not be decided
  Stability stability = Stability::Stable;
  bool stable() const { return stability == Stability::Stable; }
  /// A network, gesture or held input is.
  bool has_undecided_part() const;
};

struct StabilityOptions {
  WorldOptions world;
  Fingertip hand;
  double push = 10.0;  ///< in closed contacts [N]
};

/// [control] `progress` gets the share done; `workers` threads, or one per core. Errors: of the graph.
Checked<StabilityVerdict> analyse_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                            const std::function<void(double)>& progress = {},
                                            int workers = 0);

/// [control] The stability with these options, in all regimes that the world has. Unstable, too, if it cannot
/// be made with them.
Stability stability_with(const StabilitySubject& subject, const WorldOptions& options, double push);

/// [any] The verdict, the most critical place and remedies, a sentence each; the first is the verdict.
std::vector<std::string> describe(const StabilityVerdict& verdict);

}  // namespace tactus
