#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/dimension.h"
#include "engine/nodes/table.h"

// Graph files around one node or one element of a network, made from its declaration, with a place for every
// number that it takes.

namespace tactus::test {

/// What a number counts in: a dimension, and a power of the level of the node's signals ("any", "=in").
struct Counted {
  Dimension dimension{};
  double level = 0;

  bool plain() const { return dimension.plain() && level == 0; }
};

/// Other units: by how much numbers grow that count in each. Powers of two, so that nothing is rounded.
struct Units {
  double metre = 1, kilogram = 1, second = 1, ampere = 1, level = 1;

  double factor(const Counted& counted) const;
};

/// A number of a file.
struct Slot {
  std::string name;  ///< "time", "points 3"
  Counted counted;
  Interval declared{};
  double value = 0;           ///< in the middle of what is usual
  Interval usual{};           ///< of a signal
  bool moves = false;         ///< a signal unless it is the number under test
  bool fixed = false;         ///< takes no signal
  bool whole = false;         ///< a whole number
  std::string key{};          ///< of the line; empty: a place "@n@" in it
  bool written = true;        ///< false: left out unless it is the number under test
  std::string instead_of{};   ///< the key that it excludes
  std::string quoted_unit{};  ///< must be text with this unit
  int exponent = -1;  ///< counts in newtons per metre to the power of this slot's number; -1: in `counted`
};

/// A line `name = { start, keys … }` of a file, with the slots that it takes.
struct Line {
  std::string start;  ///< "tested = { type = \"delay\""
  std::vector<int> slots;
};

/// An output of the graph: everything that the node or the element can be asked for.
struct Shown {
  std::string name, expression;
  Counted counted;
};

struct ExtremeSubject {
  std::string family;  ///< "filters", "element"
  std::string type;    ///< "delay"
  std::string name{};  ///< "delay interpolation=none"
  std::map<std::string, std::string> settings{};
  std::vector<Slot> slots{};
  std::string head{};  ///< of the file, before the lines
  std::vector<Line> lines{};
  std::vector<Shown> shown{};
  bool assumes_speed = false;  ///< how it is solved depends on a speed in m/s (`auto`: of the hardest strike)
  std::filesystem::path file = "extremes.toml";

  /// `numbers[i]`: how slot i is written; empty: left out.
  std::string text(const std::vector<std::string>& numbers) const;
};

/// Every type of node with every variant of its settings.
std::vector<ExtremeSubject> node_subjects();
/// Every type of element with every solver but `explicit`, which stiff parts make unstable by definition.
std::vector<ExtremeSubject> element_subjects();

}  // namespace tactus::test
