#include "engine/nodes/generators/sample_kernel.h"
#include "engine/nodes/generators/sound_file.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

constexpr double kMaxSpeed = 1000;

class SampleNode final : public Node {
 public:
  SampleNode(const NodeSetup& setup, Recording recording)
      : recording_(std::move(recording)),
        samples_per_frame_(recording_.sample_rate / setup.sample_rate),
        cubic_(setup.setting("interpolation").text == "cubic") {}

  void process(const NodeBlock& block) noexcept override {
    run_frames<3>(block, [this](double trigger, double speed, double level) {
      if (tactus_rise_step(&player_.rise, trigger) != 0) tactus_sample_start(&player_);
      const double increment = std::clamp(speed, 0.0, kMaxSpeed) * samples_per_frame_;
      const auto& samples = recording_.samples;
      return level * tactus_sample_read(&player_, samples.data(), static_cast<int>(samples.size()), increment,
                                        cubic_);
    });
  }
  void reset() noexcept override { player_ = {}; }

 private:
  Recording recording_;
  double samples_per_frame_;
  bool cubic_;
  tactus_sample player_{};
};

Result<std::unique_ptr<Node>> make_sample(const NodeSetup& setup) {
  auto recording =
      read_recording(setup.setting("file").text, static_cast<int>(setup.setting("channel").number));
  if (!recording) return tl::unexpected<Error>(recording.error());
  return std::make_unique<SampleNode>(setup, std::move(*recording));
}

}  // namespace

NodeType sample_type() {
  return {
      .name = "sample",
      .summary = "Plays a channel of a sound file from its start at each trigger; silent before and after.",
      .equation = "out[n] = level s(p[n]); p = 0 at a trigger, p[n+1] = p[n] + speed[n] file rate / rate",
      .source = "Moore, Elements of Computer Music, 1990; cubic: Catmull & Rom, 1974",
      .example = "thud = { type = \"sample\", file = \"thud.wav\", trigger = \"hit\" }",
      .inputs = {{"trigger", "", "starts the file; 1 starts it in the first frame"},
                 {"speed", "", "1 is the recorded speed; not band-limited above it", 1, 0, kMaxSpeed},
                 {"level", "any", "output at full scale of the file", 1}},
      .outputs = {{"out", "=level", "the recording"}},
      .settings =
          {{"file", Setting::Kind::File, "WAV, AIFF or FLAC; played at its own rate whatever the engine's"},
           within(1, 1024,
                  {"channel", Setting::Kind::Integer, "which channel of the file; 1 is the first", {}, "1"}),
           choice("interpolation", "between two samples of the file", {"linear", "cubic"}, "cubic")},
      .make = make_sample,
  };
}

}  // namespace tactus
