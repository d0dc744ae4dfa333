#include <algorithm>

#include "engine/nodes/generators/generators.h"
#include "engine/nodes/generators/sample_kernel.h"
#include "engine/nodes/generators/sound_file.h"

namespace tactus {
namespace {

constexpr double kMaxSpeed = 1000;

class Sample final : public Node {
 public:
  Sample(const NodeSetup& setup, Recording recording)
      : recording_(std::move(recording)),
        samples_per_frame_(recording_.sample_rate / setup.sample_rate),
        cubic_(setup.setting("interpolation").text == "cubic") {}

  void process(const NodeBlock& block) noexcept override {
    const Signal trigger = block.in[0], speed = block.in[1], level = block.in[2];
    for (int i = 0; i < block.frames; ++i) {
      if (tactus_rise_step(&player_.rise, trigger[i]) != 0) tactus_sample_start(&player_);
      const double increment = std::clamp(speed[i], 0.0, kMaxSpeed) * samples_per_frame_;
      block.out[0][i] =
          level[i] * tactus_sample_read(&player_, recording_.samples.data(),
                                        static_cast<int>(recording_.samples.size()), increment, cubic_);
    }
  }
  void reset() noexcept override { player_ = {}; }

 private:
  Recording recording_;
  double samples_per_frame_;
  bool cubic_;
  tactus_sample player_{};
};

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  auto recording =
      read_recording(setup.setting("file").text, static_cast<int>(setup.setting("channel").number));
  if (!recording) return tl::unexpected<Error>(recording.error());
  return std::make_unique<Sample>(setup, std::move(*recording));
}

}  // namespace

const NodeType& sample_type() {
  static const NodeType type = {
      .name = "sample",
      .group = "generators",
      .summary = "Plays a channel of a sound file from its start at each trigger; silent before and after.",
      .equation = "out[n] = level s(p[n]); p = 0 at a trigger, p[n+1] = p[n] + speed[n] file rate / rate",
      .source = "Moore, Elements of Computer Music, 1990; cubic: Catmull & Rom, 1974",
      .example = "thud = { type = \"sample\", file = \"thud.wav\", trigger = \"hit\" }",
      .inputs = {{.name = "trigger", .unit = "", .doc = "starts the file; 1 starts it in the first frame"},
                 {.name = "speed",
                  .unit = "",
                  .doc = "1 is the recorded speed; not band-limited above it",
                  .fallback = 1,
                  .low = 0,
                  .high = kMaxSpeed},
                 {.name = "level", .unit = "any", .doc = "output at full scale of the file", .fallback = 1}},
      .outputs = {{.name = "out", .unit = "=level", .doc = "the recording"}},
      .settings = {{.name = "file",
                    .kind = Setting::Kind::File,
                    .doc = "WAV, AIFF or FLAC; played at its own rate whatever the engine's"},
                   {.name = "channel",
                    .kind = Setting::Kind::Integer,
                    .doc = "which channel of the file; 1 is the first",
                    .fallback = "1",
                    .low = 1,
                    .high = 1024},
                   {.name = "interpolation",
                    .kind = Setting::Kind::Choice,
                    .doc = "between two samples of the file",
                    .choices = {"linear", "cubic"},
                    .fallback = "cubic"}},
      .make = make,
  };
  return type;
}

}  // namespace tactus
