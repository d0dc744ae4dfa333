#pragma once

// Thread: [control].

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/nodes/table.h"

namespace tactus {

// Rows of a declaration. An input is {name, unit, doc, default, low, high}, an output {name, unit, doc}, a
// setting {name, kind, doc, choices or units, default}.

/// An input that may close a loop, is needed when the node is made, is the least time between two events,
/// samples the first input.
inline InputPort late(InputPort port) { return port.late = true, port; }
inline InputPort fixed(InputPort port) { return port.fixed = true, port; }
inline InputPort event_hold(InputPort port) { return port.hold = true, port; }
inline InputPort sampling(InputPort port) { return port.samples = true, port; }
/// An output that stays in [low, high].
inline OutputPort bounded(double low, double high, OutputPort port) { return port.range = {low, high}, port; }

inline Setting choice(std::string name, std::string doc, std::vector<std::string> choices,
                      std::string fallback) {
  return {std::move(name), Setting::Kind::Choice, std::move(doc), std::move(choices), std::move(fallback)};
}
/// See kMotionSetting.
inline Setting motion_setting() {
  return choice(kMotionSetting,
                "rotation: angles in rad for m, torques in N m for N, inertia in kg m^2 for kg",
                {kTranslation, kRotation}, kTranslation);
}
/// The unit of an output, as text.
inline Setting unit_setting(std::string of_what) {
  return {"unit", Setting::Kind::Unit, "unit of the " + of_what + "; default: a plain number"};
}

// What several filters and strings have in common.
inline InputPort filtered_input(std::string doc = "signal to filter") {
  return {"in", "any", std::move(doc)};
}
inline OutputPort filtered_output(std::string name, std::string doc) {
  return {std::move(name), "=in", std::move(doc)};
}
/// Clamped to [1e-6 fs, 0.49 fs]; changes at the start of a group of eight frames.
inline InputPort cutoff_input(std::string doc, std::optional<double> fallback = std::nullopt) {
  return {"cutoff", "Hz", std::move(doc), fallback, 0};
}
inline InputPort loss_input() {
  return {"loss", "", "additional damping of high partials; 0: none (one_pole: at most 0.99)", 0.5, 0, 1};
}
inline Setting loss_filter_setting() {
  return choice("loss_filter",
                "one_zero reduces the gain by at most this, at half the sample rate; one_pole damps from "
                "lower frequencies on",
                {"one_zero", "one_pole"}, "one_zero");
}

/// `make` of a node type whose class is constructed from the setup and cannot fail.
template <class SomeNode>
Result<std::unique_ptr<Node>> make_node(const NodeSetup& setup) {
  return std::make_unique<SomeNode>(setup);
}

/// Range of the values of the setting `points`; unbounded where there are none.
inline Interval range_of_points(int, const NodeSetup& setup) {
  Interval range{kUnlimited, -kUnlimited};
  for (const auto& point : setup.setting("points").points)
    range = range.joined(Interval::exactly(point.second));
  return range.low <= range.high ? range : Interval{};
}

/// Range of an output that starts at 0 and goes no further than an input.
inline auto from_zero_to(const char* input) {
  return
      [input](int, const NodeSetup& setup) { return setup.input(input).range.joined(Interval::exactly(0)); };
}

}  // namespace tactus
