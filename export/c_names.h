#pragma once

// Thread: [control].

#include <set>
#include <string>
#include <string_view>

namespace tactus {

/// Text as a C identifier: "haptic drum" as "haptic_drum".
std::string c_identifier(std::string_view text);

/// It is no expression: a name, a number, a member.
inline bool is_one_word(std::string_view text) { return text.find_first_of(" (") == text.npos; }

/// `wanted`, or with a number behind it where it is in `names` or means something else to C or in the code
/// around variables. It joins `names`.
std::string unique_name(const std::string& wanted, std::set<std::string>& names);

}  // namespace tactus
