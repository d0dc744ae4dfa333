#include "backends/comedi/comedi_settings.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <string_view>
#include <utility>

namespace tactus {
namespace {

template <class Value, std::size_t N>
bool set_named(const std::array<std::pair<const char*, Value>, N>& names, std::string_view text,
               Value& value) {
  for (const auto& [name, meaning] : names)
    if (text == name) return value = meaning, true;
  return false;
}

bool set_number(std::string_view text, int least, int most, std::optional<int>& value) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < least || number > most)
    return false;
  value = number;
  return true;
}

using Reference = ComediSettings::Reference;
using Wait = SystemTimer::Wait;
constexpr std::array<std::pair<const char*, Reference>, 4> kReferences{{{"ground", Reference::Ground},
                                                                        {"common", Reference::Common},
                                                                        {"diff", Reference::Differential},
                                                                        {"other", Reference::Other}}};
constexpr std::array<std::pair<const char*, Wait>, 2> kWaits{{{"timer", Wait::Timer}, {"busy", Wait::Busy}}};

struct Setting {
  const char* name;
  const char* values;
  bool (*set)(ComediSettings&, std::string_view);
};

constexpr std::array<Setting, 6> kSettings{
    {{"in_range", "0 to 99, the number of a range",
      [](ComediSettings& to, std::string_view text) { return set_number(text, 0, 99, to.in_range); }},
     {"out_range", "0 to 99, the number of a range",
      [](ComediSettings& to, std::string_view text) { return set_number(text, 0, 99, to.out_range); }},
     {"reference", "ground, common, diff or other",
      [](ComediSettings& to, std::string_view text) { return set_named(kReferences, text, to.reference); }},
     {"wait", "timer or busy",
      [](ComediSettings& to, std::string_view text) { return set_named(kWaits, text, to.pace.wait); }},
     {"core", "0 to 1023, a core of the processor",
      [](ComediSettings& to, std::string_view text) { return set_number(text, 0, 1023, to.pace.core); }},
     {"priority", "1 to 89, of SCHED_FIFO", [](ComediSettings& to, std::string_view text) {
        std::optional<int> value;
        const bool valid = set_number(text, 1, 89, value);
        if (valid) to.pace.priority = *value;
        return valid;
      }}}};

}  // namespace

Result<ComediSettings> comedi_settings(const std::string& text) {
  ComediSettings settings;
  std::string_view rest = text;
  const auto next = [&rest] {
    const auto part = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), part.size() + 1));
    return part;
  };
  settings.file = next();
  while (!rest.empty()) {
    const auto part = next();
    const auto equals = std::min(part.find('='), part.size());
    const auto name = part.substr(0, equals), value = part.substr(std::min(part.size(), equals + 1));
    std::string names;
    const Setting* found = nullptr;
    for (const auto& setting : kSettings) {
      names += (names.empty() ? "" : ", ") + std::string{setting.name};
      if (name == setting.name) found = &setting;
    }
    if (found == nullptr)
      return fail(Errc::BadArgument, "", fmt::format("'comedi:{}' has an unknown setting '{}'", text, name),
                  "settings are " + names + ", as in comedi:/dev/comedi0,core=3,wait=busy");
    if (!found->set(settings, value))
      return fail(Errc::BadArgument, "", fmt::format("'comedi:{}': {} cannot be '{}'", text, name, value),
                  fmt::format("{} is {}", name, found->values));
  }
  return settings;
}

}  // namespace tactus
