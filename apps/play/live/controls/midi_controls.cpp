#include "apps/play/live/controls/midi_controls.h"

#include <fmt/format.h>

#include "apps/cli/backends.h"

namespace tactus::app {
namespace {

std::string source_text(const RigMidi& binding) {
  switch (binding.kind) {
    case RigMidi::Kind::Note:
      return fmt::format("note {}", binding.number);
    case RigMidi::Kind::PitchBend:
      return "the pitch wheel";
    case RigMidi::Kind::Controller:
      break;
  }
  return fmt::format("controller {}", binding.number);
}

}  // namespace

MidiControls::MidiControls(std::string api, std::vector<RigMidi> bindings, LiveControls& controls)
    : api_(std::move(api)), controls_(controls), map_(std::move(bindings)) {
  if (!map_.bindings().empty() || !api_.empty()) (void)open();
}

bool MidiControls::open() {
  if (inputs_ == nullptr) inputs_ = make_midi_inputs(api_);
  return inputs_ != nullptr;
}

bool MidiControls::learn(const std::string& control) {
  if (!open()) return false;
  map_.learn(control);
  return true;
}

std::vector<std::string> MidiControls::tick() {
  if (inputs_ == nullptr) return {};
  auto words = inputs_->news();
  for (const auto& event : inputs_->poll()) {
    for (const auto& move : map_.hear(event)) (void)controls_.turn(move.control, move.place);
    if (const auto learnt = map_.take_learnt())
      words.push_back(fmt::format("{} of {} moves {}; s saves it in the rig", source_text(*learnt),
                                  event.port, learnt->control));
  }
  return words;
}

}  // namespace tactus::app
