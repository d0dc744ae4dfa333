#include "engine/plot/note_ticks.h"

#include <catch2/catch.hpp>

using namespace tactus;

namespace {

std::string ticks(double low, double high, int most) {
  std::string all;
  for (const auto& tick : svg::note_ticks({low, high, 100, 0, true}, most))
    all += (all.empty() ? "" : ", ") + tick.text;
  return all;
}

}  // namespace

TEST_CASE("note_name: the nearest note of the scale", "[analysis]") {
  CHECK(note_name(440) == "A4");
  CHECK(note_name(261.63) == "C4");
  CHECK(note_name(277.2) == "C#4");
  CHECK(note_name(27.5) == "A0");
  CHECK(note_name(15.4) == "B-1");
  CHECK(pitch_of_note(nearest_note(262)) == Approx(261.6256));
}

TEST_CASE("note_ticks: as many notes of the scale as there is room for", "[analysis]") {
  CHECK(ticks(219, 247, 8) == "A3 220 Hz, A#3 233 Hz, B3 247 Hz");
  CHECK(ticks(110, 220, 8) ==
        "A2 110 Hz, B2 123 Hz, C3 131 Hz, D3 147 Hz, E3 165 Hz, F3 175 Hz, G3 196 Hz, "
        "A3 220 Hz");
  CHECK(ticks(103, 470, 8) == "A2 110 Hz, C3 131 Hz, E3 165 Hz, A3 220 Hz, C4 262 Hz, E4 330 Hz, A4 440 Hz");
  CHECK(ticks(103, 470, 4) == "A2 110 Hz, A3 220 Hz, A4 440 Hz");
  CHECK(ticks(50, 2000, 3) == "A2 110 Hz, A4 440 Hz, A6 1760 Hz");
}
