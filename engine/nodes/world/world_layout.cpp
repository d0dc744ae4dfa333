#include "engine/nodes/world/world_layout.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/graph/semantics/scope.h"
#include "engine/nodes/networks/element_fields.h"

namespace tactus {
namespace {

using Ends = WorldElementType::Ends;

std::string label(const WorldElement& element) { return element.type->name + " '" + element.name + "'"; }

class WorldReader {
 public:
  explicit WorldReader(const NetworkSpec& spec) : spec_(spec) {}

  Checked<WorldLayout> run() {
    read_options();
    for (const auto& element : spec_.elements) read_type(element);
    for (std::size_t i = 0; i < spec_.elements.size(); ++i) {
      auto& read = layout_.elements[i];
      if (read.type == nullptr) continue;
      check_fields(spec_.elements[i], read);
      read_settings(spec_.elements[i], read);
      read_ends(spec_.elements[i], read);
    }
    check_bodies();
    if (errors_.any() || spec_.broken) return tl::unexpected(errors_.take());
    return std::move(layout_);
  }

 private:
  void read_options() {
    FieldReader reader(spec_.fields, world_options(), errors_, "world '" + spec_.name + "'", spec_.at);
    layout_.rate_hz = reader.number("rate").value_or(layout_.rate_hz);
    layout_.direct = reader.choice("solver").value_or(0) == 0;
    layout_.iterations = static_cast<int>(reader.number("iterations").value_or(layout_.iterations));
    layout_.contacts = static_cast<int>(reader.number("contacts").value_or(0));
    layout_.erp = reader.number("erp").value_or(layout_.erp);
    layout_.cfm = reader.number("cfm").value_or(layout_.cfm);
    layout_.stiffness = reader.number("stiffness");
    layout_.damping = reader.number("damping");
    layout_.bounce_speed = reader.number("bounce_speed").value_or(layout_.bounce_speed);
    layout_.correction_speed = reader.number("correction_speed");
    for (const char* key : {"erp", "cfm"})
      if (reader.has(key) && layout_.stiffness)
        errors_.add(Errc::Duplicate, reader.at(key, spec_.at),
                    "world '" + spec_.name + "' has both 'stiffness' and '" + key + "'",
                    "remove one of them");
    if (layout_.stiffness && *layout_.stiffness + layout_.damping.value_or(0) <= 0)
      errors_.add(Errc::OutOfRange, reader.at("stiffness", spec_.at),
                  "contacts without stiffness and damping give no force", "give a stiffness above 0 N/m");
  }

  void read_type(const NodeSpec& element) {
    const auto* type = find_world_element(element.type);
    index_.emplace(element.name, static_cast<int>(layout_.elements.size()));
    auto& read = layout_.elements.emplace_back();
    read.type = type;
    read.name = element.name;
    const auto own = world_quantities();
    if (const auto* taken = find_named(own, element.name))
      errors_.add(Errc::Duplicate, element.at, "an element cannot have the name '" + element.name + "'",
                  "'" + spec_.name + "." + element.name + "' is: " + taken->doc);
    if (type == nullptr && !element.type.empty())  // else reported when the file was read
      errors_.add(Errc::UnknownName, element.type_at,
                  "there is no element type '" + element.type + "' in worlds",
                  suggest(element.type, names_of(world_elements())));
  }

  void check_fields(const NodeSpec& element, const WorldElement& read) {
    errors_.unknown_keys(element.fields,
                         element_keys(read.type->ends, read.type->fields, read.type->settings), label(read));
    check_alternatives(element, read.type->fields, label(read), errors_);
  }

  void read_settings(const NodeSpec& element, WorldElement& read) {
    for (const auto& setting : read.type->settings) {
      auto value = bind_setting(setting, element.fields, {}, label(read), element.at, errors_);
      const auto& numbers = value.numbers;
      const bool vector = setting.kind == Setting::Kind::Numbers;
      const auto* given = find(element.fields, setting.name);
      if (vector && given != nullptr && given->list() != nullptr && given->list()->size() != 3)
        errors_.add(Errc::WrongType, given->at, key_of(setting.name, label(read)) + " must be a vector",
                    "give three numbers: [x, y, z]");
      else if (vector && setting.required && numbers.size() == 3 &&
               std::hypot(numbers[0], numbers[1], numbers[2]) == 0)
        errors_.add(Errc::OutOfRange, given->at, key_of(setting.name, label(read)) + " has no direction",
                    "give a vector that is not 0, as in [0, 0, 1]");
      read.settings.push_back(std::move(value));
    }
  }

  void read_ends(const NodeSpec& element, WorldElement& read) {
    if (read.type->ends == Ends::None) return;
    if (const auto* on = find(element.fields, "on"))
      read.ends[0] = find_body(read, *on);
    else
      errors_.add(Errc::Missing, element.at, label(read) + " lacks 'on'", "give the body that it acts on");
    if (const auto* against = find(element.fields, "against")) read.ends[1] = find_body(read, *against);
    if (read.ends[0] >= 0 && read.ends[0] == read.ends[1])
      errors_.add(Errc::Duplicate, element.at, "both ends of " + label(read) + " are one body",
                  "give two different bodies");
    if (read.ends[0] >= 0 && read.type->part != WorldPart::Collision && !movable(read.ends[0]))
      errors_.add(Errc::WrongType, find(element.fields, "on")->at,
                  "'" + layout_.elements[index(read.ends[0])].name + "' is fixed: " + label(read) +
                      " cannot act on it",
                  "give a body that moves");
  }

  /// By its own keys: its settings may not have been read yet.
  bool movable(int element) const {
    const auto& spec = spec_.elements[index(element)];
    const auto* body = find(spec.fields, kMotionOfBody);
    const bool fixed = body != nullptr && body->text() != nullptr && *body->text() == kFixedBody;
    return !fixed && layout_.elements[index(element)].type->shape != WorldShape::Plane;
  }

  int find_body(const WorldElement& owner, const Value& value) {
    const auto is_body = [](const WorldElement& element) {
      return element.type != nullptr && element.type->part == WorldPart::Body;
    };
    const auto* name = value.text();
    const auto found = name != nullptr ? index_.find(*name) : index_.end();
    if (found != index_.end()) {
      const auto& element = layout_.elements[index(found->second)];
      if (element.type == nullptr || is_body(element)) return element.type == nullptr ? -1 : found->second;
      errors_.add(Errc::WrongType, value.at, "'" + *name + "' is a " + element.type->name + ", not a body",
                  "give a sphere, a box, a capsule or a plane");
      return -1;
    }
    std::vector<std::string> bodies;
    for (const auto& element : layout_.elements)
      if (is_body(element)) bodies.push_back(element.name);
    if (name == nullptr)
      errors_.add(Errc::WrongType, value.at, "an end of " + label(owner) + " is " + value.kind(),
                  "give the name of a body, in quotes");
    else
      errors_.add(Errc::UnknownName, value.at, "world '" + spec_.name + "' has no body '" + *name + "'",
                  bodies.empty() ? "it has no bodies yet" : suggest(*name, bodies));
    return -1;
  }

  void check_bodies() {
    const auto bodies =
        std::count_if(layout_.elements.begin(), layout_.elements.end(), [](const WorldElement& element) {
          return element.type == nullptr || element.type->part == WorldPart::Body;
        });
    if (bodies == 0)
      errors_.add(Errc::Missing, spec_.at, "world '" + spec_.name + "' has no bodies",
                  "give it one, as in ball = { type = \"sphere\", radius = \"2 cm\", mass = \"30 g\" }");
    if (bodies > kMostBodies)
      errors_.add(Errc::OutOfRange, spec_.at,
                  "world '" + spec_.name + "' has " + std::to_string(bodies) + " bodies",
                  "a world takes " + std::to_string(kMostBodies));
  }

  const NetworkSpec& spec_;
  WorldLayout layout_;
  ErrorList errors_;
  std::unordered_map<std::string, int> index_;
};

}  // namespace

int WorldElement::port(std::string_view field) const {
  for (std::size_t i = 0; i < ports.size(); ++i)
    if (type->fields[i].name == field) return ports[i];
  return -1;
}

bool WorldElement::chosen(std::string_view setting, std::string_view word) const {
  for (std::size_t i = 0; i < settings.size(); ++i)
    if (type->settings[i].name == setting) return settings[i].text == word;
  return false;
}

std::optional<std::array<double, 3>> WorldElement::vector(std::string_view setting) const {
  for (std::size_t i = 0; i < settings.size(); ++i)
    if (const auto& numbers = settings[i].numbers; type->settings[i].name == setting && numbers.size() == 3)
      return std::array{numbers[0], numbers[1], numbers[2]};
  return std::nullopt;
}

bool WorldElement::acts_on_any() const {
  return type->part == WorldPart::Link || (type->part == WorldPart::Handle && chosen(kRemote, kRemoteYes));
}

bool WorldElement::collides() const { return !chosen(kCollides, kCollidesNot); }

bool WorldElement::moves() const {
  return type->part == WorldPart::Body && type->shape != WorldShape::Plane &&
         !chosen(kMotionOfBody, kFixedBody);
}

Checked<WorldLayout> read_world_layout(const NetworkSpec& spec) { return WorldReader(spec).run(); }

}  // namespace tactus
