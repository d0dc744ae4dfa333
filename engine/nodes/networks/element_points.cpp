#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "engine/nodes/networks/element_types.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

void build_mass(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.point =
      b.append(b.elements.points,
               Point{Point::Kind::Mass, b.number(e, "mass"), b.number(e, "at"), b.number(e, "velocity"), {}});
}

void build_oscillator(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  const double mass = b.number(e, "mass");
  const double turn = 2.0 * std::numbers::pi * b.number(e, "frequency");
  const double stiffness = b.has(e, "frequency") ? mass * turn * turn : b.number(e, "stiffness");
  const double damping = b.has(e, "damping_ratio")
                             ? 2.0 * b.number(e, "damping_ratio") * std::sqrt(mass * stiffness)
                             : b.number(e, "damping");
  build_mass(b, e, parts);
  parts.spring = b.append(b.elements.springs,
                          Spring{b.add_ground(b.number(e, "rest")), parts.point, stiffness, damping, 0.0});
}

void build_ground(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.point = b.add_ground(b.number(e, "at"));
}

void build_motion(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.point =
      b.append(b.elements.points, Point{Point::Kind::Motion, 0.0, 0.0, 0.0, b.signal(e, "position")});
}

/// Springs whose energy together is that of stencils, (stiffness / 2) (sum of weight_i x_i)^2 each: the entry
/// K_ij of their matrix is a spring of -K_ij between i and j, which may be below 0.
class StencilSprings {
 public:
  struct Term {
    int point;
    double weight;
  };
  void add(double stiffness, const std::vector<Term>& stencil) {
    for (const auto& [row, a] : stencil)
      for (const auto& [column, b] : stencil) {
        if (row < column) between_[{row, column}] -= stiffness * a * b;
        ground_[row] += stiffness * a * b;
      }
  }
  void append_to(std::vector<Spring>& springs, int floor) const {
    constexpr double kRounding = 1e-12;
    double largest = 0.0;
    for (const auto& [ends, k] : between_) largest = std::max(largest, std::abs(k));
    for (const auto& [point, k] : ground_) largest = std::max(largest, std::abs(k));
    for (const auto& [ends, k] : between_)
      if (std::abs(k) > kRounding * largest) springs.push_back({ends.first, ends.second, k, 0.0, 0.0});
    for (const auto& [point, k] : ground_)
      if (std::abs(k) > kRounding * largest) springs.push_back({floor, point, k, 0.0, 0.0});
  }

 private:
  std::map<std::pair<int, int>, double> between_;
  std::map<int, double> ground_;
};

/// The bending energy of a bar or of a plate, h = distance of the masses,
///   (B / 2) sum of (u_xx + u_yy)^2 - 2 (1 - nu) (u_xx u_yy - u_xy^2),   B = D / h^2 (bar: E I / h^3),
/// u_xx = u_i-1 - 2 u_i + u_i+1 and u_xy in the middle of four masses. At a fixed border, which is one h
/// beyond, u and u_xx are 0 (simply supported), and nu drops out; at a clamped one u and u_x are 0; at a free
/// one nothing pushes: u_yy = -nu u_xx, (1 - nu^2) u_xx^2 is left of the energy. Timoshenko &
/// Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959.
void add_bending(NetworkBuilder& b, const NetworkElement& e, int first, int floor, bool closed) {
  const double stiffness = b.number(e, "bending_stiffness");
  if (stiffness == 0.0) return;
  const int rows = e.rows(), columns = e.columns();
  const bool grid = e.type->dimensions > 1, free = e.chosen("ends", "free");
  const double nu = !grid || !free ? 0.0 : b.has(e, "poisson_ratio") ? b.number(e, "poisson_ratio") : 0.3;
  StencilSprings springs;
  using Stencil = std::vector<StencilSprings::Term>;
  const auto point = [&](int row, int column) { return first + row * columns + column; };
  const auto inside = [](int at, int count) { return at >= 0 && at < count; };
  // u_xx or u_yy; empty at a free border.
  const auto curvature = [&](int row, int column, int down, int right) {
    Stencil terms{{point(row, column), -2.0}};
    for (const int side : {-1, 1}) {
      int r = row + side * down, c = column + side * right;
      if (closed) c = (c + columns) % columns;
      if (inside(r, rows) && inside(c, columns))
        terms.push_back({point(r, c), 1.0});
      else if (free)
        return Stencil{};
    }
    return terms;
  };
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const auto x = curvature(row, column, 0, 1);
      const auto y = grid ? curvature(row, column, 1, 0) : Stencil{};
      auto both = x;
      both.insert(both.end(), y.begin(), y.end());
      if (!grid || !free) {
        springs.add(stiffness, both);
      } else if (!x.empty() && !y.empty()) {
        springs.add(stiffness * nu, both);
        springs.add(stiffness * (1.0 - nu), x), springs.add(stiffness * (1.0 - nu), y);
      } else {
        springs.add(stiffness * (1.0 - nu * nu), both);
      }
      if (grid && free && row + 1 < rows && column + 1 < columns)
        springs.add(stiffness * 2.0 * (1.0 - nu), {{point(row, column), 1.0},
                                                   {point(row + 1, column + 1), 1.0},
                                                   {point(row + 1, column), -1.0},
                                                   {point(row, column + 1), -1.0}});
      // The mass next to a clamped border has its mirror image behind it: half a stencil of 2 u.
      const int border =
          (column == 0) + (column + 1 == columns) + (grid ? (row == 0) + (row + 1 == rows) : 0);
      if (e.chosen("ends", "clamped")) springs.add(border * 2.0 * stiffness, {{point(row, column), 1.0}});
    }
  springs.append_to(b.elements.springs, floor);
}

/// Masses row by row, springs to the right and up, and to the ground.
void build_lattice(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  const int rows = e.rows(), columns = e.columns();
  const bool grid = e.type->dimensions > 1;
  const bool fixed = e.chosen("ends", "fixed") || e.chosen("ends", "clamped");
  const double stiffness = b.number(e, "stiffness"), damping = b.number(e, "damping");
  const double own = b.number(e, "ground_stiffness"), own_damping = b.number(e, "ground_damping");
  const double at = b.number(e, "at"), mass = b.number(e, "mass");
  auto& springs = b.elements.springs;
  parts.point = static_cast<int>(b.elements.points.size());
  for (int i = 0; i < rows * columns; ++i)
    b.elements.points.push_back({Point::Kind::Mass, mass, at, 0.0, {}});
  const int floor = b.add_ground(at);
  const auto join = [&](int one, int other) {
    if (stiffness != 0.0 || damping != 0.0 || !b.has(e, "bending_stiffness"))
      springs.push_back({one, other, stiffness, damping, 0.0});
  };
  const auto hold = [&](int point, int sides) {
    const double k = sides * stiffness + own, z = sides * damping + own_damping;
    if (k != 0.0 || z != 0.0) springs.push_back({floor, point, k, z, 0.0});
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int here = parts.point + row * columns + column;
      if (column + 1 < columns) join(here, here + 1);
      if (row + 1 < rows) join(here, here + columns);
      const int border =
          (column == 0) + (column + 1 == columns) + (grid ? (row == 0) + (row + 1 == rows) : 0);
      hold(here, fixed ? border : 0);
    }
  }
}

void build_chain(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  build_lattice(b, e, parts);
  add_bending(b, e, parts.point, static_cast<int>(b.elements.points.size()) - 1, false);
}

/// A chain whose ends are joined.
void build_ring(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  build_lattice(b, e, parts);
  add_bending(b, e, parts.point, static_cast<int>(b.elements.points.size()) - 1, true);
  const int last = parts.point + e.columns() - 1;
  if (e.columns() > 2)
    b.elements.springs.push_back({last, parts.point, b.number(e, "stiffness"), b.number(e, "damping"), 0.0});
}

/// What each mass of a chain, a ring or a grid is, and what joins it to its neighbours and to the ground.
std::vector<ElementField> repeated_fields() {
  return {required("mass", "kg", "mass of each point", kTiny),
          required("stiffness", "N/m", "stiffness between neighbours", 0.0),
          if_named("bending_stiffness", "N/m",
                   "bending stiffness, h being the distance of the masses: E I / h^3 of a bar, D / h^2 of a "
                   "plate",
                   0.0),
          with_default("damping", "N s/m", "damping between neighbours", 0.0, 0.0),
          with_default("ground_stiffness", "N/m", "stiffness from each mass to its rest position", 0.0, 0.0),
          with_default("ground_damping", "N s/m", "damping from each mass to its rest position", 0.0, 0.0),
          with_default("at", "m", "rest position of all masses", 0.0)};
}

std::vector<ElementField> plate_fields() {
  auto fields = repeated_fields();
  fields.push_back(
      if_named("poisson_ratio", "", "Poisson's ratio of a plate with free ends; default: 0.3", 0.0, 0.5));
  return fields;
}

std::vector<ElementType> single_points() {
  return {
      {.name = "mass",
       .doc = "A body that moves along the network's axis.",
       .equation = "mass x'' = sum of the forces on it",
       .ends = Ends::None,
       .fields = {required("mass", "kg", "moved mass", kTiny),
                  with_default("at", "m", "initial position", 0.0),
                  with_default("velocity", "m/s", "initial velocity", 0.0)},
       .quantities = {kPosition, kVelocity},
       .example = "stick = { type = \"mass\", mass = \"12.5 g\", at = \"20 mm\" }",
       .build = build_mass},
      {.name = "oscillator",
       .doc = "A mass on a spring and a damper, given by stiffness and damping or by resonance and damping "
              "ratio.",
       .equation =
           "mass x'' = -stiffness (x - rest) - damping x' + sum of the forces on it,  stiffness = mass "
           "(2 pi frequency)^2,  damping = 2 damping_ratio sqrt(mass stiffness)",
       .ends = Ends::None,
       .fields = {required("mass", "kg", "moved mass", kTiny),
                  if_named("stiffness", "N/m", "stiffness of its spring", 0.0),
                  if_named("frequency", "Hz", "undamped resonance frequency, instead of `stiffness`", 1e-3,
                           1e6, "stiffness", true),
                  if_named("damping", "N s/m", "damping of its damper", 0.0),
                  if_named("damping_ratio", "", "damping ratio, instead of `damping`; 1: critical", 0.0,
                           kLargestField, "damping"),
                  with_default("rest", "m", "rest position of its spring", 0.0),
                  with_default("at", "m", "initial position", 0.0),
                  with_default("velocity", "m/s", "initial velocity", 0.0)},
       .quantities = {kPosition,
                      kVelocity,
                      {"force", "N", "force of its spring and damper, towards `rest`", read_tension()}},
       .example =
           "bar = { type = \"oscillator\", mass = \"20 g\", frequency = \"440 Hz\", damping_ratio = 0.001 }",
       .build = build_oscillator},
      {.name = "ground",
       .doc = "A fixed point.",
       .equation = "x = at",
       .ends = Ends::None,
       .fields = {with_default("at", "m", "position", 0.0)},
       .example = "frame = { type = \"ground\" }",
       .build = build_ground,
       .takes_force = false},
      {.name = "motion",
       .doc = "A point whose position follows a signal, one frame later and linearly within each frame.",
       .equation = "x[n + 1] = position[n]",
       .ends = Ends::None,
       .fields = {signal("position", "m", "prescribed position")},
       .quantities = {kPosition, kVelocity},
       .example = "table = { type = \"motion\", position = \"shake\" }",
       .build = build_motion,
       .takes_force = false},
  };
}

std::vector<ElementType> many_points() {
  return {
      {.name = "chain",
       .doc = "A row of masses connected by springs; `name.1` is the first.",
       .equation = "mass x_i'' = stiffness (x_{i+1} - 2 x_i + x_{i-1}) + damping (x_{i+1} - 2 x_i + "
                   "x_{i-1})' - bending_stiffness (x_{i+2} - 4 x_{i+1} + 6 x_i - 4 x_{i-1} + x_{i-2}) - "
                   "ground_stiffness (x_i - at) - ground_damping x_i'",
       .ends = Ends::None,
       .settings = {whole("masses", "number of masses", 1, kMostMasses),
                    choice("ends",
                           "whether springs also fix the first and the last mass; clamped: nor can it turn "
                           "there",
                           {"fixed", "free", "clamped"}, "fixed")},
       .fields = repeated_fields(),
       .example = "string = { type = \"chain\", masses = 100, mass = \"0.1 g\", stiffness = \"57 kN/m\" }",
       .build = build_chain,
       .dimensions = 1},
      {.name = "ring",
       .doc = "Masses in a ring: a chain whose last mass is connected to the first.",
       .equation = "as a chain, x_0 = x_n",
       .ends = Ends::None,
       .settings = {whole("masses", "number of masses", 1, kMostMasses)},
       .fields = repeated_fields(),
       .example = "hoop = { type = \"ring\", masses = 64, mass = \"1 g\", stiffness = \"10 kN/m\" }",
       .build = build_ring,
       .dimensions = 1},
      {.name = "grid",
       .doc = "Masses on a square grid, each connected to its four neighbours; `name.1.1` is a corner, "
              "`name.2.1` is in the second row.",
       .equation = "mass x_rc'' = stiffness L x - bending_stiffness L L x + …, as a chain,  L x = x_{r+1,c} "
                   "+ x_{r-1,c} + "
                   "x_{r,c+1} + x_{r,c-1} - 4 x_rc",
       .ends = Ends::None,
       .settings = {whole("rows", "number of rows", 1, 1'000),
                    whole("columns", "number of columns", 1, 1'000),
                    choice("ends", "whether springs also fix the border; clamped: nor can it turn there",
                           {"fixed", "free", "clamped"}, "fixed")},
       .fields = plate_fields(),
       .example = "membrane = { type = \"grid\", rows = 20, columns = 20, mass = \"0.1 g\", stiffness = \"20 "
                  "kN/m\" }",
       .build = build_chain,
       .dimensions = 2},
  };
}

}  // namespace

std::vector<ElementType> point_elements() {
  auto all = single_points();
  for (auto& type : many_points()) all.push_back(std::move(type));
  return all;
}

}  // namespace tactus
