#pragma once

// Thread: [control].

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace tactus {

/// A name, a number, or any other character of a C statement.
struct CToken {
  enum class Kind { Name, Number, Other } kind;
  std::string text;

  bool operator==(const CToken&) const = default;
};
using CTokens = std::vector<CToken>;

CTokens tokens_of(std::string_view text);
std::string text_of(const CTokens& tokens);

/// Of a struct: it is no variable, whatever its name.
bool is_field(const CTokens& tokens, std::size_t token);
/// Of the state: "s->".
bool is_member(const CTokens& tokens, std::size_t token);
/// Whether they mention a variable of that name.
bool mentions_variable(const CTokens& tokens, const std::string& name);

}  // namespace tactus
