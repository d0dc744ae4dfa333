#include "apps/cli/warnings.h"

#include "apps/cli/console.h"

namespace tactus::app {

std::string text_of_warning(const Error& warning) { return "warning: " + to_string(warning); }

std::string text_of_warnings(const Plan& plan) {
  std::string text;
  for (const auto& warning : plan.warnings) text += (text.empty() ? "" : "\n") + text_of_warning(warning);
  return text;
}

void print_warnings(const Plan& plan) {
  if (const auto text = text_of_warnings(plan); !text.empty()) print_note(text);
}

}  // namespace tactus::app
