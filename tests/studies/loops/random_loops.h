#pragma once

// Thread: [any].

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/studies/loops/circuit.h"

namespace tactus::study {

/// A loop as files: an instrument alone, or a scene with an instrument "i.toml" and a plant "p.toml".
struct LoopFiles {
  std::map<std::string, std::string> files;  ///< by name; "scene.toml" if there is a scene, "i.toml" always
  double rate = 48000, delay_s = 0;
  double device_mass = 0.05, device_damping = 0.1;
};

/// What is true of a loop, by its own equations.
struct LoopTruth {
  double growth = 0;  ///< per second, of the fastest; below 0 it decays
  bool grows() const { return growth > 1e-4; }
};

/// A closed loop at one gain.
struct RandomLoop {
  std::string kind;
  LoopFiles loop;
  LoopTruth truth;
  double of_border = 1;  ///< its gain, relative to the border
  /// At rest, to compare with what the engine plays: its response to a push of input 0; empty: not compared.
  std::vector<double> response = {};
};

/// The kinds, in the order in which numbers go through them.
const std::vector<std::string>& loop_kinds();

/// The loop of a number, which alone it depends on. Every second one lies at 0.99 ... 1.01 of its border.
RandomLoop random_loop(long number);

}  // namespace tactus::study
