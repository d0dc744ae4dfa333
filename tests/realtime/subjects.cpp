#include "tests/realtime/subjects.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "backends/take/take_recorder.h"
#include "backends/wav_file.h"
#include "engine/graph/file/load.h"
#include "engine/nodes/table.h"
#include "engine/rig/profile.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/guard_report.h"
#include "tests/realtime/every_node.h"
#include "tests/realtime/world_subject.h"
#include "tests/support/optional_files.h"

namespace tactus::realtime {
namespace {

namespace fs = std::filesystem;

constexpr auto kRate = 48_kHz;

template <class Wanted>
auto must(Wanted result) {
  if (!result) throw std::runtime_error(to_string(result.error()));
  return std::move(*result);
}

void must_be(const Status& status) {
  if (!status) throw std::runtime_error(to_string(status.error()));
}

/// The graph of every_node.h, and the folder of its sound file.
class EveryNode {
 public:
  EveryNode()
      : folder_(fs::temp_directory_path() / ("tactus_every_node_" + std::to_string(std::random_device{}()))) {
    fs::create_directory(folder_);
    must_be(write_wav(folder_ / "sound.wav", {kRate, {{0.0, 0.5, 1.0, 0.5, 0.0, -0.5, -1.0, -0.5}}}));
  }
  ~EveryNode() { fs::remove_all(folder_); }
  EveryNode(const EveryNode&) = delete;

  std::unique_ptr<Plan> version(bool edited) const {
    return must(every_node(standard_nodes(), folder_.string(), "sound.wav", edited));
  }

 private:
  fs::path folder_;
};

/// An engine behind its guard, both recorded, and hands on both.
class PlayedGraph {
 public:
  PlayedGraph(std::unique_ptr<Player> engine, const LimitBook& drives)
      : engine_(std::move(engine)),
        guarded_(*engine_, guarded_channels(engine_->plan(), drives)),
        take_(engine_->in_channels(), engine_->out_channels(), 4096) {
    guarded_.set_tap(&take_);
    engine_->set_tap(&take_);
  }

  Player& engine() { return *engine_; }
  Guarded& guarded() { return guarded_; }

  void disturb(std::mt19937& random) {
    const auto& controls = engine_->plan().controls;
    for (std::size_t c = 0; c < controls.size(); ++c) {
      const auto& range = controls[c].control.range;
      if (!std::isfinite(range.low) || !std::isfinite(range.high)) continue;
      const double value = std::uniform_real_distribution{range.low, range.high}(random);
      (void)engine_->post(
          {JournalEntry::kNow, JournalEntry::Kind::ControlChange, static_cast<int>(c), value});
    }
    const auto kind = random() % 2 == 0 ? JournalEntry::Kind::Arm : JournalEntry::Kind::Mute;
    (void)guarded_.post(
        {JournalEntry::kNow, kind, JournalEntry::kAllChannels, random() % 2 == 0 ? 1.0 : 0.0});
    GuardEvent event;
    while (guarded_.take_event(event)) continue;
    for (int c = 0; c < engine_->out_channels(); ++c) {
      (void)guarded_.counts(c);
      (void)guarded_.thermal_state(c);
    }
    (void)engine_->faults();
    fetch_take();
  }

 private:
  /// As the writer of a take does. It comes seldom: most of the time the audio thread finds the ring full.
  void fetch_take() {
    take_.drop_front(take_.front(take_.written()).frames);
    for (TakeEvent event; take_.pop(event);) continue;
  }

  std::unique_ptr<Player> engine_;
  Guarded guarded_;
  TakeRing take_;
};

class SceneSubject final : public Subject {
 public:
  SceneSubject(const SceneSpec& scene, BuiltScene built, int frames)
      : plant_(std::move(built.plant)),
        player_(std::move(built.instrument), scene.drives),
        loop_(player_.guarded(), *plant_, player_.engine().out_channels(), built.delay_frames,
              scene.converters),
        frames_(frames) {
    name = scene.name;
    must_be(loop_.prepare(player_.engine().plan().sample_rate, frames));
  }
  void callback() noexcept override { loop_.run(frames_); }
  void disturb(std::mt19937& random) override { player_.disturb(random); }

 private:
  std::unique_ptr<Player> plant_;
  PlayedGraph player_;
  ClosedLoop loop_;
  int frames_;
};

/// The graph of every_node.h on noise, which comes round after `kNoise` frames.
class GraphSubject : public Subject {
 public:
  GraphSubject(const LimitBook& drives, int frames)
      : player_(std::make_unique<Player>(every_.version(false)), drives), frames_(frames), noise_(kNoise) {
    name = "every node";
    std::mt19937 random{1};
    for (auto& sample : noise_) sample = std::uniform_real_distribution{-1.0, 1.0}(random);
    in_.resize(static_cast<std::size_t>(player_.engine().in_channels()));
    silence_.assign(static_cast<std::size_t>(player_.engine().out_channels()),
                    std::vector<double>(static_cast<std::size_t>(frames)));
    for (auto& channel : silence_) out_.push_back(channel.data());
    must_be(player_.guarded().prepare(
        {kRate, player_.engine().in_channels(), player_.engine().out_channels(), frames}));
  }
  void callback() noexcept override {
    for (auto& channel : in_) channel = noise_.data() + at_;
    player_.guarded().process({in_.data(), out_.data(), frames_});
    at_ = at_ + 2 * static_cast<std::size_t>(frames_) <= kNoise ? at_ + static_cast<std::size_t>(frames_) : 0;
  }
  void disturb(std::mt19937& random) override { player_.disturb(random); }

 protected:
  EveryNode every_;
  PlayedGraph player_;

 private:
  static constexpr std::size_t kNoise = 1 << 16;

  int frames_;
  std::vector<double> noise_;
  std::vector<const double*> in_;
  std::vector<std::vector<double>> silence_;
  std::vector<double*> out_;
  std::size_t at_ = 0;
};

/// The same, and the control side edits it whenever it can; the audio thread waits until it has a
/// new one every `kCallbacksAnEdit` callbacks.
class EditedSubject final : public GraphSubject {
 public:
  EditedSubject(const LimitBook& drives, int frames) : GraphSubject(drives, frames) { name += ", edited"; }
  void await() override {
    if (calls_++ % kCallbacksAnEdit != 0) return;
    while (edits_ == met_) std::this_thread::yield();
    met_ = edits_;
  }
  void disturb(std::mt19937& random) override {
    GraphSubject::disturb(random);
    if (player_.engine().replacing()) return;
    must_be(player_.engine().replace(every_.version(edits_ % 2 == 0)));
    ++edits_;
  }
  long edits() const override { return edits_; }

 private:
  static constexpr long kCallbacksAnEdit = 5000;

  long calls_ = 0, met_ = 0;
  std::atomic<long> edits_{0};
};

bool is_scene(const fs::path& file) {
  if (file.extension() != ".toml") return false;
  const auto table = load_toml(file);
  return table && find(*table, "parts") != nullptr;
}

void add_scenes(const fs::path& instruments, int frames, Subjects& subjects) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(instruments))
    if (is_scene(entry.path()) && !test::is_left_out(entry.path())) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  if (files.empty()) throw std::runtime_error("no scene below " + instruments.string());
  for (const auto& file : files) {
    const auto scene = must(load_scene(file, instruments));
    subjects.push_back(
        std::make_unique<SceneSubject>(scene, must(build_scene(scene, standard_nodes())), frames));
  }
}

}  // namespace

Subjects all_subjects(const fs::path& instruments, int frames) {
  Subjects subjects;
  add_scenes(instruments, frames, subjects);
  const auto woofer = limits_for(must(load_profile(must(find_profile("woofer", {instruments}, {})))), 10);
  LimitBook drives;
  drives.drives = {{LimitSource::Kind::Profile, "woofer", woofer}};
  subjects.push_back(std::make_unique<GraphSubject>(drives, frames));
  subjects.push_back(std::make_unique<EditedSubject>(drives, frames));
  if (auto world = world_subject(instruments, frames)) subjects.push_back(std::move(world));
  return subjects;
}

}  // namespace tactus::realtime
