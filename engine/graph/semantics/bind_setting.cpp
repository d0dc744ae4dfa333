#include <algorithm>
#include <cmath>

#include "engine/graph/file/nearest.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/semantics/bind.h"
#include "engine/graph/semantics/part_path.h"

namespace tactus {
namespace {

/// Reads one setting of one node; its errors have the place and the name of the node.
struct Reader {
  const Setting& setting;
  const Value::Table& fields;
  const std::filesystem::path& folder;
  std::string owner;  ///< "delay 'echo'"
  Mistakes& mistakes;

  SettingValue result{};

  void complain(Errc code, const Source& at, const std::string& what, const std::string& remedy) {
    mistakes.add(Error{code, at.text(), "'" + setting.name + "' of " + owner + " " + what, remedy});
  }

  std::string choices() const {
    std::string text;
    for (const auto& choice : setting.choices) text += (text.empty() ? "\"" : ", \"") + choice + "\"";
    return text;
  }

  /// Of one axis of a table: fixed, that of another setting ("=unit"), or that of a port, which nobody knows
  /// here.
  std::optional<Unit> unit(std::size_t axis) const {
    const std::string text = axis < setting.choices.size() ? setting.choices[axis] : "";
    if (text.empty() || text.front() != '=') return parse_unit(text);
    const auto* named = find(fields, text.substr(1));
    if (named == nullptr) return text == "=unit" ? std::optional{Unit{}} : std::nullopt;
    return text == "=unit" && named->text() != nullptr ? parse_unit(*named->text()) : std::nullopt;
  }

  void read_text(const Value& value) {
    const auto* text = value.text();
    if (text == nullptr)
      return complain(Errc::WrongType, value.at, "must be a string, not " + value.kind(),
                      setting.choices.empty() ? "write it in quotes" : "choose one of " + choices());
    if (setting.kind == Setting::Kind::Choice &&
        std::find(setting.choices.begin(), setting.choices.end(), *text) == setting.choices.end()) {
      const auto near = nearest_name(*text, setting.choices);
      return complain(Errc::UnknownName, value.at, "cannot be \"" + *text + "\"",
                      near.empty() ? "choose one of " + choices() : "did you mean \"" + near + "\"?");
    }
    if (setting.unit && !parse_unit(*text))
      return complain(Errc::UnknownName, value.at, "is no unit: \"" + *text + "\"",
                      "write units as \"m/s\", \"N/m\", \"ms\", \"dB\" or \"full scale\"");
    result.text = *text;
    if (setting.kind == Setting::Kind::File) read_path(*text, value.at);
  }

  void read_path(const std::string& text, const Source& at) {
    const auto found = find_part(text, folder, folder, at);
    if (mistakes.keep(found) != nullptr) result.text = found->name;
  }

  void read_number(const Value& value) {
    if (setting.kind == Setting::Kind::Flag) {
      const auto* flag = value.flag();
      if (flag == nullptr)
        return complain(Errc::WrongType, value.at, "must be true or false, not " + value.kind(),
                        "write " + setting.name + " = true");
      result.number = *flag ? 1 : 0;
      return;
    }
    const auto* number = value.number();
    if (number == nullptr || std::floor(*number) != *number)
      return complain(Errc::WrongType, value.at,
                      "must be a whole number" + (number == nullptr ? ", not " + value.kind() : ""),
                      number == nullptr ? "write it without quotes or brackets" : "give one without a point");
    result.number = *number;
    if (*number < setting.low || *number > setting.high)
      complain(Errc::OutOfRange, value.at, "is out of range",
               "choose between " + short_number(setting.low) + " and " + short_number(setting.high));
  }

  void read_quantity_within(const Value& value) {
    const auto number = quantity(value, 0);
    if (!number) return;
    result.number = *number;
    const auto text = [&](double si) { return short_quantity(si, unit(0).value_or(Unit{}).dimension); };
    if (result.number < setting.low || result.number > setting.high)
      complain(Errc::OutOfRange, value.at, "is out of range",
               "choose between " + text(setting.low) + " and " + text(setting.high));
  }

  std::optional<double> quantity(const Value& value, std::size_t axis) {
    const auto expected = unit(axis);
    const auto si = expected ? read_quantity(value, *expected, setting.name)
                             : read_quantity(value).map([](const QuantityValue& q) { return q.si; });
    if (si) return *si;
    mistakes.add(si.error());
    return std::nullopt;
  }

  void read_list(const Value& value) {
    const auto* list = value.list();
    if (list == nullptr || list->empty())
      return complain(Errc::WrongType, value.at, "must be a list that is not empty", "as in " + setting.doc);
    for (const auto& item : *list) {
      if (setting.kind == Setting::Kind::Names)
        read_name(item);
      else if (setting.kind == Setting::Kind::Points)
        read_point(item);
      else if (const auto number = quantity(item, 0))
        result.numbers.push_back(*number);
    }
  }

  void read_name(const Value& item) {
    if (item.text() != nullptr) return result.names.push_back(*item.text());
    complain(Errc::WrongType, item.at, "must hold names of nodes", "write [\"node\", \"node\"]");
  }

  void read_point(const Value& item) {
    const auto* pair = item.list();
    if (pair == nullptr || pair->size() != 2)
      return complain(Errc::WrongType, item.at, "must hold pairs", "write [[x, y], [x, y], …]");
    const auto x = quantity((*pair)[0], 0);
    const auto y = quantity((*pair)[1], 1);
    if (x && y) result.points.emplace_back(*x, *y);
  }

  void read(const Value& value) {
    result.given = true;
    switch (setting.kind) {
      case Setting::Kind::Choice:
      case Setting::Kind::Text:
      case Setting::Kind::File:
        return read_text(value);
      case Setting::Kind::Integer:
      case Setting::Kind::Flag:
        return read_number(value);
      case Setting::Kind::Quantity:
        return read_quantity_within(value);
      case Setting::Kind::Points:
      case Setting::Kind::Numbers:
      case Setting::Kind::Names:
        return read_list(value);
    }
  }

  void read_fallback() {
    result.text = setting.fallback;
    if (setting.kind == Setting::Kind::Flag) result.number = setting.fallback == "true" ? 1 : 0;
    if (setting.kind == Setting::Kind::Integer) result.number = std::stod(setting.fallback);
  }
};

}  // namespace

SettingValue bind_setting(const Setting& setting, const Value::Table& fields,
                          const std::filesystem::path& folder, const std::string& owner, const Source& at,
                          Mistakes& mistakes) {
  Reader reader{setting, fields, folder, owner, mistakes};
  const auto* value = find(fields, setting.name);
  if (value != nullptr) {
    reader.read(*value);
  } else if (!setting.fallback.empty()) {
    reader.read_fallback();
  } else if (!setting.optional) {
    mistakes.add(Error{Errc::Missing, at.text(), owner + " lacks '" + setting.name + "'",
                       "write " + setting.name + " = … (" + setting.doc + ")"});
  }
  return reader.result;
}

}  // namespace tactus
