#include "engine/rig/actuator_figures.h"

#include <limits>
#include <memory>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

/// A property, with the unit and the meaning of its numbers.
struct Property {
  const char *name, *doc, *unit;
  ActuatorFigure ActuatorFigures::*figure;
  const char *low, *high;  ///< their keys; nullptr: there is no such number
};
constexpr Property kProperties[] = {
    {"price", "in US $", "", &ActuatorFigures::price, "from", "to"},
    {"force", "largest force", "N", &ActuatorFigures::force, nullptr, "at_most"},
    {"band", "frequencies that it moves at", "Hz", &ActuatorFigures::band, "from", "to"},
    {"excursion", "to either side", "m", &ActuatorFigures::excursion, nullptr, "at_most"},
    {"resolution", "of its own sensor", "m", &ActuatorFigures::resolution, "step", nullptr},
};

constexpr const char* kDriveTo = "drive_to";
constexpr const char* kArm = "arm";
constexpr const char* kNoSensor = "no_sensor";
constexpr const char* kSensor = "sensor";

SectionType section_of(const Property& property) {
  std::vector<FieldType> fields = {
      text_field("value", "for people, as in \"2 N at 10 V\""),
      required(choice_field("kind", actuator_figure_kinds(),
                            "read in the source, derived from other figures, a judgement, or not found")),
      required(text_field("source", "where it comes from"))};
  for (const auto* key : {property.low, property.high})
    if (key != nullptr) fields.push_back(quantity_field(key, property.unit, 0, 1e9, property.doc));
  if (property.figure == &ActuatorFigures::force)
    fields.push_back(quantity_field(kArm, "m", 1e-3, 10, "length of the arm at whose tip it is measured"));
  if (property.figure == &ActuatorFigures::excursion)
    fields.push_back(field("endless", FieldType::Kind::Flag, "it turns without end"));
  if (property.figure == &ActuatorFigures::band)
    fields.push_back(quantity_field(kDriveTo, "Hz", 0, 1e9,
                                    "changes of the drive that it follows, if the drive is not in the band"));
  if (property.figure == &ActuatorFigures::resolution)
    fields.push_back(field(kNoSensor, FieldType::Kind::Flag, "it has no sensor of its own"));
  return {property.doc, std::move(fields)};
}

void read_figure(const Value::Table& table, const Property& property, ActuatorFigures& figures,
                 ErrorList& errors) {
  const auto* section = read_section(table, property.name, errors);
  if (section == nullptr) return;
  auto& figure = figures.*property.figure;
  FieldReader fields{*section, *actuator_figure_fields()[property.name].inside, errors,
                     std::string{"["} + property.name + "]", find(table, property.name)->at};
  figure.value = fields.text("value");
  figure.source = fields.text("source");
  figure.kind = static_cast<ActuatorFigure::Kind>(
      fields.choice("kind").value_or(static_cast<int>(ActuatorFigure::Kind::Unknown)));
  if (property.low != nullptr) figure.low = fields.number(property.low);
  if (property.high != nullptr) figure.high = fields.number(property.high);
  if (figure.low && figure.high && *figure.low > *figure.high)
    errors.add(
        Errc::OutOfRange, fields.value(property.high)->at,
        key_of(property.high, std::string{"["} + property.name + "]") + " is below '" + property.low + "'",
        "swap them");
  if (property.figure == &ActuatorFigures::force) figures.arm = fields.number(kArm);
  if (property.figure == &ActuatorFigures::excursion && fields.flag("endless"))
    figure.high = std::numeric_limits<double>::infinity();
  if (property.figure == &ActuatorFigures::band) figures.drive_to = fields.number(kDriveTo);
  if (property.figure == &ActuatorFigures::resolution) figures.no_sensor = fields.flag(kNoSensor);
}

Checked<ActuatorFigures> read_figures(const Result<Value::Table>& table, const std::string& file) {
  if (!table) return tl::unexpected(std::vector{table.error()});
  const Source start{std::make_shared<const std::string>(file), 1, 1};
  ErrorList errors;
  check_format(*table, start, errors);
  FieldReader fields{*table, actuator_figure_fields(), errors, "the actuator", start};
  ActuatorFigures figures;
  figures.name = fields.text("name");
  if (fields.has("name")) figures.name_at = fields.value("name")->at;
  if (fields.has("profile")) figures.profile_at = fields.value("profile")->at;
  figures.row = fields.text("row");
  figures.section = fields.text("section");
  figures.plant = fields.text("plant");
  figures.profile = fields.text("profile");
  figures.sensor = fields.flag(kSensor);
  for (const auto& property : kProperties) read_figure(*table, property, figures, errors);
  if (errors.any()) return tl::unexpected(errors.take());
  return figures;
}

}  // namespace

const std::vector<std::string>& actuator_figure_kinds() {
  static const std::vector<std::string> names = {"sheet", "derived", "judgement", "unknown"};  // as Kind
  return names;
}

const SectionType& actuator_figure_fields() {
  static const auto sections = [] {
    std::vector<SectionType> all;
    for (const auto& property : kProperties) all.push_back(section_of(property));
    return all;
  }();
  static const SectionType section = [] {
    std::vector<FieldType> fields = {
        required(field("format", FieldType::Kind::Format, "format of the file, 1")),
        required(text_field("name", "name for the user")),
        text_field("section", "of the paper"),
        text_field("row", "of table 1 of the paper"),
        text_field("plant", "file of its simulated plant"),
        text_field("profile", "name or file of its profile for the drive guard"),
        field(kSensor, FieldType::Kind::Flag, "it is a sensor, and moves nothing")};
    for (std::size_t p = 0; p < sections.size(); ++p)
      fields.push_back(section_field(kProperties[p].name, sections[p]));
    return SectionType{"figures of an actuator", std::move(fields)};
  }();
  return section;
}

Checked<ActuatorFigures> load_actuator_figures(const std::filesystem::path& file) {
  return read_figures(load_toml(file), file.generic_string());
}

Checked<ActuatorFigures> parse_actuator_figures(std::string_view text, const std::string& file_name) {
  return read_figures(parse_toml(text, file_name), file_name);
}

}  // namespace tactus
