#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/core/median.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/measures/notes/pitch_track.h"

namespace tactus {
namespace {

constexpr double kStep_cents = 5;      // a gesture that slides takes less than 1 from frame to frame
constexpr double kStill_cents = 0.05;  // from one moment to the next
constexpr double kGlide_cents = 50;
constexpr double kSwing_cents = 300, kSwing_s = 0.25;
constexpr double kShortestNote_s = 0.05, kShortestGlide_s = 0.1;

bool jumps(double before, double now) {
  return !(before > 0 && now > 0) || std::abs(cents(now, before)) > kStep_cents;
}

/// Moments between which a pitch rises, falls or stays.
struct Run {
  std::size_t from, to;
  double change = 0;  // [cents]; 0: it stays

  double seconds() const { return static_cast<double>(to - from) * kPitchHop_s; }
};

int sign_of(double change) { return std::abs(change) < kStill_cents ? 0 : change > 0 ? 1 : -1; }

std::vector<Run> runs_of(const std::vector<double>& pitch) {
  std::vector<Run> runs;
  int before = 0;
  for (std::size_t i = 0; i + 1 < pitch.size(); ++i) {
    const double change = cents(pitch[i + 1], pitch[i]);
    const int sign = sign_of(change);
    if (runs.empty() || sign != before) runs.push_back({i, i});
    before = sign;
    runs.back().to = i + 1;
    if (sign != 0) runs.back().change += change;
  }
  return runs;
}

bool swings_with(const Run& run, const Run& other) {
  const double size = std::abs(run.change);
  return run.change * other.change < 0 && std::abs(other.change) > 0.5 * size && size <= kSwing_cents &&
         run.seconds() <= kSwing_s;
}

bool is_glide(const std::vector<Run>& runs, std::size_t i) {
  if (std::abs(runs[i].change) <= kGlide_cents) return false;
  const auto neighbour = [&](std::ptrdiff_t step) -> const Run* {
    // A swing may rest for a moment where it turns around.
    for (auto n = static_cast<std::ptrdiff_t>(i) + step; n >= 0 && n < std::ssize(runs); n += step) {
      const auto& run = runs[static_cast<std::size_t>(n)];
      if (run.change != 0 || run.seconds() > kShortestNote_s) return &run;
    }
    return nullptr;
  };
  const auto *before = neighbour(-1), *after = neighbour(1);
  return !(before != nullptr && swings_with(runs[i], *before)) &&
         !(after != nullptr && swings_with(runs[i], *after));
}

ExpectedNote note_of(std::span<const double> expected, Hertz rate, std::size_t from, std::size_t to,
                     bool glides) {
  ExpectedNote note;
  note.from_s = static_cast<double>(from) / rate.value;
  note.to_s = static_cast<double>(to) / rate.value;
  const auto part = expected.subspan(from, to - from);
  note.begins_hz = part.front();
  note.ends_hz = part.back();
  note.hertz = median({part.begin(), part.end()});
  note.glides = glides;
  return note;
}

/// Frames without a jump: their notes and the glides between them.
void add_notes(std::vector<ExpectedNote>& notes, std::span<const double> expected, Hertz rate,
               std::size_t from, std::size_t to) {
  const auto hop = static_cast<std::size_t>(std::lround(kPitchHop_s * rate.value));
  std::vector<double> pitch;
  for (auto i = from; i < to; i += hop) pitch.push_back(expected[i]);
  const auto runs = runs_of(pitch);
  const auto add = [&](std::size_t first, std::size_t last, bool glides) {
    if (static_cast<double>(last - first) >= (glides ? kShortestGlide_s : kShortestNote_s) * rate.value)
      notes.push_back(note_of(expected, rate, first, last, glides));
  };
  auto begun = from;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!is_glide(runs, i)) continue;
    const auto first = from + runs[i].from * hop, last = std::min(to, from + runs[i].to * hop);
    add(begun, first, false);
    add(first, last, true);
    begun = last;
  }
  add(begun, to, false);
}

}  // namespace

std::vector<ExpectedNote> expected_notes(std::span<const double> expected, Hertz rate) {
  std::vector<ExpectedNote> notes;
  for (std::size_t from = 0, to = 0; from < expected.size(); from = to) {
    to = from + 1;
    while (to < expected.size() && !jumps(expected[to - 1], expected[to])) ++to;
    if (expected[from] > 0) add_notes(notes, expected, rate, from, to);
  }
  return notes;
}

}  // namespace tactus
