#include <algorithm>
#include <charconv>
#include <optional>
#include <unordered_map>

#include "engine/core/index.h"
#include "engine/graph/semantics/scope.h"
#include "engine/nodes/networks/element_fields.h"
#include "engine/nodes/networks/network_builder.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

std::string owner(const NetworkElement& element) { return element.type->name + " '" + element.name + "'"; }

/// The names in a table of what meets a condition.
template <class Table, class Condition>
std::vector<std::string> names_of(const Table& table, const Condition& meets) {
  std::vector<std::string> names;
  for (const auto& entry : table)
    if (meets(entry)) names.push_back(entry.name);
  return names;
}

class LayoutReader {
 public:
  explicit LayoutReader(const NetworkSpec& spec) : spec_(spec) {}

  Checked<NetworkLayout> run() {
    read_options();
    for (const auto& element : spec_.elements) read_type(element);
    for (const auto read : {&LayoutReader::check_keys, &LayoutReader::read_settings, &LayoutReader::read_ends,
                            &LayoutReader::read_force_field})
      for (std::size_t i = 0; i < spec_.elements.size(); ++i)
        if (layout_.elements[i].type != nullptr) (this->*read)(spec_.elements[i], layout_.elements[i]);
    if (spec_.elements.empty())
      errors_.add(Errc::Missing, spec_.at, "network '" + spec_.name + "' has no elements",
                  "give it a mass, as in stick = { type = \"mass\", mass = \"12 g\" }");
    if (errors_.any() || spec_.broken) return tl::unexpected(errors_.take());
    return std::move(layout_);
  }

 private:
  void read_options() {
    FieldReader reader(spec_.fields, network_options(), errors_);
    if (const auto solver = reader.choice("solver")) layout_.solver = kSolvers[index(*solver)];
    layout_.oversample = static_cast<int>(reader.number("oversample").value_or(0));
    layout_.turns = reader.choice(kMotionSetting) == 1;
  }

  void read_type(const NodeSpec& element) {
    const auto* type = find_element(element.type);
    index_.emplace(element.name, static_cast<int>(layout_.elements.size()));
    auto& read = layout_.elements.emplace_back();
    read.type = type;
    read.name = element.name;
    if (element.name == "energy")
      errors_.add(Errc::Duplicate, element.at, "an element cannot have the name 'energy'",
                  "'" + spec_.name + ".energy' is the energy of the whole network");
    if (type == nullptr && !element.type.empty())  // else reported when the file was read
      errors_.add(Errc::UnknownName, element.type_at, "there is no element type '" + element.type + "'",
                  suggest(element.type, names_of(network_elements(), [](const auto&) { return true; })));
  }

  void check_keys(const NodeSpec& element, NetworkElement& read) {
    errors_.unknown_keys(element.fields,
                         element_keys(read.type->ends, read.type->fields, read.type->settings));
    check_alternatives(element, read.type->fields, owner(read), errors_);
  }

  void read_settings(const NodeSpec& element, NetworkElement& read) {
    for (const auto& setting : read.type->settings)
      read.settings.push_back(bind_setting(setting, element.fields, {}, owner(read), element.at, errors_));
    for (const auto& field : read.type->fields)
      if (const auto* value = find(element.fields, field.name); value != nullptr && !read.has(field))
        errors_.add(Errc::UnknownName, value->at,
                    owner(read) + " moves in " + std::to_string(read.axes()) + " axes and has no '" +
                        field.name + "'",
                    "remove it, or set axes = 3");
    if (read.type->in_space && layout_.turns)
      errors_.add(Errc::WrongType, element.type_at, owner(read) + " moves in space, not around an axis",
                  "put it into a network without motion = \"rotation\"");
    if (read.points() > kMostMasses)
      errors_.add(Errc::OutOfRange, element.at,
                  owner(read) + " has " + std::to_string(read.points()) + " masses",
                  "a network takes " + std::to_string(kMostMasses));
  }

  /// As in `normal = "press.force"`: of an element of this network. Anything else is a signal.
  void read_force_field(const NodeSpec& element, NetworkElement& read) {
    const auto& key = read.type->force_field;
    const auto* value = key.empty() ? nullptr : find(element.fields, key);
    const auto* text = value != nullptr ? value->text() : nullptr;
    const auto found = text != nullptr ? index_.find(text->substr(0, text->find('.'))) : index_.end();
    if (found == index_.end()) return;
    const auto* link = layout_.elements[index(found->second)].type;
    if (text->ends_with(".force") && link != nullptr && link->gives_force)
      read.pressed_by = found->second;
    else
      errors_.add(Errc::WrongType, value->at,
                  "'" + *text + "' is not a force of any of these elements: " +
                      listed(names_of(network_elements(), [](const auto& type) { return type.gives_force; })),
                  "give an element of this network, as in " + key + " = \"press.force\"");
  }

  void read_ends(const NodeSpec& element, NetworkElement& read) {
    const auto ends = read.type->ends;
    if (ends == Ends::None) return;
    const auto* on = find(element.fields, ends == Ends::Between ? "between" : "on");
    const auto* against = ends == Ends::Between ? nullptr : find(element.fields, "against");
    if (ends == Ends::Between)
      read_between(element, read, on);
    else if (on != nullptr)
      read_end(read, 0, *on);
    else
      errors_.add(Errc::Missing, element.at, owner(read) + " lacks 'on'", "give the mass that it acts on");
    if (against != nullptr) read_end(read, 1, *against);
    if (on != nullptr && read.ends[0] >= 0 && read.ends[0] == read.ends[1] &&
        read.within[0] == read.within[1])
      errors_.add(Errc::Duplicate, on->at, "both ends of " + owner(read) + " are one point",
                  "give two different points");
    // An end without a type was reported when the file was read.
    const bool found = read.ends[0] >= 0 && read.ends[1] >= 0;
    if (read.type->in_space && found && !errors_.any()) check_line(element, read, *on);
  }

  /// Ends with the same axes; a line to a place that a signal gives has no length when the file is read.
  void check_line(const NodeSpec& element, const NetworkElement& read, const Value& at) {
    const auto end = [&](int which) -> const NetworkElement& {
      return layout_.elements[index(read.ends[index(which)])];
    };
    if (end(0).axes() != end(1).axes())
      errors_.add(Errc::WrongType, at.at,
                  "'" + end(0).name + "' moves in " + std::to_string(end(0).axes()) + " axes, '" +
                      end(1).name + "' in " + std::to_string(end(1).axes()),
                  "give both the same 'axes'");
    const bool driven = !end(0).type->takes_force && !end(0).type->fields.front().fixed;
    const bool other_driven = !end(1).type->takes_force && !end(1).type->fields.front().fixed;
    if (!driven && !other_driven) return;
    if (find(element.fields, "rest") == nullptr || read.chosen("geometry", "linear"))
      errors_.add(
          Errc::Missing, element.at,
          owner(read) + " leads to a place that a signal gives, so its length at the start is not known",
          "give its 'rest', and geometry = \"nonlinear\"");
  }

  void read_between(const NodeSpec& element, NetworkElement& read, const Value* between) {
    const auto error = [&](Errc code, const Source& at, const std::string& what) {
      errors_.add(code, at, owner(read) + what,
                  "give two points, the lower one first, as in between = [\"cone\", \"stick\"]");
    };
    if (between == nullptr) return error(Errc::Missing, element.at, " lacks 'between'");
    const auto* list = between->list();
    if (list == nullptr)
      return error(Errc::WrongType, between->at, " has " + between->kind() + " for its ends");
    const auto count = list->size();
    if (count != 2)
      return error(Errc::WrongType, between->at,
                   " has " + std::to_string(count) + (count == 1 ? " end" : " ends"));
    for (std::size_t end = 0; end < 2; ++end) read_end(read, end, (*list)[end]);
  }

  /// The element that an end names and which of its points.
  void read_end(NetworkElement& read, std::size_t end, const Value& value) {
    const auto error = [&](const std::string& what, const std::string& remedy) {
      errors_.add(Errc::WrongType, value.at, what, remedy);
    };
    const auto* name = value.text();
    if (name == nullptr)
      return error("an end of " + owner(read) + " is " + value.kind(),
                   "give the name of an element, in quotes");
    const auto found = index_.find(name->substr(0, name->find('.')));
    if (found == index_.end()) return unknown_end(*name, value);
    const auto& other = layout_.elements[index(found->second)];
    if (other.type == nullptr) return;  // reported already
    const auto is_no = [&](const char* wanted, const std::string& remedy) {
      error("'" + *name + "' is a " + other.type->name + ", not a " + wanted, remedy);
    };
    if (other.type->ends != Ends::None)
      return is_no("point", "an end must be a mass, a ground or a motion element");
    if (read.type->ends == Ends::On && !other.type->takes_force)
      return is_no("mass", "a " + read.type->name + " acts on a mass");
    if (read.type->in_space && !other.type->in_space)
      return is_no("particle", "a " + read.type->name + " joins elements that move in space");
    if (const auto within = place_within(other, *name, value, read.type->in_space))
      read.ends[end] = found->second, read.within[end] = *within;
  }

  void unknown_end(const std::string& name, const Value& value) {
    const auto is_point = [](const NetworkElement& e) {
      return e.type != nullptr && e.type->ends == Ends::None;
    };
    const auto points = names_of(layout_.elements, is_point);
    errors_.add(Errc::UnknownName, value.at, "network '" + spec_.name + "' has no element '" + name + "'",
                points.empty() ? "it has no masses yet" : suggest(name, points));
  }

  /// "string.3" is the third mass of a chain, "skin.2.7" the seventh in the second row of a grid. Of an
  /// element in space an axis follows, "bob.x", or none where the `whole` body is wanted.
  std::optional<int> place_within(const NetworkElement& of, std::string name, const Value& value,
                                  bool whole) {
    const int axes = of.axes();
    int axis = -1;
    if (const auto dot = name.rfind('.'); of.type->in_space && dot != std::string::npos)
      for (int a = 0; a < std::ssize(kAxisNames); ++a)
        if (name.substr(dot + 1) == std::string(1, kAxisNames[index(a)])) axis = a;
    if (of.type->in_space && (axis >= axes || whole == (axis >= 0))) {
      const auto body = axis >= 0 ? name.substr(0, name.rfind('.')) : name;
      errors_.add(Errc::WrongType, value.at,
                  axis >= axes ? "'" + of.name + "' moves in x and y only"
                  : whole ? "'" + name + "' is one axis, and this element acts along the line between bodies"
                          : "'" + name + "' moves in several axes, and this element acts along one",
                  "write \"" + body + (whole ? "" : ".x") + "\"");
      return std::nullopt;
    }
    if (axis >= 0) name.resize(name.rfind('.'));
    const auto mass = mass_within(of, name, value);
    if (!mass) return std::nullopt;
    return *mass * axes + std::max(axis, 0);
  }

  /// Which of its masses.
  std::optional<int> mass_within(const NetworkElement& of, const std::string& name, const Value& value) {
    std::vector<int> places;
    bool numbers = true;
    for (auto dot = name.find('.'); dot != std::string::npos;) {
      const auto next = name.find('.', dot + 1);
      const auto* end = name.data() + std::min(next, name.size());
      const auto read = std::from_chars(name.data() + dot + 1, end, places.emplace_back());
      numbers = numbers && read.ec == std::errc{} && read.ptr == end;
      dot = next;
    }
    const auto wanted = index(of.type->dimensions);
    const bool grid = wanted > 1;
    if (!numbers || places.size() != wanted) {
      errors_.add(Errc::WrongType, value.at,
                  wanted == 0 ? "'" + of.name + "' is a single mass, so '" + name + "' is not a mass of it"
                              : "'" + of.name + "' has several masses, but '" + name + "' is not one of them",
                  "write \"" + of.name +
                      (grid          ? ".1.1"
                       : wanted == 1 ? ".1"
                                     : "") +
                      "\"");
      return std::nullopt;
    }
    if (wanted == 0) return 0;
    const int row = grid ? places[0] : 1, column = places.back();
    if (row >= 1 && row <= of.rows() && column >= 1 && column <= of.columns())
      return (row - 1) * of.columns() + column - 1;
    errors_.add(Errc::OutOfRange, value.at, "'" + name + "' is outside '" + of.name + "'",
                "its last mass is '" + of.name + (grid ? "." + std::to_string(of.rows()) : "") + "." +
                    std::to_string(of.columns()) + "'");
    return std::nullopt;
  }

  const NetworkSpec& spec_;
  NetworkLayout layout_;
  ErrorList errors_;
  std::unordered_map<std::string, int> index_;
};

}  // namespace

Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec) { return LayoutReader(spec).run(); }

}  // namespace tactus
