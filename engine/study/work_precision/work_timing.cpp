#include "engine/study/work_precision/work_timing.h"

#include <algorithm>
#include <ctime>

namespace tactus {
namespace {

constexpr int kWorkTimingBlock = 64;
constexpr double kLongestTiming_s = 0.3;
// The processor's clock counts microseconds.
constexpr double kShortestTiming_s = 3e-3;

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

}  // namespace

/// Gives out what was recorded.
class PlantTimer::Replay final : public BlockProcessor {
 public:
  explicit Replay(const SceneRecording& recording) {
    for (const auto& name : recording.outputs)
      drives_.push_back(recording.find("instrument." + name)->samples);
  }
  Status prepare(const StreamFormat&) override {
    next_ = 0;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (std::size_t c = 0; c < drives_.size(); ++c)
      std::copy_n(drives_[c].data() + next_, io.frames, io.out[c]);
    next_ += io.frames;
  }
  int outputs() const { return static_cast<int>(drives_.size()); }

 private:
  std::vector<std::vector<double>> drives_;
  std::ptrdiff_t next_ = 0;
};

PlantTimer::PlantTimer(BuiltScene built, const SceneSpec& scene, const SceneRecording& recording)
    : built_(std::make_unique<BuiltScene>(std::move(built))),
      replay_(std::make_unique<Replay>(recording)),
      rate_(recording.sample_rate),
      frames_(static_cast<int>(frames_in(scene.duration, rate_))) {
  loop_ = std::make_unique<ClosedLoop>(*replay_, *built_->plant, replay_->outputs(), built_->delay_frames,
                                       Converters{.on = false});
  const double share = kLongestTiming_s / std::max(kLongestTiming_s, recording.run_seconds);
  frames_ = std::max(std::min(frames_, kWorkTimingBlock), static_cast<int>(frames_ * share));
}

PlantTimer::~PlantTimer() = default;
PlantTimer::PlantTimer(PlantTimer&&) noexcept = default;

void PlantTimer::run() {
  double taken_s = 0, frames = 0;
  while (taken_s < kShortestTiming_s && frames < 1e9) {
    if (!loop_->prepare(rate_, kWorkTimingBlock)) return;
    const double started_s = processor_s();
    loop_->run(frames_);
    taken_s += processor_s() - started_s;
    frames += frames_;
  }
  runs_ns_.push_back(1e9 * taken_s / frames);
}

double PlantTimer::ns_per_frame() const {
  if (runs_ns_.empty()) return 0;
  auto sorted = runs_ns_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

}  // namespace tactus
