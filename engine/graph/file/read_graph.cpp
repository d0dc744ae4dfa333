#include "engine/graph/file/read_graph.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/graph/file/error_list.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

const std::vector<std::string> kSceneKeys = {"rate",   "duration",    "parts",   "gestures", "converters",
                                             "expect", "seed",        "drives",  "accuracy", "ports",
                                             "roles",  "playability", "compare", "show",     "monitor"};

bool among(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// False if there is a key that may have been meant as a section.
bool check_keys(const Value::Table& table, ErrorList& errors) {
  const auto keys = graph_fields().keys();
  Value::Table unknown;
  for (const auto& field : table)
    if (among(kSceneKeys, field.key))
      errors.add(Errc::UnknownName, field.at, "'" + field.key + "' is a key of scenes, but this is a graph",
                 "move it to the scene's file");
    else if (!among(keys, field.key))
      unknown.push_back(field);
  errors.unknown_keys(unknown, keys);
  return unknown.empty();
}

/// Those in which names are declared.
bool sections_are_tables(const Value::Table& table) {
  using Kind = FieldType::Kind;
  const auto& fields = graph_fields().fields;
  return std::all_of(fields.begin(), fields.end(), [&](const FieldType& field) {
    const auto* value = find(table, field.name);
    return (field.kind != Kind::Entries && field.kind != Kind::Reference) || value == nullptr ||
           value->table() != nullptr;
  });
}

/// Takes a key that must be a string out of `fields`.
std::string take_text(NodeSpec& node, std::string_view key, ErrorList& errors) {
  const auto* value = find(node.fields, key);
  if (value == nullptr) return {};
  const auto text = errors.text(node.fields, key);
  if (value->text() != nullptr && text.empty())
    errors.add(Errc::Missing, value->at, "'" + std::string{key} + "' is empty", "give a name");
  node.type_at = value->at;
  std::erase_if(node.fields, [&](const Field& field) { return field.key == key; });
  return text;
}

/// The remedy for a node without `type` and `use`.
std::string remedy_for(const Value::Table& fields) {
  static const std::vector<std::string> kKeys = {"type", "use"};
  for (const auto& field : fields)
    if (const auto nearest = nearest_name(field.key, kKeys); !nearest.empty())
      return "is '" + field.key + "' a misspelling of '" + nearest + "'?";
  return "give a node type, as in type = \"low_pass\", or the file of a part, as in use = \"string.toml\"";
}

NodeSpec read_node(const Field& field, ErrorList& errors) {
  NodeSpec node{{field.key, field.at, {}}, {}, {}, {}, field.at};
  const auto* fields = field.value.table();
  if (fields == nullptr) {
    node.value = field.value;
    return node;
  }
  node.fields = *fields;
  const bool has_type = find(*fields, "type") != nullptr, has_use = find(*fields, "use") != nullptr;
  if (has_type && has_use)
    errors.add(Errc::Duplicate, field.at, "node '" + field.key + "' has both 'type' and 'use'",
               "remove one of them");
  else if (!has_type && !has_use)
    errors.add(Errc::Missing, field.at, "node '" + field.key + "' has neither 'type' nor 'use'",
               remedy_for(*fields));
  node.type = take_text(node, "type", errors);
  node.use = take_text(node, "use", errors);
  node.broken = node.type.empty() == node.use.empty();
  return node;
}

NodeSpec read_element(const Field& field, const NetworkSpec& network, ErrorList& errors) {
  NodeSpec element{{field.key, field.at, *field.value.table()}, {}, {}, {}, field.at};
  if (find(element.fields, "type") == nullptr)
    errors.add(Errc::Missing, field.at,
               "element '" + field.key + "' of " + network.kind() + " '" + network.name + "' has no 'type'",
               std::string{"give its type, as in type = \""} + (network.world ? "sphere\"" : "mass\""));
  element.type = take_text(element, "type", errors);
  return element;
}

NetworkSpec read_network(EntrySpec entry, bool world, ErrorList& errors) {
  NetworkSpec network{{entry.name, entry.at, {}, entry.broken}, {}, world};
  NameSpace names{NameSpace::Names::AfterDots};
  for (auto& field : entry.fields) {
    if (field.value.table() == nullptr) {
      network.fields.push_back(std::move(field));
      continue;
    }
    names.add(field.key, "an element", field.at, errors);
    network.elements.push_back(read_element(field, network, errors));
    network.broken = network.broken || network.elements.back().type.empty();
  }
  return network;
}

void check_names(const GraphSpec& spec, ErrorList& errors) {
  NameSpace inside, outputs{NameSpace::Names::AfterDots};
  const auto add_all = [&](const auto& entries, const char* kind, NameSpace& names) {
    for (const auto& entry : entries) names.add(entry.name, kind, entry.at, errors);
  };
  add_all(spec.inputs, "an input", inside);
  add_all(spec.controls, "a control", inside);
  add_all(spec.nodes, "a node", inside);
  for (const auto& network : spec.networks)
    inside.add(network.name, std::string{"a "} + network.kind(), network.at, errors);
  // An output may be called like the node that it gives out: nothing inside the file refers to outputs.
  add_all(spec.outputs, "an output", outputs);
}

FieldType unit_field() {
  return field("unit", FieldType::Kind::Unit, "\"m/s\", \"N/m\", \"ms\", \"dB\", \"full scale\"",
               "a plain number");
}
const SectionType& input_fields() {
  static const SectionType section{
      "an input",
      {unit_field(), about_field(), whole_field("lanes", 1, 1024, "number of lanes", "1"),
       field("range", FieldType::Kind::Range,
             "what the sensor can give; programs in integers need it (tactus export)")}};
  return section;
}

constexpr const char* kWhole = "whole";

const SectionType& control_fields() {
  static const SectionType section{
      "controls of the player",
      {required(field("value", FieldType::Kind::Any, "initial value")),
       field("range", FieldType::Kind::Range, "minimum and maximum value"), unit_field(),
       field(kWhole, FieldType::Kind::Flag, "takes whole numbers only: a count or a choice"),
       quantity_field("smooth", "s", 0, kUnlimited, "ramp time to a new value", "10 ms"),
       choice_field(
           "midi", {"note", "velocity", "note_on", "note_off"},
           "follows a MIDI keyboard without a ramp: the number of the key that is pressed or released, how "
           "strongly (0 to 1), a trigger when one is pressed, a trigger when one is released"),
       about_field()}};
  return section;
}

const SectionType& output_fields() {
  static const SectionType section{
      "an output",
      {required(field("from", FieldType::Kind::Signal, "source, an expression")),
       choice_field("kind", {"drive", "audio"}, "drive: to an actuator; audio: for listening", "drive"),
       unit_field(), about_field()}};
  return section;
}

FieldType voices_field() { return whole_field("voices", 1, 1024, "number of lanes", "1"); }

std::string owner_of(const char* kind, const EntrySpec& entry) {
  return std::string{kind} + " '" + entry.name + "'";
}

std::optional<Unit> set_unit(PortSpec& port, FieldReader& fields) {
  const auto unit = fields.unit("unit");
  port.unit_known = unit.has_value();
  if (unit) port.dimension = unit->dimension;
  return unit;
}

PortSpec read_input(EntrySpec entry, ErrorList& errors) {
  PortSpec input{std::move(entry)};
  FieldReader fields{input.fields, input_fields(), errors, owner_of("input", input)};
  if (const auto unit = set_unit(input, fields)) input.range = fields.range("range", *unit);
  const auto* unit = find(input.fields, "unit");
  const bool full_scale = unit != nullptr && unit->text() != nullptr && *unit->text() == "full scale";
  if (!input.range && full_scale) input.range = Interval{-1, 1};
  input.lanes = static_cast<int>(fields.number("lanes").value_or(1));
  return input;
}

PortSpec read_output(EntrySpec entry, ErrorList& errors) {
  PortSpec output{std::move(entry)};
  FieldReader fields{output.fields, output_fields(), errors, owner_of("output", output)};
  set_unit(output, fields);
  output.use = fields.choice("kind") == 1 ? OutputUse::Audio : OutputUse::Drive;
  return output;
}

/// Where the control starts, and by its unit the control's. False after an error.
bool read_value(const ControlSpec& entry, FlatControl& control, ErrorList& errors) {
  const auto* value = find(entry.fields, "value");
  if (value == nullptr) {
    errors.add(Errc::Missing, entry.at, "control '" + entry.name + "' lacks 'value'",
               "give its initial value, as in value = 0.5");
    return false;
  }
  const bool unit_given = find(entry.fields, "unit") != nullptr;
  if (unit_given && errors.keep(read_quantity(*value, control.unit, "value")) == nullptr) return false;
  const auto quantity = read_quantity(*value);
  if (!quantity) return errors.add(quantity.error()), false;
  control.value = quantity->si;
  if (!quantity->bare) control.unit = quantity->unit;
  return true;
}

void read_range(FieldReader& fields, FlatControl& control, ErrorList& errors) {
  const auto range = fields.range("range", control.unit);
  if (!range) return;
  control.range = *range;
  if (!range->contains(control.value))
    errors.add(Errc::OutOfRange, fields.value("value")->at,
               "control '" + control.name + "' starts at " + in_unit(control.value, control.unit) +
                   ", which is outside its range",
               limits_text(range->low, range->high, control.unit));
}

ControlSpec read_control(EntrySpec entry, ErrorList& errors) {
  ControlSpec read{std::move(entry)};
  auto& control = read.control;
  control.name = read.name;
  read.unit_known = !read.broken;
  if (read.broken) return read;
  FieldReader fields{read.fields, control_fields(), errors, owner_of("control", read)};
  const auto unit = fields.unit("unit");
  if (unit) control.unit = *unit;
  read.unit_known = unit && read_value(read, control, errors);
  control.about = fields.text("about");
  if (read.unit_known) read_range(fields, control, errors);
  if (fields.flag(kWhole) && read.unit_known && std::floor(control.value) != control.value)
    errors.add(Errc::OutOfRange, fields.value("value")->at,
               "control '" + control.name + "' starts at " + in_unit(control.value, control.unit),
               kGiveWholeNumber);
  control.smooth_s = fields.number("smooth").value_or(control.smooth_s);
  if (const auto role = fields.choice("midi")) {
    control.midi = static_cast<MidiRole>(1 + *role);
    control.smooth_s = 0;
  }
  return read;
}

}  // namespace

std::vector<FieldType> heading_fields() {
  using Kind = FieldType::Kind;
  return {required(field("format", Kind::Format, "format of the file, 1")),
          field("name", Kind::Prose, "name for the user"), field("about", Kind::Prose, "description"),
          field("source", Kind::Prose, "origin")};
}

const SectionType& node_fields() {
  static const SectionType section{
      "a node of a given type",
      {required(text_field("type", "type of the node")), voices_field(), about_field()}};
  return section;
}

const SectionType& part_fields() {
  static const SectionType section{
      "a graph file used as a node; its inputs and controls are connected by name",
      {required(text_field("use", "path of the file, relative to this file")), voices_field(),
       text_field("rate", "sample rate of the part: a fraction, such as \"1/16\", or \"3 kHz\"",
                  "that of the enclosing graph"),
       choice_field("take", {"last", "mean"}, "input of a frame at that rate: the last value or the mean",
                    "last"),
       choice_field("between", {"hold", "line"}, "output between two of its frames: held or interpolated",
                    "hold"),
       about_field()}};
  return section;
}

const SectionType& graph_fields() {
  using Kind = FieldType::Kind;
  static const SectionType delay{
      "system delay",
      {field("tested", Kind::Range, "shortest and longest delay that the instrument was tested with")}};
  static const SectionType section{
      "a graph file: an instrument, a plant or a part",
      joined(heading_fields(),
             {entries_field("inputs", input_fields(), "sensors, or the inputs of a part"),
              entries_field("controls", control_fields(), "controls of the player"),
              {"nodes", Kind::Reference, "`tactus nodes` explains each type", {"node"}},
              {"networks", Kind::Reference, "`tactus nodes network` explains the elements", {"network"}},
              {"worlds", Kind::Reference, "`tactus nodes world` explains the elements", {"world"}},
              entries_field("outputs", output_fields(), "drives and sound, or the outputs of a part"),
              section_field("delay", delay)})};
  return section;
}

bool takes_whole_numbers(const ControlSpec& control) {
  const auto* whole = find(control.fields, kWhole);
  return whole != nullptr && whole->flag() != nullptr && *whole->flag();
}

void check_format(const Value::Table& table, const Source& file, ErrorList& errors) {
  const auto* format = find(table, "format");
  if (format == nullptr)
    return errors.add(Errc::Missing, {file.file, 1, 1}, "'format' is missing",
                      "begin the file with format = 1");
  if (format->number() == nullptr || *format->number() != 1.0)
    errors.add(Errc::OutOfRange, format->at, "this format is unknown", "write format = 1");
}

const Value::Table* read_section(const Value::Table& table, const std::string& section, ErrorList& errors) {
  const auto* value = find(table, section);
  if (value == nullptr) return nullptr;
  if (value->table() == nullptr)
    errors.add(Errc::WrongType, value->at, "'" + section + "' must be a table, not " + value->kind(),
               "begin it with [" + section + "]");
  return value->table();
}

std::vector<EntrySpec> read_entries(const Value::Table& table, const std::string& section,
                                    const std::string& example, ErrorList& errors) {
  std::vector<EntrySpec> entries;
  const auto* fields = read_section(table, section, errors);
  if (fields == nullptr) return entries;
  for (const auto& field : *fields) {
    const auto* inside = field.value.table();
    if (inside == nullptr)
      errors.add(Errc::WrongType, field.value.at,
                 "'" + field.key + "' in [" + section + "] must be a table, not " + field.value.kind(),
                 "write " + field.key + " = " + example);
    entries.push_back({field.key, field.at, inside ? *inside : Value::Table{}, inside == nullptr});
  }
  return entries;
}

GraphSpec read_graph(const Value::Table& table, const Source& file, ErrorList& errors) {
  GraphSpec spec;
  spec.file = file;
  check_format(table, file, errors);
  spec.incomplete = !check_keys(table, errors) || !sections_are_tables(table);
  spec.name = errors.text(table, "name");
  spec.about = errors.text(table, "about");
  spec.source = errors.text(table, "source");
  for (auto& entry : read_entries(table, "inputs", "{ unit = \"full scale\" }", errors))
    spec.inputs.push_back(read_input(std::move(entry), errors));
  for (auto& entry : read_entries(table, "controls", "{ value = 0.5, range = [0, 1] }", errors))
    spec.controls.push_back(read_control(std::move(entry), errors));
  for (auto& entry : read_entries(table, "outputs", "{ from = \"node\" }", errors))
    spec.outputs.push_back(read_output(std::move(entry), errors));
  if (const auto* nodes = read_section(table, "nodes", errors))
    for (const auto& field : *nodes) spec.nodes.push_back(read_node(field, errors));
  for (auto& entry : read_entries(table, "networks", "{ mass = { type = \"mass\" } }", errors))
    spec.networks.push_back(read_network(std::move(entry), false, errors));
  for (auto& entry : read_entries(table, "worlds", "{ ball = { type = \"sphere\" } }", errors))
    spec.networks.push_back(read_network(std::move(entry), true, errors));
  if (const auto* delay = read_section(table, "delay", errors))
    spec.tested = FieldReader{*delay, *graph_fields()["delay"].inside, errors, "[delay]"}.range(
        "tested", *parse_unit("s"));
  check_names(spec, errors);
  return spec;
}

}  // namespace tactus
