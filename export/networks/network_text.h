#pragma once

// Thread: [control].

#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/embedded_file.h"
#include "export/number.h"

namespace tactus {

/// The C text of networks, by their paths in the source tree: functions of which parts stand between "#if",
/// "#else" and "#endif" lines, for what a network has. What begins with `net_` or `NET_` is a name that each
/// network replaces by its own.
std::span<const EmbeddedFile> network_files();
/// The one of that name.
std::string_view network_file(std::string_view name);

/// What a network has.
using NetworkFlags = std::map<std::string, bool, std::less<>>;

/// The lines whose conditions hold. Conditions are flags with "!", "&&" and "||", without brackets.
std::string chosen_lines(std::string_view text, const NetworkFlags& flags);

/// Calls `name(name, end)`, which gives where to go on, for each identifier and number, and `other` for each
/// character between them.
template <class Name, class Other>
void for_each_name(std::string_view text, Name name, Other other) {
  for (std::size_t at = 0; at < text.size();) {
    if (!is_identifier_part(text[at])) {
      other(text[at++]);
      continue;
    }
    auto end = at;
    while (end < text.size() && is_identifier_part(text[end])) ++end;
    at = name(std::string{text.substr(at, end - at)}, end);
  }
}

/// Names that begin so, with another beginning: "net_link_k" as "net_jump_k" by {"net_link", "net_jump"}.
std::string renamed(std::string_view text, const std::map<std::string, std::string>& beginnings);

/// The functions of a text that `wanted` names or that these need, each behind those that it uses.
std::vector<std::string> needed_functions(const std::string& text, const std::set<std::string>& wanted);

/// A function that says so of parameters that it does not use, and without constants that it does not use.
std::string without_unused_names(std::string function);

}  // namespace tactus
