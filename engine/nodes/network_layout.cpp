#include "engine/nodes/network_layout.h"

#include <cmath>
#include <unordered_map>

#include "engine/graph/mistakes.h"
#include "engine/graph/nearest.h"

namespace tactus {
namespace {

using Ends = ElementType::Ends;

std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& known) {
  const auto nearest = nearest_name(wrong, known);
  return nearest.empty() ? "there are " + listed(known) : "did you mean '" + nearest + "'?";
}

class LayoutReader {
 public:
  explicit LayoutReader(const NetworkSpec& spec) : spec_(spec) {}

  Checked<NetworkLayout> run() {
    read_options();
    for (const auto& element : spec_.elements) read_type(element);
    for (std::size_t i = 0; i < spec_.elements.size(); ++i) {
      if (layout_.elements[i].type == nullptr) continue;
      check_keys(spec_.elements[i], *layout_.elements[i].type);
      read_ends(spec_.elements[i], layout_.elements[i]);
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
    if (solver == "explicit")
      layout_.solver = Solver::Explicit;
    else if (!solver.empty() && solver != "passive")
      mistakes_.add(Errc::UnknownName, find(spec_.options, "solver")->at, "unknown solver '" + solver + "'",
                    did_you_mean(solver, {"passive", "explicit"}));
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
    if (const auto* ratio = find(element.fields, "restitution");
        ratio != nullptr && find(element.fields, "loss"))
      mistakes_.add(Errc::Duplicate, ratio->at, owner(element, type) + " has both 'loss' and 'restitution'",
                    "remove one of them");
  }

  static std::vector<std::string> keys_of(const ElementType& type) {
    std::vector<std::string> known = {"type"};
    if (type.ends == Ends::On || type.ends == Ends::Against) known.push_back("on");
    if (type.ends == Ends::Against) known.push_back("against");
    if (type.ends == Ends::Between) known.push_back("between");
    for (const auto& field : type.fields) known.push_back(field.name);
    return known;
  }

  static std::string owner(const NodeSpec& element, const ElementType& type) {
    return type.name + " '" + element.name + "'";
  }

  void read_ends(const NodeSpec& element, NetworkLayout::Element& read) {
    const auto& type = *read.type;
    if (type.ends == Ends::Between) return read_between(element, read);
    if (type.ends == Ends::None) return;
    if (const auto* on = find(element.fields, "on"))
      read.ends[0] = point(element, type, *on);
    else
      mistakes_.add(Errc::Missing, element.at, owner(element, type) + " lacks 'on'",
                    "name the mass that it acts on");
    if (const auto* against = find(element.fields, "against")) read.ends[1] = point(element, type, *against);
    check_pair(element, read, find(element.fields, "on"));
  }

  void read_between(const NodeSpec& element, NetworkLayout::Element& read) {
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
    for (std::size_t end = 0; end < 2; ++end) read.ends[end] = point(element, *read.type, (*list)[end]);
    check_pair(element, read, between);
  }

  /// The element that an end names; -1 and a mistake if it is no point.
  int point(const NodeSpec& element, const ElementType& type, const Value& value) {
    const auto* name = value.text();
    if (name == nullptr) {
      mistakes_.add(Errc::WrongType, value.at, "an end of " + owner(element, type) + " is " + value.kind(),
                    "name an element, in quotes");
      return -1;
    }
    const auto found = index_.find(*name);
    if (found == index_.end()) {
      std::vector<std::string> points;
      for (const auto& other : layout_.elements)
        if (other.type != nullptr && other.type->ends == Ends::None) points.push_back(other.name);
      mistakes_.add(Errc::UnknownName, value.at,
                    "network '" + spec_.name + "' has no element '" + *name + "'",
                    points.empty() ? "it has no masses yet" : did_you_mean(*name, points));
      return -1;
    }
    const auto* end = layout_.elements[static_cast<std::size_t>(found->second)].type;
    if (end == nullptr) return -1;  // reported already
    if (end->ends != Ends::None) {
      mistakes_.add(Errc::WrongType, value.at, "'" + *name + "' is a " + end->name + ", not a point",
                    "an end is a mass, a ground or a motion");
      return -1;
    }
    if (type.ends == Ends::On && end->name != "mass") {
      mistakes_.add(Errc::WrongType, value.at, "'" + *name + "' is a " + end->name + ", not a mass",
                    "a " + type.name + " acts on a mass");
      return -1;
    }
    return found->second;
  }

  void check_pair(const NodeSpec& element, const NetworkLayout::Element& read, const Value* where) {
    if (where == nullptr || read.ends[0] < 0 || read.ends[0] != read.ends[1]) return;
    mistakes_.add(Errc::Duplicate, where->at, "both ends of " + owner(element, *read.type) + " are one point",
                  "name two different points");
  }

  const NetworkSpec& spec_;
  NetworkLayout layout_;
  Mistakes mistakes_;
  std::unordered_map<std::string, int> index_;
  std::unordered_map<const ElementType*, std::vector<std::string>> keys_;
};

}  // namespace

Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec) { return LayoutReader(spec).run(); }

}  // namespace tactus
