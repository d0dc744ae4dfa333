#include "apps/play/live/controls/status_line.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <vector>

#include "engine/graph/file/load.h"
#include "engine/graph/file/quantity.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/scene/guard_report.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/optional_files.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;
using namespace tactus::app;

namespace {

SessionView busy_view() {
  SessionView view;
  view.drives = view.armed = true;
  view.state = StreamState::Running;
  view.inputs = {{"microphone", 0.1}};
  view.outputs = {{"woofer", 1.0}, {"sound", 0.0}};
  view.health.median_load = 0.012;
  view.health.high_load = 0.034;
  view.health.peak_load = 0.12;
  return view;
}

int characters(const std::string& text) {
  return static_cast<int>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xc0) != 0x80; }));
}

/// Instruments and their plants, as far as they can be played by themselves.
std::vector<std::unique_ptr<Plan>> shipped_plans() {
  std::vector<std::unique_ptr<Plan>> plans;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(test::kInstruments)) {
    if (entry.path().filename() != "instrument.toml" || test::is_left_out(entry.path())) continue;
    auto plan = compile(load_graph_leniently(entry.path(), test::kInstruments), standard_nodes(), {});
    REQUIRE(plan);
    plans.push_back(std::move(*plan));
  }
  return plans;
}

}  // namespace

TEST_CASE("status line: levels as bars of 6 dB a cell, load, xruns by cause, the guard and the control",
          "[live]") {
  auto view = busy_view();
  view.guard = {"woofer ceiling"};
  view.health.xruns = 3;
  view.health.gaps = {1, 0, 0, 2};
  view.health.lost_frames = 512;
  CHECK(
      status_line(view, "strength = 0.6", 500) ==
      "armed | guard: woofer ceiling | 3 xruns (1 input, 2 unsaid), 512 frames lost | load 3 % (max 12 %) | "
      "microphone [####....] > woofer [#######!] sound [........] | strength = 0.6");
}

TEST_CASE("status line: a cell of a bar is full from its level on", "[live]") {
  // 8 cells of 6 dB from -48 dB on: of -6 dB 7 cells are full, just below it 6.
  SessionView view;
  view.inputs = {{"x", std::pow(10, -5.99 / 20)}, {"y", std::pow(10, -6.01 / 20)}, {"z", 1.0}};
  CHECK(status_line(view, "", 99).ends_with("x [#######.] y [######..] z [#######!]"));
}

TEST_CASE("status line: one line of 79 columns holds each shipped instrument with any of its controls",
          "[live]") {
  const auto plans = shipped_plans();
  REQUIRE(plans.size() > 5);
  for (const auto& plan : plans) {
    auto view = busy_view();
    view.inputs.clear();
    view.outputs.clear();
    for (const auto& name : plan->input_names) view.inputs.push_back({name, 0.1});
    for (const auto& name : output_names(*plan)) view.outputs.push_back({name, 1.0});
    view.recorded_s = 3600.0;
    view.health.xruns = 1000;
    for (const auto& planned : plan->controls) {
      const auto control =
          planned.control.name + " = " + in_unit(planned.control.value, planned.control.unit);
      const auto line = status_line(view, control, 79);
      CAPTURE(line);
      CHECK(characters(line) <= 79);
      CHECK(line.find('\n') == std::string::npos);
      CHECK(line.starts_with("armed | rec 3600 s | 1000 xruns | "));
      CHECK(line.ends_with(" | " + control));
      CHECK(line.find("!]") != std::string::npos);
    }
  }
}

TEST_CASE("status line: 64 inputs and outputs have one bar each, the highest", "[live]") {
  auto view = busy_view();
  view.inputs.assign(64, {"input", 0.0});
  view.outputs.assign(64, {"output", 0.0});
  view.inputs[40].peak = 0.01;  // -40 dB: 8 of 48 dB are less than one of four cells
  view.outputs[63].peak = 1.0;
  CHECK(status_line(view, "", 79) == "armed | load 3 % | in [....] > out [###!]");
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

TEST_CASE("status line: on a narrow terminal it is cut, by characters and not by bytes", "[live]") {
  SessionView view;
  view.inputs = {{"grün", 0.0}};
  CHECK(status_line(view, "größe = 1", 39) == "playing | load 0 % | in [.] | größe = 1");
  CHECK(status_line(view, "größe = 1", 22) == "playing | in [.] | grö");
  CHECK(status_line(view, "", 4) == "play");
}

TEST_CASE(
    "control list: each control with its place in its range, constants marked, the selected one in view",
    "[live]") {
  const auto player = test::engine_of(R"(format = 1
[controls]
plain = { value = 0.5, range = [-1, 3] }
loud  = { value = "-30 dB", range = ["-60 dB", "0 dB"] }
wide  = { value = 100 }
[outputs]
y = { from = "plain" }
z = { from = "loud * wide" }
)");
  const LiveControls controls{*player};
  CHECK(control_list(controls, 1, 79, 10) ==
        "  plain  [####........]  0.5\n"  // (0.5 + 1) / 4 of 12 cells: 4.5
        "> loud   [######......]  -30 dB\n"
        "  wide   constant        100");
  CHECK(control_list(controls, 2, 79, 1) == "> wide   constant        100");
  CHECK(control_list(controls, 0, 7, 2) == "> plain\n  loud ");
}
