#include "engine/graph/file/read_graph.h"

#include <algorithm>
#include <utility>

#include "engine/graph/file/nearest.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

const std::vector<std::string> kSceneKeys = {"rate",       "duration", "parts", "gestures",
                                             "converters", "expect",   "seed",  "drives"};

bool among(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// False if there is a key that may have been meant as a section.
bool check_keys(const Value::Table& table, Mistakes& mistakes) {
  Value::Table unknown = table;
  std::erase_if(unknown, [](const Field& field) { return among(kSceneKeys, field.key); });
  const auto keys = graph_fields().keys();
  mistakes.unknown_keys(unknown, keys);
  for (const auto& field : table)
    if (among(kSceneKeys, field.key))
      mistakes.add(Errc::UnknownName, field.at, "'" + field.key + "' belongs in a scene, and this is a graph",
                   "move it to the scene's file");
  return std::all_of(unknown.begin(), unknown.end(),
                     [&](const Field& field) { return among(keys, field.key); });
}

bool sections_are_tables(const Value::Table& table) {
  static const std::vector<std::string> kSections = {"inputs", "controls", "nodes", "networks", "outputs"};
  return std::all_of(table.begin(), table.end(), [](const Field& field) {
    return !among(kSections, field.key) || field.value.table() != nullptr;
  });
}

/// Takes a key that must be a string out of `fields`.
std::string take_text(NodeSpec& node, std::string_view key, Mistakes& mistakes) {
  const auto* value = find(node.fields, key);
  if (value == nullptr) return {};
  const auto text = mistakes.text(node.fields, key);
  if (value->text() != nullptr && text.empty())
    mistakes.add(Errc::Missing, value->at, "'" + std::string{key} + "' is empty", "name something");
  node.type_at = value->at;
  std::erase_if(node.fields, [&](const Field& field) { return field.key == key; });
  return text;
}

/// What to write in a node that says neither `type` nor `use`.
std::string remedy_for(const Value::Table& fields) {
  static const std::vector<std::string> kKeys = {"type", "use"};
  for (const auto& field : fields)
    if (const auto nearest = nearest_name(field.key, kKeys); !nearest.empty())
      return "is '" + field.key + "' meant as '" + nearest + "'?";
  return "name a node type, as in type = \"low_pass\", or the file of a part, as in use = \"string.toml\"";
}

NodeSpec read_node(const Field& field, Mistakes& mistakes) {
  NodeSpec node;
  node.name = field.key;
  node.at = node.type_at = field.at;
  const auto* fields = field.value.table();
  if (fields == nullptr) {
    node.value = field.value;
    return node;
  }
  node.fields = *fields;
  const bool has_type = find(*fields, "type") != nullptr, has_use = find(*fields, "use") != nullptr;
  if (has_type && has_use)
    mistakes.add(Errc::Duplicate, field.at, "node '" + field.key + "' has both 'type' and 'use'",
                 "remove one of them");
  else if (!has_type && !has_use)
    mistakes.add(Errc::Missing, field.at, "node '" + field.key + "' has neither 'type' nor 'use'",
                 remedy_for(*fields));
  node.type = take_text(node, "type", mistakes);
  node.use = take_text(node, "use", mistakes);
  node.broken = node.type.empty() == node.use.empty();
  return node;
}

NodeSpec read_element(const Field& field, const std::string& network, Mistakes& mistakes) {
  NodeSpec element;
  element.name = field.key;
  element.at = element.type_at = field.at;
  element.fields = *field.value.table();
  if (find(element.fields, "type") == nullptr)
    mistakes.add(Errc::Missing, field.at,
                 "element '" + field.key + "' of network '" + network + "' has no 'type'",
                 "say what it is, as in type = \"mass\"");
  element.type = take_text(element, "type", mistakes);
  return element;
}

NetworkSpec read_network(const EntrySpec& entry, Mistakes& mistakes) {
  NetworkSpec network{entry.name, entry.at, {}, {}, entry.broken};
  NameSpace names;
  for (const auto& field : entry.fields) {
    if (field.value.table() == nullptr) {
      network.options.push_back(field);
      continue;
    }
    names.add(field.key, "an element", field.at, mistakes);
    network.elements.push_back(read_element(field, entry.name, mistakes));
    network.broken = network.broken || network.elements.back().type.empty();
  }
  return network;
}

void check_names(const GraphSpec& spec, Mistakes& mistakes) {
  NameSpace inside, outputs;
  const auto add_all = [&](const auto& entries, const char* kind, NameSpace& names) {
    for (const auto& entry : entries) names.add(entry.name, kind, entry.at, mistakes);
  };
  add_all(spec.inputs, "an input", inside);
  add_all(spec.controls, "a control", inside);
  add_all(spec.nodes, "a node", inside);
  add_all(spec.networks, "a network", inside);
  // An output may be called like the node that it gives out: nothing inside the file refers to outputs.
  add_all(spec.outputs, "an output", outputs);
}

}  // namespace

std::vector<FieldType> heading_fields() {
  using Kind = FieldType::Kind;
  return {required(field("format", Kind::Format, "of the file")), field("name", Kind::Prose, "for people"),
          field("about", Kind::Prose, "for people: what it does"),
          field("source", Kind::Prose, "for people: where it comes from")};
}

namespace {
FieldType unit_field() {
  return text_field("unit", "\"m/s\", \"N/m\", \"ms\", \"dB\", \"full scale\"", "a plain number");
}
}  // namespace

const SectionType& input_fields() {
  static const SectionType section{
      "an input", {unit_field(), about_field(), whole_field("lanes", 1, 1024, "lanes", "1")}};
  return section;
}

const SectionType& control_fields() {
  static const SectionType section{
      "what the player sets",
      {required(field("value", FieldType::Kind::Any, "where it starts")),
       field("range", FieldType::Kind::Range, "lowest and highest value"), unit_field(),
       quantity_field("smooth", "s", 0, kNoBound, "time in which it reaches a new value", "10 ms"),
       about_field()}};
  return section;
}

const SectionType& output_fields() {
  static const SectionType section{
      "an output",
      {required(field("from", FieldType::Kind::Signal, "an expression")),
       choice_field("kind", {"drive", "audio"}, "for a hand or for the ears", "drive"), unit_field(),
       about_field()}};
  return section;
}

const SectionType& part_fields() {
  static const SectionType section{
      "a graph file as a node; its inputs and controls are wired by name",
      {required(text_field("use", "path of the file, from this one")),
       whole_field("voices", 1, 1024, "how many lanes", "1"),
       text_field("rate", "of its own: a fraction, \"1/16\", or \"3 kHz\"", "that around it"),
       choice_field("take", {"last", "mean"}, "what a frame at that rate is given", "last"),
       choice_field("between", {"hold", "line"}, "what goes out between two of them", "hold"),
       about_field()}};
  return section;
}

const SectionType& graph_fields() {
  using Kind = FieldType::Kind;
  static const SectionType delay{
      "system delay",
      {field("tested", Kind::Range, "shortest and longest that the instrument was tested with")}};
  static const SectionType section{
      "an instrument, a plant or a part",
      joined(heading_fields(),
             {entries_field("inputs", input_fields(), "sensors, or what a part is given"),
              entries_field("controls", control_fields(), "what the player sets"),
              {.key = "nodes",
               .kind = Kind::Reference,
               .doc = "`tactus nodes` explains each type",
               .unit = "node"},
              {.key = "networks",
               .kind = Kind::Reference,
               .doc = "`tactus nodes network` explains the elements",
               .unit = "network"},
              entries_field("outputs", output_fields(), "drives and sound, or what a part gives"),
              section_field("delay", delay)})};
  return section;
}

void check_format(const Value::Table& table, const Source& file, Mistakes& mistakes) {
  const auto* format = find(table, "format");
  if (format == nullptr)
    return mistakes.add(Errc::Missing, {file.file, 1, 1}, "'format' is missing",
                        "begin the file with format = 1");
  if (format->number() == nullptr || *format->number() != 1.0)
    mistakes.add(Errc::OutOfRange, format->at, "this format is not known", "write format = 1");
}

const Value::Table* read_section(const Value::Table& table, const std::string& section, Mistakes& mistakes) {
  const auto* value = find(table, section);
  if (value == nullptr) return nullptr;
  if (value->table() == nullptr)
    mistakes.add(Errc::WrongType, value->at, "'" + section + "' must be a table, not " + value->kind(),
                 "begin it with [" + section + "]");
  return value->table();
}

std::vector<EntrySpec> read_entries(const Value::Table& table, const std::string& section,
                                    const std::string& example, Mistakes& mistakes) {
  std::vector<EntrySpec> entries;
  const auto* fields = read_section(table, section, mistakes);
  if (fields == nullptr) return entries;
  for (const auto& field : *fields) {
    const auto* inside = field.value.table();
    if (inside == nullptr)
      mistakes.add(Errc::WrongType, field.value.at,
                   "'" + field.key + "' in [" + section + "] must be a table, not " + field.value.kind(),
                   "write " + field.key + " = " + example);
    entries.push_back({field.key, field.at, inside ? *inside : Value::Table{}, inside == nullptr});
  }
  return entries;
}

GraphSpec read_graph(const Value::Table& table, const Source& file, Mistakes& mistakes) {
  GraphSpec spec;
  spec.file = file;
  check_format(table, file, mistakes);
  spec.incomplete = !check_keys(table, mistakes) || !sections_are_tables(table);
  spec.name = mistakes.text(table, "name");
  spec.about = mistakes.text(table, "about");
  spec.source = mistakes.text(table, "source");
  spec.inputs = read_entries(table, "inputs", "{ unit = \"full scale\" }", mistakes);
  spec.controls = read_entries(table, "controls", "{ value = 0.5, range = [0, 1] }", mistakes);
  spec.outputs = read_entries(table, "outputs", "{ from = \"node\" }", mistakes);
  if (const auto* nodes = read_section(table, "nodes", mistakes))
    for (const auto& field : *nodes) spec.nodes.push_back(read_node(field, mistakes));
  for (const auto& entry : read_entries(table, "networks", "{ mass = { type = \"mass\" } }", mistakes))
    spec.networks.push_back(read_network(entry, mistakes));
  if (const auto* delay = read_section(table, "delay", mistakes))
    spec.delay = EntrySpec{"delay", find(table, "delay")->at, *delay};
  check_names(spec, mistakes);
  return spec;
}

}  // namespace tactus
