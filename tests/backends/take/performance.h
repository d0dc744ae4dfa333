#pragma once

#include <filesystem>
#include <functional>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/take_files.h"
#include "apps/render/render.h"
#include "backends/take/take_recorder.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/rig/rig_inputs.h"

namespace tactus::test {

template <class Wanted>
auto must(Wanted result) {
  if (!result) throw std::runtime_error(to_string(result.error()));
  if constexpr (!std::is_void_v<typename Wanted::value_type>) return std::move(*result);
}

/// Somebody plays a graph file and is recorded, as on a sound card but for the clock: blocks of changing
/// sizes, controls, arm and mute at any frame, edits while it plays, stops, sensors that fall out.
class Performance {
 public:
  /// Every third seed plays through a rig.
  Performance(std::filesystem::path graph, std::filesystem::path wav, unsigned seed,
              std::vector<GuardedChannel> guard = {})
      : graph_(std::move(graph)),
        bits_(seed),
        engine_(compiled()),
        scales_(static_cast<std::size_t>(engine_.in_channels()), seed % 3 == 0 ? 1.0 / 3.0 : 1.0),
        padding_(seed % 3 == 0 ? 333 : 0),
        rig_(engine_, scales_, padding_),
        guarded_(rig_, std::move(guard), seed % 2 == 0),
        sensors_(static_cast<std::size_t>(engine_.in_channels()), std::vector<double>(kLongest)),
        drives_(static_cast<std::size_t>(engine_.out_channels()), std::vector<double>(kLongest)) {
    for (auto& channel : sensors_) in_.push_back(channel.data());
    for (auto& channel : drives_) out_.push_back(channel.data());
    guarded_.set_dead_mans_switch(&dead_man_);
    must(guarded_.prepare({kRate, engine_.in_channels(), engine_.out_channels(), kLongest}));
    recorder_ = must(TakeRecorder::start(wav, header()));
    guarded_.set_tap(&recorder_->tap());
    engine_.set_tap(&recorder_->tap());
  }

  static constexpr Hertz kRate = 48_kHz;

  /// `edit(k)`: the text of the k-th version of the graph; empty: it is never edited.
  void play(int frames, const std::function<std::string(int)>& edit = {}) {
    for (const auto end = guarded_.frame() + frames; guarded_.frame() < end;) {
      if (pick(5) == 0) move_a_control();
      if (pick(11) == 0) touch_the_guard();
      if (pick(29) == 0)
        while (!guarded_.finish({in_.data(), out_.data(), 1})) continue;
      if (edit && pick(13) == 0 && !engine_.replacing()) replace(edit(++versions_));
      block(1 + pick(std::min<int>(kLongest, static_cast<int>(end - guarded_.frame()))));
    }
  }
  /// One block, of `sensors` where they are given.
  void block(int frames) {
    if (refreshes) dead_man_.refresh();
    for (auto& channel : sensors_)
      for (int n = 0; n < frames; ++n) channel[static_cast<std::size_t>(n)] = sample(guarded_.frame() + n);
    guarded_.process({in_.data(), out_.data(), frames});
  }
  void replace(const std::string& text) {
    std::ofstream{graph_, std::ios::binary} << text;
    must(engine_.replace(compiled(), pick(2) == 0 ? JournalEntry::kNow : soon()));
    recorder_->note_edit({0, files_, app::take_settings(engine_.plan()), engine_.control_names()});
  }
  /// What the recorder says at the end.
  std::vector<std::string> finish() {
    guarded_.set_tap(nullptr);
    engine_.set_tap(nullptr);
    return recorder_->finish();
  }

  Player& engine() { return engine_; }
  Guarded& guarded() { return guarded_; }
  TakeRecorder& recorder() { return *recorder_; }

  bool refreshes = true;  ///< the dead man's switch

 private:
  static constexpr int kLongest = 300;

  int pick(int count) { return static_cast<int>(bits_() % static_cast<unsigned>(count)); }
  std::int64_t soon() { return guarded_.frame() + pick(700); }

  std::unique_ptr<Plan> compiled() {
    const auto loaded = load_graph_leniently(graph_, graph_.parent_path());
    if (loaded.spec == nullptr) throw std::runtime_error(to_string(loaded.errors));
    files_ = app::take_files(loaded, standard_nodes(), graph_.parent_path());
    CompileOptions options;
    options.sample_rate = kRate;
    return must(compile(loaded, standard_nodes(), options));
  }

  TakeHeader header() {
    auto header = app::take_header(engine_, guarded_);
    header.program = "test";
    header.files = files_;
    header.input_scales = scales_;
    header.padding_frames = padding_;
    return header;
  }

  /// Noise of floats; now and then a sensor lies at the end of its range long enough to be found out.
  double sample(std::int64_t frame) {
    if (frame % 20000 > 17000) return 1.0;
    return static_cast<double>(std::uniform_real_distribution<float>{-0.9f, 0.9f}(bits_));
  }

  void move_a_control() {
    const auto& names = engine_.control_names();
    if (names.empty()) return;
    const double value = std::uniform_real_distribution{-1.0, 1.0}(bits_);
    (void)engine_.post({pick(2) == 0 ? JournalEntry::kNow : soon(), JournalEntry::Kind::ControlChange,
                        pick(static_cast<int>(names.size())), value});
  }
  void touch_the_guard() {
    const auto kind = pick(3) == 0 ? JournalEntry::Kind::Mute : JournalEntry::Kind::Arm;
    const JournalEntry entry{pick(2) == 0 ? JournalEntry::kNow : soon(), kind,
                             pick(engine_.out_channels() + 1) - 1, pick(4) == 0 ? 0.0 : 1.0};
    const bool on = entry.value > 0.5;
    if (entry.frame != JournalEntry::kNow || entry.index != JournalEntry::kAllChannels)
      (void)guarded_.post(entry);
    else if (kind == JournalEntry::Kind::Arm)
      guarded_.arm(on);
    else if (guarded_.frame() % 2 == 0)
      guarded_.mute(on);
    else
      guarded_.fade(on);
  }

  std::filesystem::path graph_;
  std::mt19937 bits_;
  TakeFiles files_;
  Player engine_;
  std::vector<double> scales_;
  int padding_;
  RigInputs rig_;
  /// Its age counts in frames; by the clock no time passes, however slow the machine is.
  DeadMansSwitch dead_man_{[] { return std::chrono::nanoseconds{0}; }};
  Guarded guarded_;
  std::unique_ptr<TakeRecorder> recorder_;
  std::vector<std::vector<double>> sensors_, drives_;
  std::vector<const double*> in_;
  std::vector<double*> out_;
  int versions_ = 0;
};

/// A take played again from what it keeps.
struct ReplayOfTake {
  Take take;
  Replayed replayed;
  std::vector<std::vector<double>> drives;

  bool same() const { return app::is_same(take, replayed); }
  std::string verdict() const { return app::verdict(take, replayed); }
};

inline ReplayOfTake replay_of(const std::filesystem::path& path, const std::vector<int>& blocks) {
  ReplayOfTake result{must(read_take(path)), {}, {}};
  auto wav = must(WavReader::open(path));
  const auto& header = result.take.header;
  Player engine{must(app::compile_take(header, header.files, header.settings))};
  engine.set_journal(result.take.engine);
  RigInputs rig{engine, header.input_scales, header.padding_frames};
  Guarded guarded{rig, header.guard, header.armed};
  result.drives.resize(static_cast<std::size_t>(engine.out_channels()));
  const auto replace = [&](const TakeEdit& edit) -> Status {
    return engine.replace(must(app::compile_take(header, edit.files, edit.settings)));
  };
  const ReplayHost host{guarded, app::sensors_for(header, header.inputs), engine.out_channels(), replace,
                        true};
  const auto keep = [&](const double* const* out, int frames) -> Status {
    for (std::size_t c = 0; c < result.drives.size(); ++c)
      result.drives[c].insert(result.drives[c].end(), out[c], out[c] + frames);
    return {};
  };
  result.replayed = must(replay(result.take, wav, host, blocks, keep));
  return result;
}

}  // namespace tactus::test
