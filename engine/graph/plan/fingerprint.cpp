#include "engine/graph/plan/fingerprint.h"

namespace tactus {
namespace {

void add(Fingerprint& print, const SettingValue& setting) {
  print.add(setting.text).add(setting.number).add(std::uint64_t{setting.given});
  print.add(std::uint64_t{setting.points.size()});
  for (const auto& [x, y] : setting.points) print.add(x).add(y);
  print.add(std::uint64_t{setting.numbers.size()});
  for (const double number : setting.numbers) print.add(number);
  print.add(std::uint64_t{setting.names.size()});
  for (const auto& name : setting.names) print.add(name);
}

}  // namespace

std::uint64_t fingerprint(const NodeSetup& setup) {
  Fingerprint print;
  print.add(setup.type->name).add(setup.type->fingerprint).add(setup.sample_rate.value);
  print.add(static_cast<std::uint64_t>(setup.lane));
  for (const auto& setting : setup.settings) add(print, setting);
  for (std::size_t i = 0; i < setup.inputs.size(); ++i) {
    const auto& input = setup.inputs[i];
    if (!setup.type->inputs[i].fixed && !input.asked) continue;
    print.add(std::uint64_t{i}).add(input.range.low).add(input.range.high);
    print.add(std::uint64_t{input.constant.has_value()}).add(input.constant.value_or(0));
    print.add(std::uint64_t{input.connected});
  }
  return print.value();
}

}  // namespace tactus
