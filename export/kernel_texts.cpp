#include "export/kernel_texts.h"

#include <algorithm>
#include <map>

#include "engine/core/index.h"
#include "export/number.h"

namespace tactus {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \n") - first + 1);
}

std::string code_of(std::string_view text) {
  std::string code;
  for_code_and_comments(
      text, [&](std::string_view part) { code += part; }, [&](std::string_view) { code += ' '; });
  return code;
}

/// Where the comment or directive that begins at `at` ends.
std::size_t end_of_line(std::string_view text, std::size_t at) {
  auto end = text.find('\n', at);
  while (end != std::string_view::npos && text[end - 1] == '\\') end = text.find('\n', end + 1);
  return std::min(end, text.size());
}

/// Where the declaration that begins at `at` ends: a function with its brace, anything else with a semicolon.
std::size_t end_of_declaration(std::string_view text, std::size_t at) {
  const bool function = text.substr(at).starts_with("static inline");
  int depth = 0;
  for (; at < text.size(); ++at) {
    if (text.substr(at).starts_with("//")) at = end_of_line(text, at);
    if (text.substr(at).starts_with("/*")) at = text.find("*/", at) + 1;
    depth += text[at] == '{' ? 1 : text[at] == '}' ? -1 : 0;
    if (depth == 0 && (text[at] == ';' || (function && text[at] == '}'))) return at + 1;
  }
  return text.size();
}

std::string last_identifier(std::string_view code) {
  std::string last;
  for_each_identifier(code, [&](std::string_view name) { last = name; });
  return last;
}

/// The names that a declaration without comments gives.
std::vector<std::string> declared_names(std::string_view code) {
  if (code.starts_with("#define ")) {
    std::vector<std::string> all;
    for_each_identifier(code.substr(8), [&](std::string_view name) { all.emplace_back(name); });
    return {all.front()};
  }
  if (!code.starts_with("typedef ")) return {last_identifier(code.substr(0, code.find_first_of("([=")))};
  std::vector<std::string> names = {last_identifier(code)};
  if (!code.starts_with("typedef enum")) return names;
  const auto list = code.substr(code.find('{'), code.rfind('}') - code.find('{'));
  for_each_identifier(list, [&](std::string_view name) { names.emplace_back(name); });
  return names;
}

KernelItem item_of(const EmbeddedFile& file, std::string_view comment, std::string_view declaration) {
  const std::string code = code_of(declaration);
  const auto bare = trimmed(code);
  KernelItem item{file.name,
                  std::string{comment} + std::string{declaration},
                  std::string{bare},
                  declared_names(bare),
                  identifiers_of(declaration),
                  bare.starts_with("typedef") || bare.starts_with("#define")};
  return item;
}

const std::map<std::string, std::vector<KernelItem>>& all_items() {
  static const auto all = [] {
    std::map<std::string, std::vector<KernelItem>> items;
    for (const auto& file : kernel_files()) items[std::string{file.name}] = kernel_items(file);
    return items;
  }();
  return all;
}

using ItemsByName = std::map<std::string, const KernelItem*>;

ItemsByName items_by_name(const KernelChoice& choice) {
  ItemsByName by_name;
  const auto is_in = [](const std::string& path, const std::vector<std::string>& paths) {
    return std::ranges::find(paths, path) != paths.end();
  };
  for (const auto& [path, items] : all_items())
    if (!is_in(path, choice.instead) && !is_in(path, choice.without))
      for (const auto& item : items)
        for (const auto& name : item.names) by_name.emplace(name, &item);
  for (const auto& path : choice.instead)
    for (const auto& item : all_items().at(path))
      for (const auto& name : item.names) by_name[name] = &item;
  return by_name;
}

void take(const KernelItem& item, const ItemsByName& by_name, std::set<const KernelItem*>& taken,
          std::vector<KernelItem>& order) {
  if (!taken.insert(&item).second) return;
  for (const auto& name : item.uses)
    if (const auto found = by_name.find(name); found != by_name.end())
      take(*found->second, by_name, taken, order);
  order.push_back(item);
}

}  // namespace

std::set<std::string> identifiers_of(std::string_view text) {
  std::set<std::string> names;
  for_each_identifier(code_of(text), [&](std::string_view name) { names.emplace(name); });
  return names;
}

std::vector<KernelItem> kernel_items(const EmbeddedFile& file) {
  std::vector<KernelItem> items;
  std::string comment;
  const auto text = file.bytes;
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] == '\n' || text[at] == ' ') {
      ++at;
      continue;
    }
    const auto rest = text.substr(at);
    const bool block = rest.starts_with("/*"), is_comment = block || rest.starts_with("//"),
               directive = rest[0] == '#';
    const auto end = block                     ? text.find("*/", at) + 2
                     : is_comment || directive ? end_of_line(text, at)
                                               : end_of_declaration(text, at);
    const auto part = text.substr(at, end - at);
    at = end;
    if (part.starts_with("#pragma") || part.starts_with("#include") || part.starts_with("// Thread:") ||
        part.starts_with("// clang-format"))
      continue;
    if (is_comment) {
      comment += std::string{part} + "\n";
      // A comment on the whole file belongs to its first declaration.
      if (text.substr(at).starts_with("\n\n")) comment += "\n";
      continue;
    }
    items.push_back(item_of(file, comment, part));
    comment.clear();
  }
  return items;
}

std::vector<KernelItem> needed_kernel_items(const std::set<std::string>& identifiers,
                                            const KernelChoice& choice) {
  const auto by_name = items_by_name(choice);
  std::set<const KernelItem*> taken;
  std::vector<KernelItem> order;
  for (const auto& name : identifiers)
    if (const auto found = by_name.find(name); found != by_name.end())
      take(*found->second, by_name, taken, order);
  return order;
}

std::string kernel_array_entry(const std::string& name, int entry) {
  const auto by_name = items_by_name({});
  const auto& text = by_name.at(name)->text;
  auto at = text.find('{', text.find('=')) + 1;
  int depth = 0;
  for (std::size_t begin = at; at < text.size(); ++at) {
    if (text[at] == '{' && depth++ == 0) begin = at;
    if (text[at] == '}' && --depth == 0 && entry-- == 0) return text.substr(begin, at + 1 - begin);
  }
  return {};
}

}  // namespace tactus
