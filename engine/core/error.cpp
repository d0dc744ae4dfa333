#include "engine/core/error.h"

#include <algorithm>
#include <utility>

namespace tactus {
namespace {

/// A file can put any character into a name: none of them may reach a terminal as a command, or look like a
/// line of ours.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
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
  for (const auto& error : errors) {
    if (!text.empty()) text += '\n';
    text += to_string(error);
  }
  return text;
}

}  // namespace tactus
