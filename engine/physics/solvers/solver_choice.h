#pragma once

// Thread: [control]
#include <vector>

#include "engine/core/units.h"
#include "engine/physics/elements.h"
#include "engine/physics/solvers/network_solver.h"

namespace tactus {

/// The strike that a contact has to bear: its bodies meet at this speed. [m/s]
inline constexpr double kHardestStrike = 1.0;

/// Bounds on the contacts and bonds of a network, from its start values. A contact stiffens with depth.
///
///  - **How short it is**, with alpha the exponent and m the reduced mass of its two bodies, at the speed v
///    that they may have by themselves: `kHardestStrike`, or what the start gives them,
///    v^2 = v_start^2 + 2 phi(n_start) / m:
///      t = 2 sqrt(pi) Gamma(1 + 1/(alpha+1)) / Gamma(1/2 + 1/(alpha+1)) ((alpha+1) m v^2 / 2K)^(1/(alpha+1))
///      / v
///  - **How stiff it gets**: no contact is deeper than where it holds all the energy E that the network
///    starts with, together with that of a strike of the heaviest body, phi(n) = E; there it is a spring and
///    a damper
///      k = alpha K n^(alpha-1),   z = r K n^alpha.
///    Of two contacts that act in opposite ways between the same points only one is ever closed.
struct ContactDemand {
  struct Strike {
    double exponent, restitution;  ///< of the speeds; 1: without loss
    double time_s;                 ///< without loss
    bool spring;                   ///< one side of a spring: the other side follows at once
    bool pressed;                  ///< at the start, by a contact with loss

    /// Explicit steps make energy of it below so many.
    double fewest_steps() const;
  };
  std::vector<Strike> strikes;  ///< for each exponent and restitution the shortest
  double stiffness = 0.0;       ///< bounds the largest eigenvalue of M^-1 K of all k together [1/s^2]
  double bond_stiffness = 0.0;  ///< the same of the bonds alone
  double damping = 0.0;         ///< the same of all z [1/s]
  double bond_damping = 0.0;    ///< the same of the bonds alone
  double line_damping = 0.0;    ///< the same of the bonds of several axes alone
};

/// [control]
ContactDemand contact_demand(const NetworkElements& elements);

/// What solvers other than `explicit` need of a spring that is made of two contacts: half a period lasts so
/// many steps. The exact solver makes energy of springs of 1/300, where one contact returns what rounding has
/// left of a force 10^6 times that of its mass; the others of 1/250,000.
inline constexpr double kShortestSpring = 0.01;

/// What a step of a solver makes of y'' + c y' + w^2 y = 0.
enum class Stepping { Explicit, Centred, Averaged, Exact };

/// The error of an oscillator: of one that swings the larger of the relative errors of its frequency and its
/// decay; of one that does not, how far its two decays are ever off, relative to their start.
/// `square` = (w k)^2, `damping` = c k. 1: it is not like the oscillator at all.
double oscillator_error(Stepping stepping, double square, double damping);

/// Bounds on a solver for a network, from operation counts and never from a clock, so it is the same on
/// every machine.
struct SolverBounds {
  Solver solver;
  int oversample;
  double multiplications = 0;  ///< a frame, with one closed contact
  bool stable = false;         ///< the linear part, and contacts as far as `ContactDemand` goes
  /// Largest relative error of a resonance, of a decay, of a contact's time or restitution.
  double error = 0;
  /// The largest error in time of a contact that is shorter than `kShortContact`, which `error` leaves out;
  /// 0: there is none. [frames]
  double contact_frames = 0;
  /// Each stop and slip of a friction or a plectrum is within so many frames of where it would be if its
  /// forces were larger or smaller by a share of at most `slip_error`; 0: nothing slips.
  double slip_frames = 0, slip_error = 0;
  /// What has no bound: what loads a friction or a plectrum changes too fast (`kFastestLoad`); a contact with
  /// loss that is pressed at the start is open again before its loss is resolved (`kShortContact`).
  bool slips_unknown = false, opens_unknown = false;
  bool bounded() const { return !slips_unknown && !opens_unknown; }
  /// What speaks against it.
  enum class Limit {
    None,
    CannotBeMade,  ///< too many masses or contacts for it
    TooStiff,      ///< springs or dampers make it unstable
    ShortContact,  ///< the hardest strike lasts `contact_steps`, too few to keep its energy
    DeepContact,   ///< what the network starts with, or the hardest strike, can press one too stiff
    Inexact,       ///< `error`
  } limit = Limit::None;
  double contact_steps = 0;
};

/// What counts as accurate: 1 %, 17 cents.
inline constexpr double kGoodEnough = 0.01;
/// Below, an explicit contact makes energy: 5 % of the speed at three steps, 1 % at five. One of restitution
/// e needs 2.5 / sqrt(e) if that is more: its bodies would part faster than they met.
inline constexpr double kFewestContactSteps = 5.0;
/// Above, too: k^2 times the stiffness of a pressed contact over its mass; 1 % of the speed for a cubic law
/// at five steps, 2 % for the tenth power at thirteen.
inline constexpr double kStiffestContact = 1.6;
/// A contact that would last less without loss is not resolved by frames: its restitution counts, its course
/// does not. [frames]
inline constexpr double kShortContact = 2.0;

/// How far the fastest oscillator or decay that loads a friction or a plectrum may go in a step for its stops
/// and slips to be found. [rad]
inline constexpr double kFastestLoad = 1.5;

/// So many times the multiplications of the cheapest are spent where it is not bounded and another one is.
inline constexpr double kBoundIsWorth = 4.0;

/// Steps a frame that are tried.
inline constexpr int kMostOversample = 64;

struct SolverChoice {
  Solver solver = Solver::Passive;
  int oversample = 1;
  std::vector<SolverBounds> candidates;  ///< by multiplications
};

/// [control] The cheapest solver that is stable and accurate; with `oversample` 0, the cheapest of up to 64
/// steps a frame too. If none is accurate, the most accurate of the stable ones. The bounds, for a step of k
/// seconds:
///  - resonances and dampers, ports and coils among them: `oscillator_error` of all oscillators up to the
///    stiffest spring and the strongest damper; exact 0. A port that stops its masses within a step sends its
///    wave up to a frame later: 1.
///  - the current of a coil by itself, with x = R k / L: |2 atanh(x / 2) / x - 1| up to x = 2, at most 2 / x;
///    exact 0;
///  - explicit is stable while k^2 times the largest eigenvalue of M^-1 (K + 2 C / k) is below 4, contacts
///    and bonds as deep as in `ContactDemand` among them (sufficient), these alone are below
///    `kStiffestContact`, and every contact lasts its `fewest_steps`;
///  - bonds: those of a spring of their largest stiffness, held over the step (exact too), and of several
///    axes those of their dampers, which are never weighted. A line that turns at w is as wrong as an
///    oscillator of w, and the spring that holds its ends on their circle has at least w;
///  - contacts, with s steps in the time of one of exponent a: exact (0.5 + 0.33 a) / s^2, explicit the same
///    but at least 1.4 / s^2, passive max(1, 0.12 a) / s^1.5, implicit (1.3 + 0.86 a) / s^2; with loss,
///    implicit 1.3 times as much and explicit 0.45 min(1, 2.8 (1 - e)) / s more. Their restitution e: 0
///    up to two steps; else 0.65 / s^2 (explicit 1 / s^2, or 1 below 5 / sqrt(e) steps), but 0.4 below
///    max(5, 1.6 / sqrt(e)) steps, and for e below 0.05 no less than 0.13 (passive, exact), or 0.1 below 20
///    steps (implicit). The largest of 40 phases, measured for a = 1 ... 10 and s = 3 ... 20, with loss for a
///    = 1 ... 3, e = 0.01 ... 0.8 and s = 0.03 ... 48;
///  - contacts shorter than `kShortContact`: passive two steps, implicit four, exact seven; nothing is said
///  of
///    one with loss that is pressed at the start;
///  - frictions and plectra, with x how far the fastest spring, damper, bond or contact of s steps (pi / s)
///  goes in a step:
///    forces x^2 / 8, each stop and slip two steps, and what a short contact may be late. A line between two
///    steps differs by x^2 / 8 from what swings. Nothing is said beyond `kFastestLoad`, or where a short
///    contact presses one.
/// Where nothing is said, the next cheapest of which something is known is chosen, as far as `kBoundIsWorth`.
/// How large the bound on a slip is does not count in the choice.
SolverChoice choose_solver(const NetworkElements& elements, Hertz rate, int oversample);

}  // namespace tactus
