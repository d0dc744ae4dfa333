#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/core/notes.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus {
namespace {

constexpr double kAudible_cents = 5;  // just noticeable
constexpr double kFormatNoteTold_s = kSteady_s;

std::string head_of(const ExpectedNote& expected) {
  if (expected.glides)
    return fmt::format("from {} to {} in {:.2f} s, {:.1f} to {:.1f} Hz: ", pitch_text(expected.begins_hz),
                       pitch_text(expected.ends_hz), expected.seconds(), expected.begins_hz,
                       expected.ends_hz);
  return fmt::format("{}, {:.1f} Hz: ", pitch_text(expected.hertz), expected.hertz);
}

/// What sounds, where that is not the note.
std::string other_pitch_of(const DetectedNote& note) {
  if (note.partial == 1 && std::abs(note.cents) <= kNearPartial_cents) return {};
  auto text = fmt::format("{:.1f} Hz sounds, ", note.detected_hz);
  if (note.partial > 1 && std::abs(note.cents) <= kNearPartial_cents)
    return text + fmt::format("partial {}, ", note.partial);
  return text + pitch_text(note.detected_hz) + ", ";
}

std::string describe_swing(const DetectedNote& note) {
  if (note.expected.glides || note.swing_cents <= kAudible_cents) return {};
  if (!note.vibrato_hz) return fmt::format(", varies by {:.0f}", note.swing_cents);
  auto text = fmt::format(", vibrato of {:.0f} cents, {:.1f} per second", note.swing_cents, *note.vibrato_hz);
  if (note.expected_swing_cents > kAudible_cents)
    text += fmt::format(" ({:.0f} expected)", note.expected_swing_cents);
  return text;
}

std::string elsewhere_of(const DetectedNote& note) {
  std::string text;
  if (note.partials_s >= kFormatNoteTold_s)
    text += fmt::format(", on partial {} for {:.2f} s", note.other_partial, note.partials_s);
  if (note.strays_s >= kFormatNoteTold_s)
    text += fmt::format(", on other pitches for {:.2f} s", note.strays_s);
  if (note.silent_s >= kFormatNoteTold_s)
    text += fmt::format(", without a pitch for {:.2f} s", note.silent_s);
  return text;
}

}  // namespace

std::string pitch_text(double hertz) {
  const double over = cents(hertz, pitch_of_note(nearest_note(hertz)));
  return note_name(hertz) + (std::abs(over) < kAudible_cents ? "" : fmt::format(" {:+.0f} cents", over));
}

std::string describe(const DetectedNote& note) {
  auto text = head_of(note.expected);
  if (note.detected_hz <= 0) return text + "no pitched sound";
  if (!note.right()) text += "not right: ";
  text += other_pitch_of(note) + fmt::format("{:+.1f} cents", note.cents) + describe_swing(note);
  if (note.speaks_after_s && !note.expected.glides)
    text += fmt::format(", steady after {:.2f} s", *note.speaks_after_s);
  return text + elsewhere_of(note);
}

std::string describe(const std::vector<DetectedNote>& notes) {
  int right[2] = {0, 0}, all[2] = {0, 0};  // notes, glides
  double off = 0, slowest = 0;
  for (const auto& note : notes) {
    const int kind = note.expected.glides ? 1 : 0;
    ++all[kind];
    if (!note.right()) continue;
    ++right[kind];
    off = std::max(off, std::abs(note.cents));
    if (!note.expected.glides) slowest = std::max(slowest, note.speaks_after_s.value_or(0));
  }
  auto text = fmt::format("{} of {} notes right", right[0], all[0]);
  if (all[1] > 0) text += fmt::format(" and {} of {} glides", right[1], all[1]);
  if (right[0] + right[1] > 0)
    text += fmt::format(", at most {:.1f} cents off, each steady within {:.2f} s", off, slowest);
  return text;
}

}  // namespace tactus
