#include "export/nodes/node_writer.h"

#include <algorithm>

#include "export/c_names.h"

namespace tactus {
namespace {

std::string named(const std::string& name, const std::string& suffix) {
  return suffix.empty() ? name : name + "_" + suffix;
}

}  // namespace

std::string NodeWriter::variable(int input) {
  auto& value = inputs_[index(input)].value;
  if (is_one_word(value.text) || inputs_[index(input)].constant) return operand(input);
  value = {local("in", value.text)};
  return value.text;
}

std::string NodeWriter::local(const std::string& type, const std::string& suffix, const std::string& value) {
  auto name = make_name_(named(name_, suffix), false);
  step("const " + type + " " + name + " = " + value + ";");
  return name;
}

std::string NodeWriter::frame_variable(const std::string& type, const std::string& suffix,
                                       const std::string& value) {
  auto name = make_name_(named(name_, suffix), false);
  node_.variables.push_back(type + " " + name + " = " + value + ";");
  return name;
}

std::string NodeWriter::add_member(const std::string& type, const std::string& suffix, int count,
                                   std::size_t bytes) {
  const auto name = make_name_(named(name_, suffix), true);
  const auto size = count > 0 ? "[" + std::to_string(count) + "]" : std::string{};
  node_.members.push_back({type + " " + name + size, {}, bytes * index(std::max(1, count))});
  return "s->" + name;
}

std::string NodeWriter::table(const std::string& type, const std::string& suffix, const std::string& text,
                              std::size_t bytes) {
  const auto name = make_name_("tactus_data_" + named(name_, suffix), false);
  node_.tables.push_back("static const " + type + " " + name + (text.starts_with("[]") ? "[] = " : " = ") +
                         (text.starts_with("[]") ? text.substr(2) : text) + ";");
  node_.table_bytes += bytes;
  return name;
}

std::string NodeWriter::table(const std::string& suffix, const std::vector<double>& values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(number(value));
  return table("tactus_real", suffix, "[]" + c_list(texts, 6), 8 * values.size());
}

std::string NodeWriter::function_name(const std::string& suffix) {
  return make_name_("tactus_node_" + named(name_, suffix), false);
}

void NodeWriter::design(const std::vector<int>& inputs, const WithInputs& statement) {
  const bool of_controls =
      divisor_ == 1 && std::ranges::all_of(inputs, [&](int input) { return pace(input) != Pace::Frame; });
  if (!of_controls) return when_changed(inputs, statement, position() + " == 0 && ");
  // The program looks at the place in the group.
  const auto steps = node_.step.size();
  when_changed(inputs, statement);
  std::move(node_.step.begin() + static_cast<std::ptrdiff_t>(steps), node_.step.end(),
            std::back_inserter(node_.design));
  node_.step.resize(steps);
}

void NodeWriter::when_changed(const std::vector<int>& inputs, const WithInputs& statement,
                              const std::string& condition) {
  std::vector<int> moving;
  for (const int input : inputs)
    if (pace(input) != Pace::Constant) moving.push_back(input);
  std::vector<std::string> names;
  if (moving.empty()) {
    for (const int input : inputs) names.push_back(in(input));
    return start(statement(names));
  }
  const auto at = state<double>("tactus_real", "at", static_cast<int>(moving.size()));
  std::string changed;
  for (const int input : inputs) {
    const auto found = std::ranges::find(moving, input);
    if (found == moving.end()) {
      names.push_back(in(input));
      continue;
    }
    names.push_back(at + "[" + std::to_string(found - moving.begin()) + "]");
    start(names.back() + " = NAN;");
    changed += (changed.empty() ? "" : " | ") + ("tactus_changed(&" + names.back() + ", " + in(input) + ")");
  }
  const bool bracketed = moving.size() > 1 && !condition.empty();
  step("if (" + condition + (bracketed ? "(" + changed + ")" : changed) + ")\n  " + statement(names));
}

}  // namespace tactus
