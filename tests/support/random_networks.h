#pragma once

#include <cstdint>
#include <random>

#include "engine/core/units.h"
#include "engine/physics/elements.h"

namespace tactus::test {

/// A network, the rate it is stepped at, and how long.
struct RandomNetwork {
  NetworkElements elements;
  Hertz rate{48000};
  int frames = 0;
  bool driven = false;  ///< signal 0 is a sine of `drive_hz`; else it is silent
  double drive_hz = 0;
  int watched = 0;  ///< the point whose position is compared

  double signal(int frame) const;
  bool linear() const {
    return elements.contacts.empty() && elements.frictions.empty() && elements.bonds.empty();
  }
};

/// One network a seed, the same on every machine: 2 to 40 elements of all types, 8 to 192 kHz. Every second
/// one is of usual numbers (resonances of 10 Hz to a fifth of the rate, masses 1 g to 1 kg), the others of
/// masses up to 10^9 apart, springs to 10^12 N/m and dampers to 10^6 N s/m.
class RandomNetworks {
 public:
  explicit RandomNetworks(std::uint64_t seed) : bits_(seed) {}
  RandomNetwork make();

 private:
  double uniform() { return static_cast<double>(bits_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  double decades(double low, double high);
  bool chance(double of) { return uniform() < of; }
  int below(int count) { return static_cast<int>(uniform() * count); }

  void add_points();
  void add_element();
  void add_link(int lower, int upper);
  void add_contact(int lower, int upper);
  void add_friction(int lower, int upper);
  double fastest() const;

  std::mt19937_64 bits_;
  RandomNetwork made_;
  int masses_ = 0;
  bool extreme_ = false, smooth_ = false;
  double lightest_ = 0;
};

}  // namespace tactus::test
