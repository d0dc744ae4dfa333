#pragma once

// Thread: [any].

#include <span>
#include <string>
#include <string_view>

namespace tactus {

/// What other programs (Pure Data, Max, SuperCollider, Faust, Csound, synthesizers) call a node, and what
/// does it here.
struct OtherName {
  std::string_view name;
  std::string_view types;   ///< node types, separated by spaces
  std::string_view remedy;  ///< how to write it; empty: the type alone says it
};

std::span<const OtherName> other_names();

/// "use sine: …", for a name of the table, also with a '~' or a '.ar' behind it; else "".
std::string other_name(std::string_view name);

}  // namespace tactus
