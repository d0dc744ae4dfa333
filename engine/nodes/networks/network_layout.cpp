#include "engine/nodes/networks/network_layout.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <tuple>
#include <unordered_map>

#include "engine/core/index.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/semantics/scope.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& known) {
  const auto nearest = nearest_name(wrong, known);
  return nearest.empty() ? "there are " + listed(known) : "did you mean '" + nearest + "'?";
}

// Far beyond what runs in real time.
constexpr int kMostPoints = 1'000'000;

class LayoutReader {
 public:
  explicit LayoutReader(const NetworkSpec& spec) : spec_(spec) {}

  Checked<NetworkLayout> run() {
    read_options();
    for (const auto& element : spec_.elements) read_type(element);
    for (std::size_t i = 0; i < spec_.elements.size(); ++i) {
      if (layout_.elements[i].type == nullptr) continue;
      check_keys(spec_.elements[i], *layout_.elements[i].type);
      read_settings(spec_.elements[i], layout_.elements[i]);
    }
    for (std::size_t i = 0; i < spec_.elements.size(); ++i) {
      if (layout_.elements[i].type == nullptr) continue;
      read_ends(spec_.elements[i], layout_.elements[i]);
      read_force_field(spec_.elements[i], layout_.elements[i]);
    }
    if (spec_.elements.empty())
      mistakes_.add(Errc::Missing, spec_.at, "network '" + spec_.name + "' has no elements",
                    "give it a mass, as in stick = { type = \"mass\", mass = \"12 g\" }");
    if (mistakes_.any()) return tl::unexpected(mistakes_.take());
    return std::move(layout_);
  }

 private:
  void read_options() {
    mistakes_.unknown_keys(spec_.options, std::vector<std::string>{"solver", "oversample"});
    const auto solver = mistakes_.text(spec_.options, "solver");
    std::vector<std::string> known;
    for (const auto candidate : kSolvers) known.emplace_back(name_of(candidate));
    const auto found = std::find(known.begin(), known.end(), solver);
    if (found != known.end())
      layout_.solver = kSolvers[index(found - known.begin())];
    else if (!solver.empty())
      mistakes_.add(Errc::UnknownName, find(spec_.options, "solver")->at, "unknown solver '" + solver + "'",
                    did_you_mean(solver, known));
    const auto* oversample = find(spec_.options, "oversample");
    if (oversample == nullptr) return;
    const double* number = oversample->number();
    if (number == nullptr || *number != std::round(*number) || *number < 1 || *number > 64)
      mistakes_.add(Errc::OutOfRange, oversample->at, "'oversample' is not a whole number from 1 to 64",
                    "it is the number of steps in a frame");
    else
      layout_.oversample = static_cast<int>(*number);
  }

  void read_type(const NodeSpec& element) {
    auto& read = layout_.elements.emplace_back();
    read.name = element.name;
    read.type = find_element(element.type);
    index_.emplace(element.name, static_cast<int>(layout_.elements.size()) - 1);
    if (element.name == "energy")
      mistakes_.add(Errc::Duplicate, element.at, "an element cannot be called 'energy'",
                    "'" + spec_.name + ".energy' is the energy of the whole network");
    if (read.type != nullptr) return;
    std::vector<std::string> known;
    for (const auto& type : network_elements()) known.push_back(type.name);
    mistakes_.add(Errc::UnknownName, element.type_at, "no kind of element is called '" + element.type + "'",
                  did_you_mean(element.type, known));
  }

  void check_keys(const NodeSpec& element, const ElementType& type) {
    auto& known = keys_[&type];
    if (known.empty()) known = keys_of(type);
    mistakes_.unknown_keys(element.fields, known);
    for (const auto& field : type.fields) {
      if (field.instead_of.empty()) continue;
      const auto* one = find(element.fields, field.instead_of);
      const auto* other = find(element.fields, field.name);
      if (one != nullptr && other != nullptr)
        mistakes_.add(Errc::Duplicate, other->at,
                      owner(element, type) + " has both '" + field.instead_of + "' and '" + field.name + "'",
                      "remove one of them");
      if (field.one_required && one == nullptr && other == nullptr)
        mistakes_.add(Errc::Missing, element.at,
                      owner(element, type) + " lacks '" + field.instead_of + "' or '" + field.name + "'",
                      "give one of them");
    }
  }

  void read_settings(const NodeSpec& element, NetworkElement& read) {
    for (const auto& setting : read.type->settings)
      read.settings.push_back(
          bind_setting(setting, element.fields, {}, owner(element, *read.type), element.at, mistakes_));
    if (read.points() > kMostPoints)
      mistakes_.add(Errc::OutOfRange, element.at,
                    owner(element, *read.type) + " has " + std::to_string(read.points()) + " masses",
                    "a network takes " + std::to_string(kMostPoints));
  }

  /// As in `normal = "press.force"`: of an element of this network. Anything else is a signal.
  void read_force_field(const NodeSpec& element, NetworkElement& read) {
    const auto& key = read.type->force_field;
    if (key.empty()) return;
    const auto* value = find(element.fields, key);
    if (value == nullptr || value->text() == nullptr) return;
    const auto& text = *value->text();
    const auto found = index_.find(text.substr(0, text.find('.')));
    if (found == index_.end()) return;
    const auto* link = layout_.elements[index(found->second)].type;
    if (text.ends_with(".force") && link != nullptr && link->gives_force) {
      read.pressed_by = found->second;
      return;
    }
    std::vector<std::string> known;
    for (const auto& type : network_elements())
      if (type.gives_force) known.push_back(type.name);
    mistakes_.add(Errc::WrongType, value->at, "'" + text + "' is not the force of one of: " + listed(known),
                  "write the name of one of this network's, as in " + key + " = \"press.force\"");
  }

  static std::vector<std::string> keys_of(const ElementType& type) {
    std::vector<std::string> known = {"type"};
    if (type.ends == Ends::On || type.ends == Ends::Against) known.push_back("on");
    if (type.ends == Ends::Against) known.push_back("against");
    if (type.ends == Ends::Between) known.push_back("between");
    for (const auto& field : type.fields) known.push_back(field.name);
    for (const auto& setting : type.settings) known.push_back(setting.name);
    return known;
  }

  static std::string owner(const NodeSpec& element, const ElementType& type) {
    return type.name + " '" + element.name + "'";
  }

  void read_ends(const NodeSpec& element, NetworkElement& read) {
    const auto& type = *read.type;
    if (type.ends == Ends::Between) return read_between(element, read);
    if (type.ends == Ends::None) return;
    if (const auto* on = find(element.fields, "on"))
      std::tie(read.ends[0], read.within[0]) = point(element, type, *on);
    else
      mistakes_.add(Errc::Missing, element.at, owner(element, type) + " lacks 'on'",
                    "name the mass that it acts on");
    if (const auto* against = find(element.fields, "against"))
      std::tie(read.ends[1], read.within[1]) = point(element, type, *against);
    check_pair(element, read, find(element.fields, "on"));
  }

  void read_between(const NodeSpec& element, NetworkElement& read) {
    const auto* between = find(element.fields, "between");
    const std::string remedy = "name two points, the lower one first, as in between = [\"cone\", \"stick\"]";
    if (between == nullptr)
      return mistakes_.add(Errc::Missing, element.at, owner(element, *read.type) + " lacks 'between'",
                           remedy);
    const auto* list = between->list();
    if (list == nullptr || list->size() != 2)
      return mistakes_.add(Errc::WrongType, between->at,
                           owner(element, *read.type) + " has " +
                               (list ? std::to_string(list->size()) + (list->size() == 1 ? " end" : " ends")
                                     : between->kind() + " for its ends"),
                           remedy);
    for (std::size_t end = 0; end < 2; ++end)
      std::tie(read.ends[end], read.within[end]) = point(element, *read.type, (*list)[end]);
    check_pair(element, read, between);
  }

  /// The element that an end names and which of its points; -1 and a mistake if it is none.
  std::pair<int, int> point(const NodeSpec& element, const ElementType& type, const Value& value) {
    constexpr std::pair kNone{-1, 0};
    const auto* name = value.text();
    if (name == nullptr) {
      mistakes_.add(Errc::WrongType, value.at, "an end of " + owner(element, type) + " is " + value.kind(),
                    "name an element, in quotes");
      return kNone;
    }
    const auto found = index_.find(name->substr(0, name->find('.')));
    if (found == index_.end()) return unknown_end(*name, value), kNone;
    const auto& other = layout_.elements[index(found->second)];
    const auto* end = other.type;
    if (end == nullptr) return kNone;  // reported already
    if (end->ends != Ends::None) {
      mistakes_.add(Errc::WrongType, value.at, "'" + *name + "' is a " + end->name + ", not a point",
                    "an end is a mass, a ground or a motion");
      return kNone;
    }
    if (type.ends == Ends::On && !end->takes_force) {
      mistakes_.add(Errc::WrongType, value.at, "'" + *name + "' is a " + end->name + ", not a mass",
                    "a " + type.name + " acts on a mass");
      return kNone;
    }
    const auto within = place_within(other, *name, value);
    return within ? std::pair{found->second, *within} : kNone;
  }

  void unknown_end(const std::string& name, const Value& value) {
    std::vector<std::string> points;
    for (const auto& other : layout_.elements)
      if (other.type != nullptr && other.type->ends == Ends::None) points.push_back(other.name);
    mistakes_.add(Errc::UnknownName, value.at, "network '" + spec_.name + "' has no element '" + name + "'",
                  points.empty() ? "it has no masses yet" : did_you_mean(name, points));
  }

  /// "string.3" is the third mass of a chain, "skin.2.7" the seventh in the second row of a grid.
  std::optional<int> place_within(const NetworkElement& of, const std::string& name, const Value& value) {
    std::vector<int> places;
    bool numbers = true;
    for (auto dot = name.find('.'); dot != std::string::npos;) {
      const auto next = name.find('.', dot + 1);
      const auto end = name.data() + std::min(next, name.size());
      int number = 0;
      const auto read = std::from_chars(name.data() + dot + 1, end, number);
      numbers = numbers && read.ec == std::errc{} && read.ptr == end;
      places.push_back(number);
      dot = next;
    }
    const auto wanted = index(of.type->dimensions);
    const bool grid = wanted > 1;
    const std::string example = of.name + (grid ? ".1.1" : wanted == 1 ? ".1" : "");
    if (!numbers || places.size() != wanted) {
      mistakes_.add(Errc::WrongType, value.at,
                    wanted == 0 ? "'" + of.name + "' is one mass, and '" + name + "' none of it"
                                : "'" + of.name + "' is many masses, and '" + name + "' is not one of them",
                    "write \"" + example + "\"");
      return std::nullopt;
    }
    if (wanted == 0) return 0;
    const int row = grid ? places[0] : 1, column = places.back();
    if (row < 1 || row > of.rows() || column < 1 || column > of.columns()) {
      mistakes_.add(Errc::OutOfRange, value.at, "'" + name + "' lies outside '" + of.name + "'",
                    "it ends with '" + of.name + (grid ? "." + std::to_string(of.rows()) : "") + "." +
                        std::to_string(of.columns()) + "'");
      return std::nullopt;
    }
    return (row - 1) * of.columns() + column - 1;
  }

  void check_pair(const NodeSpec& element, const NetworkElement& read, const Value* where) {
    if (where == nullptr || read.ends[0] < 0 || read.ends[0] != read.ends[1]) return;
    if (read.within[0] != read.within[1]) return;
    mistakes_.add(Errc::Duplicate, where->at, "both ends of " + owner(element, *read.type) + " are one point",
                  "name two different points");
  }

  const NetworkSpec& spec_;
  NetworkLayout layout_;
  ErrorList mistakes_;
  std::unordered_map<std::string, int> index_;
  std::unordered_map<const ElementType*, std::vector<std::string>> keys_;
};

}  // namespace

Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec) { return LayoutReader(spec).run(); }

}  // namespace tactus
