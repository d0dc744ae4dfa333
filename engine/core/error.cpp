#include "engine/core/error.h"

#include <utility>

namespace tactus {
namespace {

/// A file can put any character into a name: none of them may reach a terminal as a command, or look like a
/// line of ours.
std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c < 0x20 || c == 0x7f) text[i] = '?';
    // U+0080 to U+009F are commands, too, in two bytes of UTF-8.
    if (c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0)
      text.replace(i, 2, "?");
  }
  return text;
}

}  // namespace

std::string to_string(const Error& error) {
  std::string text = error.where;
  if (!text.empty()) text += ": ";
  text += error.what;
  if (!error.remedy.empty()) text += "; " + error.remedy;
  return printable(std::move(text));
}

std::string to_string(const std::vector<Error>& errors) {
  std::string text;
  for (const auto& error : errors) text += (text.empty() ? "" : "\n") + to_string(error);
  return text;
}

}  // namespace tactus
