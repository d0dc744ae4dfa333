#include "engine/core/error.h"

#include <utility>

#include "engine/core/printable.h"

namespace tactus {
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
