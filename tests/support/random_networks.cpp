#include "tests/support/random_networks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/core/index.h"

namespace tactus::test {
namespace {

constexpr int kMostFrames = 200;
// Of the fastest motion in the time that is compared: what integration can follow. [rad]
constexpr double kMostRadians = 3e4;
constexpr double kSpeed_m_per_s = 1.0, kGap_m = 1e-3;

}  // namespace

double RandomNetwork::signal(int frame) const {
  return driven ? std::sin(2.0 * std::numbers::pi * drive_hz * frame / rate.value) : 0.0;
}

double RandomNetworks::decades(double low, double high) {
  return std::pow(10.0, uniform(std::log10(low), std::log10(high)));
}

RandomNetwork RandomNetworks::make() {
  made_ = {};
  extreme_ = chance(0.5), smooth_ = chance(0.4);
  const double rates[] = {8000, 16000, 22050, 44100, 48000, 96000, 192000};
  made_.rate = Hertz{rates[below(7)]};
  made_.driven = chance(0.5);
  made_.drive_hz = decades(20.0, 0.1 * made_.rate.value);
  add_points();
  const int elements = static_cast<int>(decades(2.0, 40.0));
  // All that moves is held by something.
  for (int i = 0; i < masses_; ++i) add_link(i > 0 && chance(0.7) ? below(i) : masses_, i);
  for (int i = static_cast<int>(made_.elements.points.size()) + masses_; i < elements; ++i) add_element();
  if (made_.driven) made_.elements.forces.push_back({below(masses_), {0, {}}});
  made_.watched = below(masses_);
  const double frames = made_.linear() ? kMostFrames : kMostRadians * made_.rate.value / fastest();
  made_.frames = static_cast<int>(std::clamp(frames, 8.0, double{kMostFrames}));
  return made_;
}

void RandomNetworks::add_points() {
  masses_ = static_cast<int>(decades(1.0, 15.0));
  const double middle = decades(1e-3, 1.0), spread = extreme_ ? uniform(0.0, 4.5) : 0.3;
  lightest_ = middle * std::pow(10.0, -spread);
  for (int i = 0; i < masses_; ++i)
    made_.elements.points.push_back({Point::Kind::Mass,
                                     middle * std::pow(10.0, uniform(-spread, spread)),
                                     uniform(-kGap_m, kGap_m),
                                     uniform(-kSpeed_m_per_s, kSpeed_m_per_s),
                                     {}});
  made_.elements.points.push_back({Point::Kind::Ground, 0.0, 0.0, 0.0, {}});
}

void RandomNetworks::add_element() {
  const int lower = below(masses_), other = below(masses_ + 1), upper = other == lower ? masses_ : other;
  const int kind = below(smooth_ ? 4 : 8);
  auto& elements = made_.elements;
  if (kind < 2) return add_link(lower, upper);
  if (kind == 2)
    elements.coils.push_back({lower,
                              upper,
                              decades(0.5, 20.0),
                              decades(1.0, 20.0),
                              chance(0.5) ? 0.0 : decades(extreme_ ? 1e-9 : 1e-4, 1e-1),
                              {}});
  else if (kind == 3)
    elements.ports.push_back({lower, decades(1e-2, extreme_ ? 1e5 : 10.0), {}});
  else if (kind == 4 || kind == 5)
    add_contact(lower, upper);
  else if (kind == 6)
    add_friction(lower, upper);
  else
    elements.bonds.push_back({lower, upper, std::make_shared<LinearBond>(decades(10.0, 1e5)),
                              chance(0.5) ? 0.0 : decades(1e-3, 1.0),
                              chance(0.5) ? decades(0.1, 10.0) : std::numeric_limits<double>::infinity()});
}

void RandomNetworks::add_link(int lower, int upper) {
  const auto& a = made_.elements.points[index(lower)];
  const auto& b = made_.elements.points[index(upper)];
  Spring spring{lower, upper, 0.0, 0.0, b.position - a.position + uniform(-kGap_m, kGap_m)};
  if (extreme_) {
    spring.stiffness = chance(0.1) ? 0.0 : decades(1.0, 1e12);
    spring.damping = chance(0.4) ? 0.0 : decades(1e-6, 1e6);
  } else {
    const auto light = [](const Point& p) { return p.kind == Point::Kind::Mass ? 1.0 / p.mass : 0.0; };
    const double mass = 1.0 / (light(a) + light(b)),
                 w = 2.0 * std::numbers::pi * decades(10.0, 0.2 * made_.rate.value);
    spring.stiffness = mass * w * w;
    spring.damping = chance(0.4) ? 0.0 : 2.0 * decades(1e-4, 1.5) * mass * w;
  }
  made_.elements.springs.push_back(spring);
}

void RandomNetworks::add_contact(int lower, int upper) {
  Contact contact{.lower = lower, .upper = upper, .restitution = {}};
  const double exponents[] = {1.0, 1.5, 2.0, 3.0, uniform(1.0, 4.0)};
  contact.exponent = exponents[below(5)];
  contact.stiffness = extreme_ ? decades(1.0, 1e12) : decades(1e3, 1e8);
  if (chance(0.3))
    contact.restitution = uniform(0.02, 0.98);
  else if (chance(0.6))
    contact.loss = decades(1e-2, 3.0);
  const auto& points = made_.elements.points;
  contact.offset = points[index(upper)].position - points[index(lower)].position - kGap_m * uniform();
  made_.elements.contacts.push_back(contact);
}

void RandomNetworks::add_friction(int lower, int upper) {
  Friction friction{.lower = lower, .upper = upper, .law = {}, .normal = {}};
  friction.law.kinetic = uniform(0.1, 0.8);
  if (chance(0.5)) friction.law.drops[0] = {uniform(0.1, 0.8), decades(0.01, 0.3)};
  if (chance(0.2)) friction.law = kRosin;
  friction.viscous = chance(0.5) ? 0.0 : decades(1e-4, 0.1);
  // Its force is that of a spring: it is what may be slid against all the time.
  friction.normal_spring = below(static_cast<int>(made_.elements.springs.size()));
  made_.elements.frictions.push_back(friction);
}

/// What all springs, dampers, and contacts at a depth of 1 mm make of the lightest mass. [rad/s]
double RandomNetworks::fastest() const {
  double fastest = 1.0;
  for (const auto& s : made_.elements.springs)
    fastest = std::max({fastest, std::sqrt(2.0 * s.stiffness / lightest_), 2.0 * s.damping / lightest_});
  for (const auto& c : made_.elements.contacts)
    fastest =
        std::max(fastest, std::sqrt(2.0 * c.stiffness * std::pow(kGap_m, c.exponent - 1.0) / lightest_));
  for (const auto& p : made_.elements.ports) fastest = std::max(fastest, p.impedance / lightest_);
  for (const auto& c : made_.elements.coils) {
    fastest = std::max(fastest, c.force_factor * c.force_factor / (c.resistance * lightest_));
    if (c.inductance > 0.0) fastest = std::max(fastest, c.resistance / c.inductance);
  }
  return fastest;
}

}  // namespace tactus::test
