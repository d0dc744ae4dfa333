#include "engine/nodes/declare.h"
#include "engine/nodes/logic/poly_kernel.h"

namespace tactus {
namespace {

/// One lane. Every lane follows all voices, so that each knows which of them is due.
class PolyNode final : public Node {
  enum Input { kPitch, kOn, kOff, kLevel };

 public:
  explicit PolyNode(const NodeSetup& setup)
      : voices_(index(setup.lanes)), lane_(setup.lane), steal_(setup.setting("steal").text == "oldest") {}

  void process(const NodeBlock& block) noexcept override {
    const Signal* in = block.in;
    for (int n = 0; n < block.frames; ++n) {
      tactus_poly_step(&state_, voices_.data(), static_cast<int>(voices_.size()), steal_, in[kOn][n],
                       in[kOff][n], in[kPitch][n], in[kLevel][n]);
      const auto& voice = voices_[index(lane_)];
      block.out[0][n] = voice.starts;
      block.out[1][n] = voice.held;
      block.out[2][n] = voice.since > 0 ? voice.pitch : in[kPitch][n];
      block.out[3][n] = voice.level;
    }
  }
  void reset() noexcept override {
    std::ranges::fill(voices_, tactus_voice{});
    state_ = {};
  }
  void copy(const Node& other) noexcept override {
    const auto* same = dynamic_cast<const PolyNode*>(&other);
    if (same == nullptr || same->voices_.size() != voices_.size()) return;
    std::ranges::copy(same->voices_, voices_.begin());
    state_ = same->state_;
  }

 private:
  std::vector<tactus_voice> voices_;
  int lane_;
  bool steal_;
  tactus_poly state_{};
};

Interval poly_range(int output, const NodeSetup& setup) {
  if (output == 2) return setup.input("pitch").range;
  if (output == 3) return setup.input("level").range.joined(Interval::exactly(0));
  return {0, 1};
}

}  // namespace

NodeType poly_type() {
  return {
      .name = "poly",
      .summary =
          "Gives each note to one of `voices` voices, which are its lanes: polyphony for a node or a part.",
      .equation =
          "a note goes to the voice that holds its pitch, else to the one released longest ago, else to the "
          "one that "
          "started longest ago",
      .source = "elementary",
      .example =
          "keys = { type = \"poly\", pitch = \"key\", note_on = \"down\", note_off = \"up\", voices = 8 }",
      .inputs = {{"pitch", "any",
                  "pitch of the note that starts or ends: a frequency, or the number of a key"},
                 {"note_on", "", "trigger that starts a note"},
                 {"note_off", "",
                  "trigger that ends the note of this pitch; left out: notes end where others take their "
                  "voice",
                  0},
                 {"level", "any", "strength of the note that starts, such as its velocity", 1}},
      .outputs =
          {{.name = "out",
            .unit = "",
            .doc = "trigger in the lane that starts a note",
            .kind = OutputKind::Trigger,
            .range = {0, 1}},
           bounded(0, 1, {"gate", "", "1 while the voice holds its note"}),
           {"pitch", "=pitch", "pitch of its last note; before the first one, that of the input"},
           {.name = "level", .unit = "=level", .doc = "strength of its last note", .event_level = true}},
      .settings = {choice("steal",
                          "where all voices hold a note: the oldest ends, or the new note is left out",
                          {"oldest", "none"}, "oldest")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        if (const auto memory = setup.take_memory(4 * index(setup.lanes)); !memory)
          return tl::unexpected<Error>(memory.error());
        setup.variant = static_cast<std::uint64_t>(setup.lanes);
        return std::make_unique<PolyNode>(setup);
      },
      .range = poly_range,
  };
}

}  // namespace tactus
