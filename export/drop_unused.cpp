#include "export/drop_unused.h"

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "export/number.h"

namespace tactus {
namespace {

/// The variable that a statement begins with declaring; "": none.
std::string declared_variable(const std::string& statement) {
  const std::string constant = "const tactus_real ";
  if (!statement.starts_with(constant)) return {};
  return statement.substr(constant.size(), statement.find(' ', constant.size()) - constant.size());
}

}  // namespace

void drop_unused(CProgram& program) {
  std::map<std::string, int> mentions;
  const auto count = [&](const std::string& text) {
    for_each_identifier(text, [&](std::string_view name) { ++mentions[std::string{name}]; });
  };
  for (const auto& statement : program.frame) count(statement.text);
  for (const auto& value : program.checked) count(value);
  for (auto& statement : program.frame)
    if (const auto name = declared_variable(statement.text); !name.empty() && mentions[name] < 2)
      statement.text =
          statement.text.find("&s->") == std::string::npos ? "" : statement.text + "\n(void)" + name + ";";
  std::erase_if(program.frame, [](const Statement& statement) { return statement.text.empty(); });
}

}  // namespace tactus
