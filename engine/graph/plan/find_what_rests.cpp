#include "engine/graph/plan/find_what_rests.h"

#include <map>
#include <set>

namespace tactus {
namespace {

void find_operations(Schedule& schedule) {
  std::set<const double*> found;
  const auto rests = [&](const Signal& signal) { return signal.constant() || found.contains(signal.data); };
  for (auto& operation : schedule.operations) {
    const Signal* in = schedule.inputs.data() + operation.first_in;
    if (!rests(in[0]) || !rests(in[1])) continue;
    operation.can_rest = static_cast<int>(schedule.can_rest.size());
    found.insert(operation.out);
    schedule.can_rest.emplace_back();
  }
}

void find_readers(Schedule& schedule) {
  std::map<const double*, Readers*> readers;
  for (auto& control : schedule.controls)
    if (control.buffer != nullptr) readers.emplace(control.buffer, &control.readers);
  for (const auto& operation : schedule.operations)
    if (operation.can_rest >= 0)
      readers.emplace(operation.out, &schedule.can_rest[static_cast<std::size_t>(operation.can_rest)]);
  const auto readers_of = [&](const Signal& signal) {
    const auto found = readers.find(signal.data);
    return found == readers.end() ? nullptr : found->second;
  };
  for (std::size_t slot = 0; slot < schedule.inputs.size(); ++slot)
    if (auto* of = readers_of(schedule.inputs[slot])) of->slots.push_back(static_cast<int>(slot));
  for (std::size_t channel = 0; channel < schedule.channels.size(); ++channel)
    if (auto* of = readers_of(schedule.channels[channel].signal))
      of->channels.push_back(static_cast<int>(channel));
}

}  // namespace

void find_what_rests(Schedule& schedule) {
  find_operations(schedule);
  find_readers(schedule);
}

}  // namespace tactus
