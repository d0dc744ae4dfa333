#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;
using Samples = std::vector<double>;

namespace {

test::Channels run(const std::string& text, const Samples& input) {
  return test::run(*test::engine_of(text), {input}, static_cast<int>(input.size()), {1, 64, 7});
}

/// Notes one a frame: above 0 it starts, below 0 it ends. Returns the gates of all voices times their pitch.
std::vector<Samples> play(const std::vector<double>& notes, int voices, const std::string& further = "") {
  const auto text =
      "format = 1\n[inputs]\nnote = {}\n[nodes]\n"
      "pitch = \"abs(note)\"\n"
      "keys = { type = \"poly\", pitch = \"pitch\", note_on = \"note > 0\", note_off = \"note < 0\", voices "
      "= " +
      std::to_string(voices) + further +
      " }\n[outputs]\nsounding = { from = \"keys.gate * keys.pitch\" }\nstarts = { from = \"keys\" }\n";
  // A pause between two notes, so that each is a rise.
  Samples input;
  for (const double note : notes) {
    input.push_back(note);
    input.push_back(0);
  }
  const auto all = run(text, input);
  std::vector<Samples> sounding(static_cast<std::size_t>(voices));
  for (std::size_t voice = 0; voice < sounding.size(); ++voice)
    for (std::size_t n = 0; n < notes.size(); ++n) sounding[voice].push_back(all[voice][2 * n]);
  return sounding;
}

}  // namespace

TEST_CASE("poly: notes take free voices in turn, and their own voice ends", "[nodes]") {
  CHECK(play({60, 64, -60, 67, -64, -67}, 2) ==
        std::vector<Samples>{{60, 60, 0, 67, 67, 0}, {0, 64, 64, 64, 0, 0}});
}

TEST_CASE("poly: the voice released longest ago is taken first, so that tails ring", "[nodes]") {
  CHECK(play({60, 62, 64, -62, -60, -64, 70, 71, 72}, 3) ==
        std::vector<Samples>{{60, 60, 60, 60, 0, 0, 0, 71, 71},
                             {0, 62, 62, 0, 0, 0, 70, 70, 70},
                             {0, 0, 64, 64, 64, 0, 0, 0, 72}});
}

TEST_CASE("poly: where all are held the oldest ends, or the new one is left out", "[nodes]") {
  CHECK(play({60, 62, 64}, 2) == std::vector<Samples>{{60, 60, 64}, {0, 62, 62}});
  CHECK(play({60, 62, 64, -60, 65}, 2, ", steal = \"none\"") ==
        std::vector<Samples>{{60, 60, 60, 0, 65}, {0, 62, 62, 62, 62}});
}

TEST_CASE("poly: a note that is held already starts again in its voice", "[nodes]") {
  CHECK(play({60, 62, 60, -60}, 2) == std::vector<Samples>{{60, 60, 60, 0}, {0, 62, 62, 62}});
}

TEST_CASE("poly: a part has as many copies as there are voices", "[nodes]") {
  // Two notes in turn through two strings: as two strings played alone.
  const std::string keys =
      "keys = { type = \"poly\", pitch = \"select(x > 0.75, 200 Hz, 300 Hz)\", note_on = \"x\", voices = 2 "
      "}\n"
      "bell = { type = \"decay\", trigger = \"keys\", time = \"1 ms\" }\n";
  Samples x(200);
  x[10] = 1;
  x[60] = 0.6;
  const auto both = run("format = 1\n[inputs]\nx = {}\n[nodes]\n" + keys +
                            "[outputs]\nout = { from = \"keys.pitch / 1 Hz * bell\" }\n",
                        x);
  REQUIRE(both.size() == 2);
  CHECK(both[0][10] == Approx(200));
  CHECK(both[0][60] == Approx(200 * std::exp(-50 / 48.0)));
  CHECK(both[1][59] == 0);
  CHECK(both[1][60] == Approx(300));
}
