#include "engine/nodes/declare.h"
#include "engine/nodes/logic/sequence_kernel.h"

namespace tactus {
namespace {

class SequenceNode final : public Node {
 public:
  explicit SequenceNode(const NodeSetup& setup) : values_(setup.setting("values").numbers) {}

  void process(const NodeBlock& block) noexcept override {
    const int count = static_cast<int>(values_.size());
    for (int n = 0; n < block.frames; ++n) {
      block.out[1][n] = tactus_sequence_step(&state_, block.in[0][n], block.in[1][n], values_.data(), count);
      const int place = tactus_sequence_index(&state_);
      block.out[0][n] = values_[index(place)];
      block.out[2][n] = place;
    }
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override {
    if (const auto* same = dynamic_cast<const SequenceNode*>(&other)) state_ = same->state_;
  }

 private:
  std::vector<double> values_;
  tactus_sequence state_{};
};

Interval sequence_range(int output, const NodeSetup& setup) {
  const auto& values = setup.setting("values").numbers;
  if (output == 1) return {0, 1};
  if (output == 2) return {0, std::max(0.0, static_cast<double>(values.size()) - 1)};
  if (values.empty()) return {};
  const auto [low, high] = std::ranges::minmax(values);
  return {low, high};
}

}  // namespace

NodeType sequence_type() {
  return {
      .name = "sequence",
      .summary = "Goes through a list of values, one at each trigger, and starts again at the end.",
      .equation =
          "out = values[i], i = (number of triggers since the last reset - 1) modulo the length; values[0] "
          "before the "
          "first trigger",
      .source = "elementary",
      .example = "accent = { type = \"sequence\", trigger = \"beat\", values = [1, 0.4, 0.7, 0.4] }",
      .inputs =
          {{"trigger", "", "goes to the next value"},
           {"reset", "",
            "trigger after which the next one plays the first value; comes before `trigger` in the same "
            "frame",
            0}},
      .outputs = {{"out", "=unit", "the value of the last trigger"},
                  {.name = "hit",
                   .unit = "",
                   .doc = "the triggers whose value is not 0: 0 in the list is a rest",
                   .kind = OutputKind::Trigger,
                   .range = {0, 1}},
                  bounded(0, kUnlimited, {"index", "", "place in the list, from 0"})},
      .settings = {required({"values",
                             Setting::Kind::Numbers,
                             "the values, quantities allowed; at least one",
                             {"=unit"}}),
                   unit_setting("values")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        if (setup.setting("values").numbers.empty())
          return fail(Errc::BadArgument, {}, "'values' is empty", "list values, as in values = [1, 0.5]");
        return std::make_unique<SequenceNode>(setup);
      },
      .range = sequence_range,
  };
}

}  // namespace tactus
