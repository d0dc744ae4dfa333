#include "engine/rig/preset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/file/read_graph.h"
#include "engine/rig/rig.h"

namespace tactus {
namespace {

constexpr std::size_t kLongestName = 64;

std::optional<double> read_value(const Field& field, const FlatControl& control, ErrorList& errors) {
  const auto value = read_quantity(field.value, control.unit, field.key);
  if (!value) {
    errors.add(value.error());
    return std::nullopt;
  }
  // A limit that was written in another unit may be a rounding away.
  const double inside = std::clamp(*value, control.range.low, control.range.high);
  if (std::abs(inside - *value) <= 1e-12 * std::abs(inside)) return inside;
  errors.add(Errc::OutOfRange, field.value.at,
             fmt::format("'{}' is {}, out of its range", field.key, in_unit(*value, control.unit)),
             limits_text(control.range.low, control.range.high, control.unit));
  return std::nullopt;
}

void read_values(const Value::Table& table, std::span<const FlatControl> controls, Preset& preset,
                 ErrorList& errors) {
  std::vector<std::string> names;
  for (const auto& control : controls) names.push_back(control.name);
  for (const auto& field : table) {
    const auto control = std::ranges::find(controls, field.key, &FlatControl::name);
    if (control == controls.end())
      errors.add(Errc::UnknownName, field.at, fmt::format("there is no control '{}'", field.key),
                 suggest(field.key, names));
    else if (const auto value = read_value(field, *control, errors))
      preset.values.push_back({field.key, *value});
  }
}

Checked<Preset> read(const Result<Value::Table>& table, const std::string& file,
                     std::span<const FlatControl> controls) {
  if (!table) return tl::unexpected(std::vector{table.error()});
  const Source start{std::make_shared<const std::string>(file), 1, 1};
  ErrorList errors;
  check_format(*table, start, errors);
  FieldReader{*table, preset_fields(), errors, "the preset", start};
  Preset preset;
  const auto* values = find(*table, "controls");
  if (values != nullptr && values->table() != nullptr)
    read_values(*values->table(), controls, preset, errors);
  else if (values != nullptr)
    errors.add(Errc::WrongType, values->at, "'controls' is " + values->kind(), "write a table: [controls]");
  preset.errors = errors.take();
  return preset;
}

}  // namespace

const SectionType& preset_fields() {
  static const SectionType section{
      "a preset: values of controls",
      joined(heading_fields(), {field("controls", FieldType::Kind::Settings, "values of controls")})};
  return section;
}

Checked<Preset> load_preset(const std::filesystem::path& file, std::span<const FlatControl> controls) {
  return read(load_toml(file), file.generic_string(), controls);
}

Checked<Preset> parse_preset(std::string_view text, const std::string& file_name,
                             std::span<const FlatControl> controls) {
  return read(parse_toml(text, file_name), file_name, controls);
}

std::string to_text(std::span<const PresetValue> values, std::span<const FlatControl> controls) {
  std::string text = "format = 1\n\n[controls]\n";
  for (const auto& [name, value] : values)
    if (const auto control = std::ranges::find(controls, name, &FlatControl::name); control != controls.end())
      text += fmt::format("{} = {}\n", name, exact_quantity({value, control->unit, false}));
  return text;
}

std::filesystem::path preset_folder(const std::filesystem::path& instrument) {
  return instrument.parent_path() / "presets";
}

std::vector<std::string> preset_names(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator{folder, error})
    if (entry.path().extension() == ".toml") names.push_back(entry.path().stem().generic_string());
  std::ranges::sort(names);
  return names;
}

Status check_preset_name(const std::string& name) {
  const auto allowed = [](unsigned char c) {
    return c >= 0x80 || std::isalnum(c) != 0 || c == '_' || c == '-' || c == ' ';
  };
  if (!name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, allowed) &&
      name.front() != ' ' && name.back() != ' ')
    return {};
  return fail(Errc::BadArgument, "", fmt::format("'{}' is no name of a preset", name),
              "use letters, digits, '_', '-' and spaces, at most 64");
}

}  // namespace tactus
