#include "apps/play/live/controls/status_line.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::app;

TEST_CASE("status line: levels, load, xruns by cause, the guard and the knob in words", "[live]") {
  SessionView view;
  view.drives = view.armed = true;
  view.state = StreamState::Running;
  view.inputs = {{"microphone", 0.1}};
  view.outputs = {{"woofer", 1.0}, {"sound", 0.0}};
  view.guard = {"woofer ceiling"};
  view.health.median_load = 0.012;
  view.health.high_load = 0.034;
  view.health.peak_load = 0.12;
  view.health.xruns = 3;
  view.health.gaps = {1, 0, 0, 2};
  view.health.lost_frames = 512;
  CHECK(status_line(view, "strength = 0.6", 500) ==
        "armed | load 1.2, 3.4, 12 % | 3 xruns (1 input, 2 unsaid), 512 frames lost | guard: woofer ceiling\n"
        "microphone -20 dB > woofer 0 dB, sound silent | strength = 0.6");
}

TEST_CASE("status line: it says what keeps an instrument silent", "[live]") {
  SessionView view;
  view.state = StreamState::Running;
  const auto begins = [&](const std::string& with) {
    return status_line(view, "", 200).starts_with(with + " | ");
  };
  CHECK(begins("playing"));
  view.drives = true;
  CHECK(begins("not armed"));
  view.armed = true;
  CHECK(begins("armed"));
  view.muted = true;
  CHECK(begins("muted"));
  view.state = StreamState::Stalled;
  CHECK(begins("NO BLOCKS COME"));
  view.state = StreamState::Lost;
  CHECK(begins("DEVICE LOST"));
}

TEST_CASE("status line: it is cut to the terminal, by characters and not by bytes", "[live]") {
  SessionView view;
  view.inputs = {{"grün", 0.0}};
  CHECK(status_line(view, "", 7) == "playing\ngrün si");
}
