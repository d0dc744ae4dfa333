#include "export/networks/network_text.h"

#include <algorithm>
#include <stdexcept>

#include "export/kernel_texts.h"

namespace tactus {
namespace {

std::vector<std::string> pieces_of(std::string_view text, std::string_view at) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0;;) {
    const auto end = text.find(at, begin);
    parts.emplace_back(text.substr(begin, end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + at.size();
  }
}

std::string stripped(const std::string& text) {
  const auto first = text.find_first_not_of(" \n");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \n") + 1 - first);
}

bool condition_holds(const std::string& condition, const NetworkFlags& flags) {
  return std::ranges::any_of(pieces_of(condition, "||"), [&](const std::string& all) {
    return std::ranges::all_of(pieces_of(all, "&&"), [&](const std::string& one) {
      const auto term = stripped(one);
      const bool negative = term.starts_with("!");
      const auto flag = flags.find(negative ? term.substr(1) : term);
      if (flag == flags.end()) throw std::logic_error("a network has no '" + term + "'");
      return flag->second != negative;
    });
  });
}

void take_function(const std::vector<KernelItem>& items, const std::string& name,
                   std::set<std::string>& taken, std::vector<std::string>& order) {
  const auto item =
      std::ranges::find_if(items, [&](const KernelItem& one) { return one.names.front() == name; });
  if (item == items.end() || !taken.insert(name).second) return;
  for (const auto& used : item->uses) take_function(items, used, taken, order);
  order.push_back(item->text);
}

/// How often a text mentions an identifier outside its comments.
std::ptrdiff_t times_mentioned(const std::string& text, std::string_view name) {
  std::ptrdiff_t count = 0;
  for_code_and_comments(
      text,
      [&](std::string_view code) {
        for_each_identifier(code, [&](std::string_view word) { count += word == name ? 1 : 0; });
      },
      [](std::string_view) {});
  return count;
}

/// Of "const int count = 3;" alone in its line the name; "": the line is something else.
std::string constant_of(const std::string& line) {
  const auto text = stripped(line);
  const bool constant = text.starts_with("const int ") || text.starts_with("const tactus_real ");
  int depth = 0;
  const bool several = std::ranges::any_of(text, [&](char c) {
    depth += c == '(' || c == '[' ? 1 : c == ')' || c == ']' ? -1 : 0;
    return depth == 0 && c == ',';
  });
  const auto end = text.find(" = ");
  if (!constant || several || !text.ends_with(";") || end == std::string::npos) return {};
  const auto begin = text.rfind(' ', end - 1) + 1;
  return text.substr(begin, end - begin);
}

}  // namespace

std::string_view network_file(std::string_view name) {
  for (const auto& file : network_files())
    if (file.name.ends_with(name)) return file.bytes;
  throw std::logic_error("there is no file " + std::string{name});
}

std::string chosen_lines(std::string_view text, const NetworkFlags& flags) {
  std::string result;
  std::vector<bool> on;
  for (const auto& line : pieces_of(text, "\n")) {
    if (line.starts_with("#if "))
      on.push_back(condition_holds(line.substr(4), flags));
    else if (line == "#else")
      on.back() = !on.back();
    else if (line == "#endif")
      on.pop_back();
    else if (std::ranges::find(on, false) == on.end())
      result += line + "\n";
  }
  return result;
}

std::string renamed(std::string_view text, const std::map<std::string, std::string>& beginnings) {
  std::string result;
  for_each_name(
      text,
      [&](const std::string& name, std::size_t end) {
        const auto found = std::ranges::find_if(
            beginnings, [&](const auto& beginning) { return name.starts_with(beginning.first); });
        result += found == beginnings.end() ? name : found->second + name.substr(found->first.size());
        return end;
      },
      [&](char c) { result += c; });
  return result;
}

std::vector<std::string> needed_functions(const std::string& text, const std::set<std::string>& wanted) {
  const auto items = kernel_items({"", text});
  std::set<std::string> taken;
  std::vector<std::string> order;
  for (const auto& name : wanted) take_function(items, name, taken, order);
  return order;
}

std::string without_unused_names(std::string function) {
  for (auto lines = pieces_of(function, "\n"); true; lines = pieces_of(function, "\n")) {
    const auto unused = std::ranges::find_if(lines, [&](const std::string& line) {
      const auto name = constant_of(line);
      return !name.empty() && times_mentioned(function, name) == 1;
    });
    if (unused == lines.end()) break;
    lines.erase(unused);
    function.clear();
    for (const auto& line : lines) function += (function.empty() ? "" : "\n") + line;
  }
  const auto begin = function.find("static inline"), brace = function.find(") {", begin);
  const auto open = function.find('(', begin);
  std::string unused;
  for (const auto& parameter : pieces_of(function.substr(open + 1, brace - open - 1), ",")) {
    std::string name;
    for_each_identifier(parameter, [&](std::string_view word) { name = word; });
    if (name != "void" && times_mentioned(function.substr(brace), name) == 0)
      unused += "\n  (void)" + name + ";";
  }
  return function.insert(brace + 3, unused);
}

}  // namespace tactus
