#include "apps/play/live/controls/midi_notes.h"

#include <algorithm>

namespace tactus::app {

void MidiNotes::set(MidiRole role, double value, std::int64_t frame) {
  for (const auto& follower : followers_)
    if (follower.role == role)
      waiting_.push_back({frame, JournalEntry::Kind::ControlSet, follower.index,
                          std::clamp(value, follower.range.low, follower.range.high)});
}

void MidiNotes::play(const MidiMessage& message, std::int64_t earliest) {
  const bool starts = message.kind == MidiMessage::Kind::NoteOn;
  if (!any() || (!starts && message.kind != MidiMessage::Kind::NoteOff)) return;
  constexpr double kLoudest = 127;
  const auto trigger = starts ? MidiRole::NoteOn : MidiRole::NoteOff;
  const std::int64_t frame = std::max(earliest, next_);
  set(MidiRole::Note, message.number, frame);
  if (starts) set(MidiRole::Velocity, message.value / kLoudest, frame);
  set(trigger, 1, frame);
  set(trigger, 0, frame + 1);
  next_ = frame + 2;
}

void MidiNotes::flush(const std::function<bool(const JournalEntry&)>& post) {
  while (!waiting_.empty() && post(waiting_.front())) waiting_.pop_front();
}

void MidiNotes::restart() {
  waiting_.clear();
  next_ = 0;
}

}  // namespace tactus::app
