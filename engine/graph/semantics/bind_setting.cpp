#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {
namespace {

/// The table entry that reads the kinds which other files have too.
SectionType section_of(const Setting& setting) {
  FieldType::Kind kind = FieldType::Kind::Text;
  if (setting.kind == Setting::Kind::Choice) kind = FieldType::Kind::Choice;
  if (setting.kind == Setting::Kind::Integer) kind = FieldType::Kind::Whole;
  auto only = field(setting.name, kind, setting.doc);
  only.low = setting.low;
  only.high = setting.high;
  only.choices = setting.choices;
  return {"", {std::move(only)}};
}

/// Reads one setting of one node; its errors have the place and the name of the node.
class SettingReader {
 public:
  SettingReader(const Setting& setting, const Value::Table& fields, const std::filesystem::path& folder,
                const std::string& owner, ErrorList& errors)
      : setting_(setting),
        fields_(fields),
        folder_(folder),
        owner_(owner),
        errors_(errors),
        section_(section_of(setting)),
        reader_(fields, section_, errors, FieldReader::kKeysChecked, owner) {}

  SettingValue read(const Value& value) {
    using Kind = Setting::Kind;
    result_.given = true;
    if (setting_.kind == Kind::Choice) {
      if (const auto choice = reader_.choice(setting_.name)) result_.text = setting_.choices[index(*choice)];
    } else if (setting_.kind == Kind::Text || setting_.kind == Kind::File) {
      read_text(value);
    } else if (setting_.kind == Kind::Integer) {
      result_.number = reader_.number(setting_.name).value_or(0);
    } else if (setting_.kind == Kind::Flag) {
      result_.number = reader_.flag(setting_.name) ? 1 : 0;
    } else if (setting_.kind == Kind::Quantity) {
      read_quantity_within(value);
    } else {
      read_list(value);
    }
    return std::move(result_);
  }

 private:
  void report(Errc code, const Source& at, const std::string& what, const std::string& remedy) {
    errors_.add(code, at, key_of(setting_.name, owner_) + " " + what, remedy);
  }

  /// Of one axis of a table: fixed, that of another setting ("=unit"), or that of a port, which is not known
  /// here.
  std::optional<Unit> unit(std::size_t axis) const {
    const std::string text = axis < setting_.choices.size() ? setting_.choices[axis] : "";
    if (text.empty() || text.front() != '=') return parse_unit(text);
    const auto* named = find(fields_, text.substr(1));
    if (named == nullptr) return text == "=unit" ? std::optional{Unit{}} : std::nullopt;
    return text == "=unit" && named->text() != nullptr ? parse_unit(*named->text()) : std::nullopt;
  }

  void read_text(const Value& value) {
    result_.text = reader_.text(setting_.name);
    if (value.text() == nullptr) return;
    if (setting_.unit && !parse_unit(result_.text))
      report(Errc::UnknownName, value.at, "is not a unit: \"" + result_.text + "\"",
             "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"");
    if (setting_.kind != Setting::Kind::File) return;
    const auto found = find_part(result_.text, folder_, folder_, value.at);
    if (errors_.keep(found) != nullptr) result_.text = found->name;
  }

  void read_quantity_within(const Value& value) {
    const auto number = quantity(value, 0);
    if (!number) return;
    result_.number = *number;
    if (*number < setting_.low || *number > setting_.high)
      report(Errc::OutOfRange, value.at, "is out of range",
             limits_text(setting_.low, setting_.high, unit(0).value_or(Unit{})));
  }

  std::optional<double> quantity(const Value& value, std::size_t axis) {
    const auto expected = unit(axis);
    const auto si = expected ? read_quantity(value, *expected, setting_.name)
                             : read_quantity(value).map([](const QuantityValue& q) { return q.si; });
    return errors_.keep(si) != nullptr ? std::optional{*si} : std::nullopt;
  }

  void read_list(const Value& value) {
    const auto* list = value.list();
    if (list == nullptr || list->empty())
      return report(Errc::WrongType, value.at, "must be a non-empty list", "as in " + setting_.doc);
    for (const auto& item : *list) {
      if (setting_.kind == Setting::Kind::Names)
        read_name(item);
      else if (setting_.kind == Setting::Kind::Points)
        read_point(item);
      else if (const auto number = quantity(item, 0))
        result_.numbers.push_back(*number);
    }
  }

  void read_name(const Value& item) {
    if (item.text() != nullptr) return result_.names.push_back(*item.text());
    report(Errc::WrongType, item.at, "must be a list of node names", "write [\"node\", \"node\"]");
  }

  void read_point(const Value& item) {
    const auto* pair = item.list();
    if (pair == nullptr || pair->size() != 2)
      return report(Errc::WrongType, item.at, "must hold pairs", "write [[x, y], [x, y], …]");
    const auto x = quantity((*pair)[0], 0);
    const auto y = quantity((*pair)[1], 1);
    if (x && y) result_.points.emplace_back(*x, *y);
  }

  const Setting& setting_;
  const Value::Table& fields_;
  const std::filesystem::path& folder_;
  const std::string& owner_;  ///< "delay 'echo'"
  ErrorList& errors_;
  SectionType section_;
  FieldReader reader_;
  SettingValue result_;
};

SettingValue fallback_of(const Setting& setting) {
  SettingValue value;
  value.text = setting.fallback;
  if (setting.kind == Setting::Kind::Flag) value.number = setting.fallback == "true" ? 1 : 0;
  if (setting.kind == Setting::Kind::Integer) value.number = std::stod(setting.fallback);
  return value;
}

}  // namespace

SettingValue bind_setting(const Setting& setting, const Value::Table& fields,
                          const std::filesystem::path& folder, const std::string& owner, const Source& at,
                          ErrorList& errors) {
  if (const auto* value = find(fields, setting.name))
    return SettingReader{setting, fields, folder, owner, errors}.read(*value);
  if (!setting.fallback.empty()) return fallback_of(setting);
  if (!setting.optional)
    errors.add(Errc::Missing, at, owner + " lacks '" + setting.name + "'",
               "write " + setting.name + " = … (" + setting.doc + ")");
  return {};
}

}  // namespace tactus
