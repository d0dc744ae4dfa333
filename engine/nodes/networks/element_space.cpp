#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "engine/nodes/networks/element_types.h"
#include "engine/physics/linearised.h"

// Elements that move in two or three axes. Each axis of a mass is a point of its own, so that every other
// element acts on it by its name, "bob.x".
namespace tactus {
namespace {

using Ends = ElementType::Ends;

constexpr std::array kPlaceFields = {"x", "y", "z"};

void build_particle(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  constexpr std::array kVelocities = {"velocity_x", "velocity_y", "velocity_z"};
  parts.point = static_cast<int>(b.elements.points.size());
  for (int a = 0; a < e.axes(); ++a)
    b.elements.points.push_back({Point::Kind::Mass,
                                 b.number(e, "mass"),
                                 b.number(e, kPlaceFields[index(a)]),
                                 b.number(e, kVelocities[index(a)]),
                                 {}});
}

void build_anchor(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.point = static_cast<int>(b.elements.points.size());
  for (int a = 0; a < e.axes(); ++a) b.add_ground(b.number(e, kPlaceFields[index(a)]));
}

void build_trajectory(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  parts.point = static_cast<int>(b.elements.points.size());
  for (int a = 0; a < e.axes(); ++a)
    b.elements.points.push_back({Point::Kind::Motion, 0.0, 0.0, 0.0, b.signal(e, kPlaceFields[index(a)])});
}

std::vector<double> places_of(const NetworkBuilder& b) {
  std::vector<double> places;
  for (const auto& point : b.elements.points) places.push_back(point.position);
  return places;
}

/// A spring along the line between two bodies, or what is left of it for small displacements.
struct Line {
  bool linear;
  double stiffness, damping;
};
Bond bond_of(const Line& line, int lower, int upper, int axes) {
  return {.lower = lower,
          .upper = upper,
          .law = std::make_shared<LinearBond>(line.stiffness),
          .damping = line.damping,
          .axes = axes};
}
void append_springs(NetworkBuilder& b, const Bond& bond, const std::vector<double>& places) {
  for (const auto& spring : line_springs(bond, places)) b.elements.springs.push_back(spring);
}

void build_line_spring(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  const Line line{e.chosen("geometry", "linear"), b.number(e, "stiffness"), b.number(e, "damping")};
  const auto places = places_of(b);
  auto bond = bond_of(line, b.end(e, 0), b.end(e, 1), b.axes_at(e, 0));
  bond.rest = b.has(e, "rest") ? b.number(e, "rest")
                               : length(apart(places, bond)) - b.number(e, "tension") / line.stiffness;
  if (!line.linear) {
    parts.bond = b.append(b.elements.bonds, bond);
  } else {
    parts.spring = static_cast<int>(b.elements.springs.size());
    append_springs(b, bond, places);
  }
}

/// Bodies at their places at rest, row by row, and what joins them. Where the border is fixed, anchors lie
/// one spacing beyond it.
class Fabric {
 public:
  Fabric(NetworkBuilder& b, const NetworkElement& e) : b_(b), e_(e), axes_(e.axes()) {
    for (int a = 0; a < 3; ++a)
      if (e.chosen("along", std::string(1, kAxisNames[index(a)]))) along_ = a;
  }

  void build(ElementParts& parts) {
    const int rows = e_.rows(), columns = e_.columns();
    parts.point = static_cast<int>(b_.elements.points.size());
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) add_body(Point::Kind::Mass, row, column);
    const bool grid = e_.type->dimensions > 1;
    if (!e_.chosen("ends", "free")) {
      for (int row = 0; row < rows; ++row)
        for (const int column : {-1, columns}) add_anchor(row, column);
      for (int column = 0; grid && column < columns; ++column)
        for (const int row : {-1, rows}) add_anchor(row, column);
    }
    const double stiffness = b_.number(e_, "stiffness"), tension = b_.number(e_, "tension");
    places_ = places_of(b_);
    for (int row = -1; row <= rows; ++row)
      for (int column = -1; column <= columns; ++column) {
        join(row, column, row, column + 1, stiffness, tension);
        if (!grid) continue;
        join(row, column, row + 1, column, stiffness, tension);
        if (const double shear = b_.number(e_, "shear_stiffness"); shear > 0.0) {
          join(row, column, row + 1, column + 1, shear, 0.0);
          join(row, column + 1, row + 1, column, shear, 0.0);
        }
      }
    hold(parts.point, rows * columns * axes_);
  }

 private:
  double place(int axis, int row, int column) const {
    const double step = axis == along_ ? column : axis == (along_ + 1) % axes_ ? row : 0;
    return b_.number(e_, kPlaceFields[index(axis)]) + step * b_.number(e_, "spacing");
  }
  int add_body(Point::Kind kind, int row, int column) {
    const int first = static_cast<int>(b_.elements.points.size());
    for (int a = 0; a < axes_; ++a)
      b_.elements.points.push_back({kind, b_.number(e_, "mass"), place(a, row, column), 0.0, {}});
    at_[{row, column}] = first;
    return first;
  }
  void add_anchor(int row, int column) { add_body(Point::Kind::Ground, row, column); }

  bool is_mass(int body) const { return b_.elements.points[index(body)].kind == Point::Kind::Mass; }

  void join(int row, int column, int other_row, int other_column, double stiffness, double tension) {
    const auto one = at_.find({row, column}), other = at_.find({other_row, other_column});
    if (one == at_.end() || other == at_.end() || (!is_mass(one->second) && !is_mass(other->second))) return;
    const Line line{e_.chosen("geometry", "linear"), stiffness, b_.number(e_, "damping")};
    auto bond = bond_of(line, one->second, other->second, axes_);
    bond.rest = length(apart(places_, bond)) - tension / stiffness;
    if (line.linear)
      append_springs(b_, bond, places_);
    else
      b_.elements.bonds.push_back(bond);
  }

  void hold(int first, int points) {
    const double damping = b_.number(e_, "ground_damping");
    if (damping == 0.0) return;
    const int floor = b_.add_ground(0.0);
    for (int p = first; p < first + points; ++p) b_.elements.springs.push_back({floor, p, 0.0, damping, 0.0});
  }

  NetworkBuilder& b_;
  const NetworkElement& e_;
  int axes_, along_ = 0;
  std::map<std::pair<int, int>, int> at_;  ///< the first point of each body, by row and column
  std::vector<double> places_;
};

void build_fabric(NetworkBuilder& b, const NetworkElement& e, ElementParts& parts) {
  Fabric{b, e}.build(parts);
}

template <int kAxis>
ReadElement position_along() {
  return read_part<&Network::position, &ElementParts::point, kAxis>();
}
template <int kAxis>
ReadElement velocity_along() {
  return read_part<&Network::velocity, &ElementParts::point, kAxis>();
}

Setting axes_setting() { return whole("axes", "2: x and y; 3: x, y and z", 2, 3, "3"); }
Setting geometry_setting() {
  return choice("geometry",
                "nonlinear: the force acts along the line between the ends, wherever they are; linear: for "
                "small displacements",
                {"nonlinear", "linear"}, "nonlinear");
}
ElementField third(ElementField field) {
  field.axis = 2;
  return field;
}
/// A number for each axis: x, y, z.
std::vector<ElementField> places(const std::string& doc) {
  return {with_default("x", "m", doc, 0.0), with_default("y", "m", doc, 0.0),
          third(with_default("z", "m", doc, 0.0))};
}
std::vector<ElementQuantity> place_quantities() {
  return {{"x", "m", "position", position_along<0>()},
          {"y", "m", "position", position_along<1>()},
          {"z", "m", "position", position_along<2>(), {}, 2},
          {"velocity_x", "m/s", "second order, from the last three steps", velocity_along<0>()},
          {"velocity_y", "m/s", "second order, from the last three steps", velocity_along<1>()},
          {"velocity_z", "m/s", "second order, from the last three steps", velocity_along<2>(), {}, 2}};
}

ElementType particle() {
  auto fields = places("initial position");
  fields.insert(fields.begin(), required("mass", "kg", "moved mass", kTiny));
  fields.push_back(with_default("velocity_x", "m/s", "initial velocity", 0.0));
  fields.push_back(with_default("velocity_y", "m/s", "initial velocity", 0.0));
  fields.push_back(third(with_default("velocity_z", "m/s", "initial velocity", 0.0)));
  return {.name = "particle",
          .doc =
              "A body that moves in two or three axes. Elements along one axis act on `name.x`, `name.y` "
              "or `name.z` as on a mass; a `line_spring` on the body itself.",
          .equation = "mass (x'', y'', z'') = sum of the forces on it",
          .ends = Ends::None,
          .settings = {axes_setting()},
          .fields = fields,
          .quantities = place_quantities(),
          .example = "bob = { type = \"particle\", axes = 2, mass = \"0.1 kg\", x = \"0.3 m\" }",
          .build = build_particle,
          .in_space = true};
}

ElementType anchor() {
  return {.name = "anchor",
          .doc = "A fixed point in space.",
          .equation = "position = (x, y, z)",
          .ends = Ends::None,
          .settings = {axes_setting()},
          .fields = places("position"),
          .example = "hook = { type = \"anchor\", axes = 2, y = \"0.5 m\" }",
          .build = build_anchor,
          .in_space = true,
          .takes_force = false};
}

ElementType trajectory() {
  return {.name = "trajectory",
          .doc =
              "A point in space whose position follows a signal for each axis, one frame later and "
              "linearly within each frame.",
          .equation = "position = (x, y, z)",
          .ends = Ends::None,
          .settings = {axes_setting()},
          .fields = {signal("x", "m", "position", 0.0), signal("y", "m", "position", 0.0),
                     third(signal("z", "m", "position", 0.0))},
          .quantities = place_quantities(),
          .example = "finger = { type = \"trajectory\", axes = 2, x = \"shake\" }",
          .build = build_trajectory,
          .in_space = true,
          .takes_force = false};
}

ElementType line_spring() {
  return {
      .name = "line_spring",
      .doc = "A spring and a damper in parallel along the line between two bodies in space.",
      .equation = "force = stiffness e + damping e',  e = |r_second - r_first| - rest, along that line",
      .ends = Ends::Between,
      .settings = {geometry_setting()},
      .fields = {required("stiffness", "N/m", "stiffness (force per change of the length)", kTiny),
                 with_default("damping", "N s/m", "damping coefficient", 0.0, 0.0),
                 if_named("rest", "m", "length at zero force; default: the length at the start", 0.0),
                 if_named("tension", "N", "force at the start, instead of `rest`", -kLargestField,
                          kLargestField, "rest")},
      .quantities = {{"force", "N", "force, positive if it pulls the ends together",
                      read_sum<PartRead<&Network::bond_force, &ElementParts::bond>,
                               PartRead<&Network::spring_force, &ElementParts::spring>>()},
                     {"extension", "m", "length - rest",
                      read_sum<PartRead<&Network::bond_distance, &ElementParts::bond>,
                               PartRead<&Network::extension, &ElementParts::spring>>()}},
      .example = "cord = { type = \"line_spring\", between = [\"hook\", \"bob\"], stiffness = \"2 kN/m\" }",
      .build = build_line_spring,
      .in_space = true,
      .linear = false};
}

// Beyond 1e20 steps end in faults. Steel wire of 1 mm has 2e8 N/m for each millimetre.
constexpr double kStiffestFabric = 1e15;

std::vector<ElementField> fabric_fields() {
  std::vector<ElementField> fields = {
      required("mass", "kg", "mass of each body", kTiny),
      required("stiffness", "N/m", "stiffness of each spring along its line", kTiny, kStiffestFabric),
      required("spacing", "m", "distance of neighbours at rest", kTiny),
      with_default("tension", "N", "force of each spring at rest", 0.0),
      with_default("damping", "N s/m", "damping of each spring along its line", 0.0, 0.0, kStiffestFabric),
      with_default("ground_damping", "N s/m", "damping of each body in every axis", 0.0, 0.0)};
  for (auto& place : places("rest position of the first body")) fields.push_back(place);
  return fields;
}

ElementType thread() {
  return {.name = "thread",
          .doc =
              "A row of bodies in space, joined by springs along the lines between them; `name.3.y` is "
              "the third body's y. Fixed ends are one spacing beyond the first and the last body.",
          .equation =
              "mass r_i'' = F_i - F_{i-1},  F_i = stiffness (|r_{i+1} - r_i| - rest) along that line, "
              " rest = spacing - tension / stiffness",
          .ends = Ends::None,
          .settings = {whole("masses", "number of bodies", 1, kMostMasses), axes_setting(),
                       choice("along", "axis along which it lies", {"x", "y"}, "x"),
                       choice("ends", "whether its ends are fixed", {"fixed", "free"}, "fixed"),
                       geometry_setting()},
          .fields = fabric_fields(),
          .example =
              "string = { type = \"thread\", masses = 20, mass = \"0.1 g\", stiffness = \"50 kN/m\", "
              "spacing = \"20 mm\", tension = \"40 N\" }",
          .build = build_fabric,
          .dimensions = 1,
          .in_space = true,
          .linear = false};
}

ElementType sheet() {
  auto fields = fabric_fields();
  fields.push_back(with_default("shear_stiffness", "N/m", "stiffness of springs along both diagonals", 0.0,
                                0.0, kStiffestFabric));
  return {
      .name = "sheet",
      .doc =
          "Bodies in space on a square grid, joined to their four neighbours by springs along the "
          "lines between them; `name.2.1.z` is z of the first body in the second row. Rows lie along "
          "x, columns along y. A fixed border is one spacing beyond the outer bodies.",
      .equation = "as a thread, in both directions",
      .ends = Ends::None,
      .settings = {whole("rows", "number of rows", 1, 1'000), whole("columns", "number of columns", 1, 1'000),
                   axes_setting(), choice("ends", "whether its border is fixed", {"fixed", "free"}, "fixed"),
                   geometry_setting()},
      .fields = fields,
      .example =
          "skin = { type = \"sheet\", rows = 5, columns = 5, mass = \"1 g\", stiffness = \"20 kN/m\", "
          "spacing = \"30 mm\", tension = \"60 N\" }",
      .build = build_fabric,
      .dimensions = 2,
      .in_space = true,
      .linear = false};
}

}  // namespace

std::vector<ElementType> space_elements() {
  return {particle(), anchor(), trajectory(), line_spring(), thread(), sheet()};
}

}  // namespace tactus
