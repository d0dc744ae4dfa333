#include "engine/nodes/declare.h"
#include "engine/nodes/delays/event_delay_kernel.h"

namespace tactus {
namespace {

constexpr double kLongest_s = 3600;

class EventDelayNode final : public Node {
  enum Input { kTrigger, kTime, kValue };

 public:
  explicit EventDelayNode(const NodeSetup& setup) : sample_rate_(setup.sample_rate.value) {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int n = 0; n < block.frames; ++n) {
      block.out[0][n] = tactus_event_delay_step(
          &state_, in[kTrigger][n], std::clamp(in[kTime][n], 0.0, kLongest_s) * sample_rate_, in[kValue][n]);
      block.out[1][n] = state_.value;
    }
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 private:
  double sample_rate_;
  tactus_event_delay state_{};
};

Interval event_delay_range(int output, const NodeSetup& setup) {
  if (output == 0) return {0, 1};
  return setup.input("value").range.joined(Interval::exactly(0));
}

}  // namespace

NodeType event_delay_type() {
  return {
      .name = "event_delay",
      .summary =
          "Delays each trigger by a time of its own, read when it comes in, and carries a value with it.",
      .equation =
          "a trigger in frame m with time[m] comes out in frame m + round(time[m] rate), with value[m]. At "
          "most "
          "64 are under way: further ones are left out. Triggers due in one frame are one",
      .source = "event queue of a sequencer",
      .example = "due = { type = \"event_delay\", trigger = \"hit\", time = \"wait\" }",
      .inputs = {{"trigger", "", "triggers to delay"},
                 {"time", "s", "delay of a trigger that comes in", {}, 0, kLongest_s},
                 {"value", "any", "value to carry", 0}},
      .outputs = {{.name = "out",
                   .unit = "",
                   .doc = "the triggers, delayed",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  {.name = "value",
                   .unit = "=value",
                   .doc = "the value of the last trigger that came out; 0 before the first",
                   .event_level = true}},
      .make = make_node<EventDelayNode>,
      .passes_triggers = true,
      .range = event_delay_range,
  };
}

}  // namespace tactus
