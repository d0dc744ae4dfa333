#include "export/c_names.h"

#include <algorithm>
#include <array>

#include "export/number.h"

namespace tactus {
namespace {

/// What variables cannot be called: words of C, functions of math.h, and names of the code around them.
constexpr auto kTaken = std::to_array<std::string_view>(
    {"auto",         "break",  "case",   "char",     "const",    "continue", "default",  "do",
     "double",       "else",   "enum",   "extern",   "float",    "for",      "goto",     "if",
     "inline",       "int",    "long",   "register", "restrict", "return",   "short",    "signed",
     "sizeof",       "static", "struct", "switch",   "typedef",  "union",    "unsigned", "void",
     "volatile",     "while",  "self",   "in",       "out",      "s",        "c",        "group_position",
     "frame_number", "check",  "moved",  "open",     "k",        "lane",     "main",     "sin",
     "cos",          "tan",    "exp",    "log",      "pow",      "sqrt",     "floor",    "ceil",
     "round",        "rint",   "fabs",   "asin",     "acos",     "atan",     "tanh",     "log2",
     "log10",        "gamma",  "j0",     "j1",       "y0",       "y1",       "yn",       "jn",
     "signgam",      "index",  "abs",    "bool",     "true",     "false",    "asm",      "typeof",
     "complex",      "I",      "NAN",    "INFINITY", "HUGE_VAL", "errno",    "linux",    "unix",
     "NULL",         "EOF",    "near_"});

}  // namespace

std::string c_identifier(std::string_view text) {
  std::string name;
  for (const char c : text) {
    if (is_identifier_part(c))
      name += c;
    else if (!name.empty() && name.back() != '_')
      name += '_';
  }
  while (!name.empty() && name.back() == '_') name.pop_back();
  if (name.empty() || !is_identifier_start(name.front())) name = "_" + name;
  return name.front() == '_' ? "x" + name : name;
}

std::string unique_name(const std::string& wanted, std::set<std::string>& names) {
  auto name = wanted;
  const auto is_taken = [&] {
    return names.contains(name) || std::ranges::find(kTaken, name) != kTaken.end();
  };
  for (int i = 2; is_taken(); ++i) name = wanted + "_" + std::to_string(i);
  names.insert(name);
  return name;
}

}  // namespace tactus
