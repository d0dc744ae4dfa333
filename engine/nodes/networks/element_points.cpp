#include <utility>

#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Kind = ElementQuantity::Kind;
using Ends = ElementType::Ends;

Setting count(const char* name, const char* doc, double most) {
  return {.name = name,
          .kind = Setting::Kind::Integer,
          .doc = doc,
          .choices = {},
          .fallback = "",
          .low = 1,
          .high = most};
}

Setting ends(const char* doc) {
  return {.name = "ends",
          .kind = Setting::Kind::Choice,
          .doc = doc,
          .choices = {"fixed", "free"},
          .fallback = "fixed"};
}

/// What each mass of a chain, a ring or a grid is, and what joins it to its neighbours and to the ground.
std::vector<ElementField> repeated_fields() {
  return {required("mass", "kg", "of each", kTiny),
          required("stiffness", "N/m", "between neighbours", 0.0),
          with_default("damping", "N s/m", "between neighbours", 0.0, 0.0),
          with_default("ground_stiffness", "N/m", "from each to its place", 0.0, 0.0),
          with_default("ground_damping", "N s/m", "from each to its place", 0.0, 0.0),
          with_default("at", "m", "position of all", 0.0)};
}

std::vector<ElementType> single_points() {
  return {
      {.name = "mass",
       .doc = "A body that moves along the network's axis.",
       .equation = "mass x'' = sum of the forces on it",
       .ends = Ends::None,
       .settings = {},
       .fields = {required("mass", "kg", "moved mass", kTiny),
                  with_default("at", "m", "position at the start", 0.0),
                  with_default("velocity", "m/s", "velocity at the start", 0.0)},
       .quantities = {kPosition, kVelocity},
       .example = "stick = { type = \"mass\", mass = \"12.5 g\", at = \"20 mm\" }"},
      {.name = "oscillator",
       .doc = "A mass on a spring and a damper, by stiffness or by resonance and damping ratio.",
       .equation =
           "mass x'' = -stiffness (x - rest) - damping x' + sum of the forces on it,  stiffness = mass "
           "(2 pi frequency)^2,  damping = 2 damping_ratio sqrt(mass stiffness)",
       .ends = Ends::None,
       .settings = {},
       .fields = {required("mass", "kg", "moved mass", kTiny),
                  if_named("stiffness", "N/m", "of its spring", 0.0),
                  if_named("frequency", "Hz", "undamped resonance, instead of `stiffness`", 1e-3, 1e6),
                  if_named("damping", "N s/m", "of its damper", 0.0),
                  if_named("damping_ratio", "", "1: critical; instead of `damping`", 0.0),
                  with_default("rest", "m", "where its spring pulls to", 0.0),
                  with_default("at", "m", "position at the start", 0.0),
                  with_default("velocity", "m/s", "velocity at the start", 0.0)},
       .quantities = {kPosition,
                      kVelocity,
                      {"force", "N", "of its spring and damper, towards `rest`", Kind::SpringForce}},
       .example =
           "bar = { type = \"oscillator\", mass = \"20 g\", frequency = \"440 Hz\", damping_ratio = 0.001 }"},
      {.name = "ground",
       .doc = "A fixed point.",
       .equation = "x = at",
       .ends = Ends::None,
       .settings = {},
       .fields = {with_default("at", "m", "position", 0.0)},
       .quantities = {},
       .example = "frame = { type = \"ground\" }"},
      {.name = "motion",
       .doc =
           "A point that goes where a signal says, in a straight line from frame to frame, one frame later.",
       .equation = "x[n + 1] = position[n]",
       .ends = Ends::None,
       .settings = {},
       .fields = {signal("position", "m", "where it goes")},
       .quantities = {kPosition, kVelocity},
       .example = "table = { type = \"motion\", position = \"shake\" }"},
  };
}

std::vector<ElementType> many_points() {
  return {
      {.name = "chain",
       .doc = "Masses in a row, joined by springs: `name.1` is the first.",
       .equation = "mass x_i'' = stiffness (x_{i+1} - 2 x_i + x_{i-1}) + damping (x_{i+1} - 2 x_i + "
                   "x_{i-1})' - ground_stiffness (x_i - at) - ground_damping x_i'",
       .ends = Ends::None,
       .settings = {count("masses", "how many", 1'000'000),
                    ends("whether springs hold the first and the last one, too")},
       .fields = repeated_fields(),
       .quantities = {},
       .example = "string = { type = \"chain\", masses = 100, mass = \"0.1 g\", stiffness = \"57 kN/m\" }",
       .many = true},
      {.name = "ring",
       .doc = "Masses in a ring: a chain whose last mass is the neighbour of the first.",
       .equation = "as a chain, x_0 = x_n",
       .ends = Ends::None,
       .settings = {count("masses", "how many", 1'000'000)},
       .fields = repeated_fields(),
       .quantities = {},
       .example = "hoop = { type = \"ring\", masses = 64, mass = \"1 g\", stiffness = \"10 kN/m\" }",
       .many = true},
      {.name = "grid",
       .doc = "Masses on a square grid, each joined to its four neighbours: `name.1.1` is a corner, "
              "`name.2.1` is in the second row.",
       .equation =
           "mass x_rc'' = stiffness (x_{r+1,c} + x_{r-1,c} + x_{r,c+1} + x_{r,c-1} - 4 x_rc) + …, as a chain",
       .ends = Ends::None,
       .settings = {count("rows", "how many rows", 1'000), count("columns", "how many columns", 1'000),
                    ends("whether springs hold the border, too")},
       .fields = repeated_fields(),
       .quantities = {},
       .example = "membrane = { type = \"grid\", rows = 20, columns = 20, mass = \"0.1 g\", stiffness = \"20 "
                  "kN/m\" }",
       .many = true},
  };
}

}  // namespace

std::vector<ElementType> point_elements() {
  auto all = single_points();
  for (auto& type : many_points()) all.push_back(std::move(type));
  return all;
}

}  // namespace tactus
