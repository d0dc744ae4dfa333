#include "engine/analysis/pitch_track.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace tactus;

namespace {

constexpr Hertz kRate{48000};

/// A sine whose frequency follows `hertz`, silent where that is 0.
std::vector<double> sung(const std::vector<double>& hertz) {
  std::vector<double> x(hertz.size());
  double turns = 0;
  for (std::size_t n = 0; n < x.size(); ++n) {
    x[n] = hertz[n] > 0 ? std::sin(2 * std::numbers::pi * turns) : 0.0;
    turns += hertz[n] / kRate.value;
  }
  return x;
}

std::vector<double> steps(const std::vector<double>& hertz, double seconds) {
  std::vector<double> all;
  for (const double one : hertz) all.insert(all.end(), static_cast<std::size_t>(seconds * kRate.value), one);
  return all;
}

std::vector<NoteHeard> heard(const std::vector<double>& played, const std::vector<double>& wanted) {
  return notes_heard(track_pitch(sung(played), kRate, 50_Hz, 1500_Hz), wanted, kRate);
}

}  // namespace

TEST_CASE("notes_heard: each wanted note with its cents and partial", "[analysis]") {
  const double up = std::exp2(7.0 / 1200);
  const auto notes = heard(steps({110, 220 * up, 3 * 165, 0}, 0.5), steps({110, 220, 165, 330}, 0.5));
  REQUIRE(notes.size() == 4);
  CHECK(notes[0].partial == 1);
  CHECK(notes[0].cents == Approx(0).margin(0.1));
  CHECK(notes[1].partial == 1);
  CHECK(notes[1].cents == Approx(7).epsilon(0).margin(0.1));
  CHECK(notes[2].partial == 3);
  CHECK(notes[2].cents == Approx(0).margin(0.1));
  CHECK(notes[3].heard_hz == 0);
  CHECK(notes[3].from_s == Approx(1.5));
  CHECK(in_words(notes[3]) == "E4, 330.0 Hz: nothing with a pitch");
  CHECK(in_words(notes) == "2 of 4 notes on their first partial, at most 7.0 cents off, within 0.03 s");
}

TEST_CASE("notes_heard: a note speaks once it stays within 50 cents of its end", "[analysis]") {
  auto played = steps({220}, 1.0);
  for (std::size_t n = 0; n < 14400; ++n) played[n] = 440;  // 0.3 s of the wrong partial
  const auto notes = heard(played, steps({220}, 1.0));
  REQUIRE(notes.size() == 1);
  REQUIRE(notes[0].speaks_after_s);
  // The tracker sees six periods at once, 27 ms.
  CHECK(*notes[0].speaks_after_s == Approx(0.3).epsilon(0).margin(0.03));
}

TEST_CASE("notes_heard: a vibrato is one note, and swings", "[analysis]") {
  auto wanted = steps({220}, 1.0);
  for (std::size_t n = 0; n < wanted.size(); ++n)
    wanted[n] *=
        std::exp2(20.0 / 1200 * std::sin(2 * std::numbers::pi * 5 * static_cast<double>(n) / kRate.value));
  const auto notes = heard(wanted, wanted);
  REQUIRE(notes.size() == 1);
  // 40 cents from crest to crest, a little smoothed by the windows.
  CHECK(notes[0].swing_cents == Approx(38).epsilon(0).margin(2.5));
}

TEST_CASE("note_name: the nearest note of the scale", "[analysis]") {
  CHECK(note_name(440) == "A4");
  CHECK(note_name(261.63) == "C4");
  CHECK(note_name(277.2) == "C#4");
  CHECK(note_name(27.5) == "A0");
  CHECK(note_name(15.4) == "B-1");
}
