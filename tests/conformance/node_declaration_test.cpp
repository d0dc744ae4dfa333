#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>
#include <set>

#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"

using namespace tactus;

namespace {

bool is_name(const std::string& name) { return std::regex_match(name, std::regex("[a-z][a-z0-9_]*")); }

/// "ms", "any", or "=in", "=in/s", "=in s": the unit of a port, or one that a Text setting names, times a
/// unit.
bool is_port_unit(const NodeType& type, const std::string& unit) {
  if (unit == "any") return true;
  if (unit.empty() || unit.front() != '=') return parse_unit(unit).has_value();
  const auto end = std::min(unit.find_first_of(" */"), unit.size());
  const auto name = unit.substr(1, end - 1);
  const bool setting = std::any_of(type.settings.begin(), type.settings.end(), [&](const Setting& s) {
    return s.name == name && s.kind == Setting::Kind::Unit;
  });
  const bool known = type.input_index(name) >= 0 || setting;
  return known && (end == unit.size() || parse_unit("1" + unit.substr(end)).has_value());
}

void check_setting(const NodeType& type, const Setting& setting) {
  using Kind = Setting::Kind;
  INFO("setting " << setting.name);
  CHECK(is_name(setting.name));
  CHECK_FALSE(setting.doc.empty());
  if (setting.kind == Kind::Choice) {
    CHECK(setting.choices.size() >= 2);
    const bool named = std::count(setting.choices.begin(), setting.choices.end(), setting.fallback) == 1;
    CHECK((named || setting.fallback.empty()));
  }
  if (setting.kind == Kind::Points) CHECK(setting.choices.size() == 2);
  if (setting.kind == Kind::Numbers || setting.kind == Kind::Quantity) CHECK(setting.choices.size() <= 1);
  if (setting.kind != Kind::Choice)
    for (const auto& unit : setting.choices) CHECK(is_port_unit(type, unit));
  if (setting.kind == Kind::Integer && !setting.fallback.empty()) {
    const double fallback = test::setting_value(setting, setting.fallback).number;
    CHECK(fallback >= setting.low);
    CHECK(fallback <= setting.high);
  }
}

void check_input(const NodeType& type, const InputPort& port) {
  INFO("input " << port.name);
  CHECK(is_name(port.name));
  CHECK_FALSE(port.doc.empty());
  CHECK(is_port_unit(type, port.unit));
  CHECK(port.low <= port.high);
  CHECK(port.fallback.value_or(port.low) >= port.low);
  CHECK(port.fallback.value_or(port.high) <= port.high);
  CHECK_FALSE((port.late && port.fixed));
  // What must be given is shown.
  if (!port.fallback) CHECK(type.example.find(" " + port.name + " = ") != std::string::npos);
}

void check_output(const NodeType& type, const OutputPort& port) {
  INFO("output " << port.name);
  CHECK(is_name(port.name));
  CHECK_FALSE(port.doc.empty());
  CHECK(is_port_unit(type, port.unit));
  CHECK(port.range.low <= port.range.high);
  if (port.kind == OutputKind::Trigger) CHECK(parse_unit(port.unit).value_or(Unit{{1}}).dimension.plain());
}

}  // namespace

TEST_CASE("nodes: every declaration is complete", "[conformance]") {
  REQUIRE_FALSE(standard_nodes().types.empty());
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    CHECK(is_name(type->name));
    CHECK_FALSE(type->group.empty());
    CHECK_FALSE(type->summary.empty());
    CHECK_FALSE(type->equation.empty());
    CHECK_FALSE(type->source.empty());
    CHECK(type->example.find("type = \"" + type->name + "\"") != std::string::npos);
    CHECK(type->example.find('\n') == std::string::npos);
    CHECK_FALSE(type->outputs.empty());
    CHECK(type->make);
    for (const auto& port : type->inputs) check_input(*type, port);
    for (const auto& port : type->outputs) check_output(*type, port);
    for (const auto& setting : type->settings) check_setting(*type, setting);
  }
}

TEST_CASE("nodes: no name is given twice", "[conformance]") {
  std::set<std::string> types;
  for (const auto* type : standard_nodes().types) {
    INFO(type->name);
    CHECK(types.insert(type->name).second);
    // Inputs and settings share the fields of a table in the file.
    std::set<std::string> fields = {"type"};
    for (const auto& port : type->inputs) CHECK(fields.insert(port.name).second);
    for (const auto& setting : type->settings) CHECK(fields.insert(setting.name).second);
    std::set<std::string> outputs;
    for (const auto& port : type->outputs) CHECK(outputs.insert(port.name).second);
  }
}
