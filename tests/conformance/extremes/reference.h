#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

// What nodes give by their equations in the reference, written out frame by frame in long double and without
// the engine.

namespace tactus::test {

using Series = std::vector<long double>;

/// The inputs of a node over some frames, within their declared ranges.
struct Given {
  long double rate = 0;
  std::map<std::string, Series> in = {};
  std::map<std::string, std::string> settings = {};
  std::vector<double> numbers = {};  ///< of the settings that are lists

  long double at(const std::string& port, std::size_t frame) const { return in.at(port)[frame]; }
};

/// The first output; a NaN where the equation determines nothing in double precision.
struct Expected {
  Series out;
  long double tolerance = 1e-9L;  ///< as a share of the largest value
  long double rounding = 0;       ///< of what cancels
};

/// nullopt: the type has no equation here.
std::optional<Expected> expected_output(const std::string& type, const Given& given, std::size_t frames);

}  // namespace tactus::test
