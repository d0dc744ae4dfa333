#include "apps/play/live/performer.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <new>
#include <utility>

#include "apps/cli/console.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/take_files.h"
#include "apps/cli/warnings.h"
#include "apps/play/world.h"
#include "backends/backend.h"
#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"
#include "engine/rig/rig_inputs.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

void add_files(const GraphSpec& graph, std::vector<std::filesystem::path>& files) {
  if (graph.file.file) files.emplace_back(*graph.file.file);
  for (const auto& [use, part] : graph.parts)
    if (part != nullptr) add_files(*part, files);
}

std::vector<std::filesystem::path> files_of(const LoadedGraph& loaded) {
  std::vector<std::filesystem::path> files;
  add_files(*loaded.spec, files);
  return files;
}

/// What `fill` puts into an edit; what it throws are the errors of the edit.
template <class Fill>
Edit edit_by(Fill fill) {
  Edit edit;
  try {
    fill(edit);
  } catch (const CommandError& error) {
    edit.errors = error.errors;
  } catch (const std::bad_alloc&) {
    edit.errors = {out_of_memory("the edited files")};
  } catch (const std::exception& error) {
    edit.errors = {{Errc::BadFile, "", error.what(), "check the files"}};
  }
  return edit;
}

/// The guard must watch for feedback before the plan that makes it possible takes over.
void watch_paths(Guarded& guarded, const Plan& plan) {
  std::vector<FeedbackPath> paths;
  for (const auto& channel : guarded_channels(plan, {})) paths.push_back(channel.feedback);
  guarded.add_feedback_paths(paths);
}

class LiveInstrument final : public Performer {
 public:
  explicit LiveInstrument(PerformerSetup setup) : setup_(std::move(setup)) {
    loaded_ = load();
    name = loaded_.spec->name;
    files = files_of(loaded_);
    if (const auto text = warning(loaded_); !text.empty()) print_note(text);
    auto plan = compile_files(loaded_);
    print_warnings(*plan);
    if (setup_.rig) wiring_ = or_exit(wire_rig(*setup_.rig, *plan));
    inputs = plan->input_names;
    outputs = output_names(*plan);
    in_map = wiring_.in_map;
    out_map = wiring_.out_map;
    auto limits = apply(setup_.guard, std::move(wiring_.limits));
    limits.sound_known = setup_.rig.has_value();
    announce_raises(limits, *plan);
    guards = guarded_channels(*plan, limits);
    engine_ = std::make_unique<Player>(std::move(plan));
    if (RigInputs::needed(wiring_.input_scales, setup_.padding_frames))
      rig_inputs_.emplace(*engine_, wiring_.input_scales, setup_.padding_frames);
  }

  BlockProcessor& processor() override {
    if (rig_inputs_) return *rig_inputs_;
    return *engine_;
  }
  Player& instrument() override { return *engine_; }
  std::vector<NetworkReport> networks(int block) override {
    return report_networks(engine_->plan(), time_steps(*engine_, block, kTimingDuration));
  }
  void describe(TakeHeader& header) const override {
    header.files = take_files(loaded_, standard_nodes(), setup_.target.root());
    header.input_scales = wiring_.input_scales;
    header.padding_frames = setup_.padding_frames;
    if (setup_.rig) add_rig(*setup_.rig, to_text(*setup_.rig), header);
  }

  Edit read_edit() override {
    return edit_by([this](Edit& edit) {
      const auto loaded = std::make_shared<LoadedGraph>(load());
      edit.files = files_of(*loaded);
      edit.warning = warning(*loaded);
      const auto plan = std::make_shared<std::unique_ptr<Plan>>(compile_files(*loaded));
      if (const auto text = text_of_warnings(**plan); !text.empty())
        edit.warning += (edit.warning.empty() ? "" : "\n") + text;
      edit.take_over = [this, loaded, plan](Guarded& guarded) {
        take_over(guarded, std::move(*loaded), std::move(*plan));
      };
    });
  }

 private:
  LoadedGraph load() const {
    auto loaded = load_graph_leniently(setup_.target.file, setup_.target.root());
    if (loaded.spec == nullptr) throw CommandError{loaded.errors};
    return loaded;
  }

  std::unique_ptr<Plan> compile_files(LoadedGraph loaded) const {
    if (setup_.rig) fit(loaded, *setup_.rig);
    CompileOptions options;
    options.sample_rate = setup_.rate;
    options.system_delay = system_delay();
    options.controls = setup_.controls;
    return or_exit(compile(loaded, standard_nodes(), options));
  }

  Seconds system_delay() const {
    return Seconds{setup_.delay.value_or(0_s).value + setup_.padding_frames / setup_.rate.value};
  }

  /// Empty: none.
  std::string warning(const LoadedGraph& loaded) const {
    const double delay_s = system_delay().value;
    return delay_s > 0 ? delay_warning(*loaded.spec, delay_s) : "";
  }

  void take_over(Guarded& guarded, LoadedGraph loaded, std::unique_ptr<Plan> plan) {
    watch_paths(guarded, *plan);
    or_exit(engine_->replace(std::move(plan)));
    name = loaded.spec->name;
    loaded_ = std::move(loaded);
  }

  PerformerSetup setup_;
  RigWiring wiring_;
  LoadedGraph loaded_;  ///< that plays
  std::unique_ptr<Player> engine_;
  std::optional<RigInputs> rig_inputs_;
};

constexpr double kStrikeSeconds = 0.01;  // that the key is down
constexpr int kStrikeControl = 0;        // the only one: see SceneOptions::by_hand

struct Read {
  SceneSpec scene;
  CompiledScene compiled;
  std::string inputs;  ///< as World::inputs
};

Read read_scene(const PerformerSetup& setup) {
  auto [loaded, inputs] = load_world(setup.target, setup.in, /*by_hand=*/true);
  if (!loaded.scene) throw CommandError{std::move(loaded.errors)};
  loaded.scene->drives = apply(setup.guard, std::move(loaded.scene->drives));
  auto compiled = or_exit(
      compile_scene(loaded, standard_nodes(), {setup.delay, setup.rate, setup.controls, /*by_hand=*/true}));
  print_warnings(*compiled.instrument);
  print_warnings(*compiled.plant);
  return {std::move(*loaded.scene), std::move(compiled), std::move(inputs)};
}

class LiveWorld final : public Performer, private BlockProcessor {
 public:
  LiveWorld(PerformerSetup setup, Read read)
      : setup_(std::move(setup)),
        scene_(std::move(read.scene)),
        built_(std::move(read.compiled)),
        ports_(scene_, built_.plant_taps),
        guarded_(*built_.instrument, guarded_channels(built_.instrument->plan(), scene_.drives)),
        loop_(guarded_, *built_.plant, built_.instrument->out_channels(), built_.delay_frames,
              scene_.converters),
        listener_([this](const ClosedLoop::Block& block) { copy_monitor(block); }) {
    if (loop_.has_units()) guarded_.disable_sensor_watch();
    name = scene_.name;
    input_signals = std::move(read.inputs);
    files = files_of(scene_);
    const auto& plan = built_.instrument->plan();
    auto sounds = sound_names(plan, scene_.roles);
    if (sounds.empty()) sounds = output_names(plan);
    plays_sensors_ = sounds.empty();
    const auto all = plays_sensors_ ? plan.input_names : output_names(plan);
    if (plays_sensors_) sounds = all;
    // One sound comes from every speaker.
    for (std::size_t c = 0; !sounds.empty() && c < index(setup_.speakers); ++c) {
      outputs.push_back(sounds[c % sounds.size()]);
      monitor_.push_back(static_cast<int>(std::ranges::find(all, outputs.back()) - all.begin()));
    }
    guards.resize(outputs.size(), combine_limits(OutputTarget::Sound, {}));
    for (auto& guard : guards) guard.feedback = {false, false};
  }

  BlockProcessor& processor() override { return *this; }
  Player& instrument() override { return *built_.instrument; }
  Player* plant() override { return built_.plant.get(); }

  Edit read_edit() override {
    return edit_by([this](Edit& edit) {
      const auto read = std::make_shared<Read>(read_scene(setup_));
      edit.files = files_of(read->scene);
      if (read->compiled.delay_frames != built_.delay_frames)
        exit_with({Errc::BadArgument, setup_.target.file.string(),
                   "the delay cannot be changed during playback", "start again"});
      edit.take_over = [this, read](Guarded&) { take_over(read->compiled); };
    });
  }

  std::vector<PortEnergy> ports() const override { return ports_.energies(setup_.rate); }
  std::vector<NetworkReport> networks(int block) override {
    SceneTimes times{built_, 0};
    repeat_block(kTimingDuration,
                 [&] { loop_.run(block, [&](const ClosedLoop::Block& part) { times.add(part.frames); }); });
    return times.networks();
  }

  std::optional<Seconds> world_delay() const override { return setup_.delay.value_or(scene_.delay); }
  WorldVerdict judge(Seconds delay, const std::map<std::string, ControlValue>& controls,
                     const std::function<bool()>& go_on) const override {
    return judge_world(setup_.target, setup_.in, {delay, setup_.rate, controls}, go_on);
  }

  std::vector<std::string> gestures() override {
    std::vector<std::string> names;
    for (const auto& planned : built_.plant->plan().controls) names.push_back(planned.control.name);
    return names;
  }
  bool set_gesture(int gesture, double value) override {
    const auto names = gestures();
    if (gesture < 0 || gesture >= std::ssize(names)) return false;
    return built_.plant->post({JournalEntry::kNow, JournalEntry::Kind::ControlChange,
                               built_.plant->control_index(names[index(gesture)]), value});
  }
  bool can_strike() const override { return !built_.plant->plan().controls.empty(); }
  bool strike() override {
    auto& plant = *built_.plant;
    if (!can_strike()) return false;
    const auto down = std::llround(frames_in(Seconds{kStrikeSeconds}, setup_.rate));
    const std::int64_t up = plant.frame() + max_frames_ + down;
    using Kind = JournalEntry::Kind;
    return plant.post({JournalEntry::kNow, Kind::ControlChange, kStrikeControl, 1.0}) &&
           plant.post({up, Kind::ControlChange, kStrikeControl, 0.0});
  }

 private:
  std::vector<std::filesystem::path> files_of(const SceneSpec& scene) const {
    std::vector<std::filesystem::path> all = {setup_.target.file};
    for (const auto& part : scene.parts)
      if (part.graph != nullptr) add_files(*part.graph, all);
    return all;
  }

  void take_over(CompiledScene& compiled) {
    watch_paths(guarded_, *compiled.instrument);
    if (names_of(compiled.plant_taps) != names_of(built_.plant_taps)) watching_ = false;
    or_exit(built_.instrument->replace(std::move(compiled.instrument)));
    or_exit(built_.plant->replace(std::move(compiled.plant)));
  }

  Status prepare(const StreamFormat& format) override {
    max_frames_ = format.max_frames;
    if (auto status = loop_.prepare(format.sample_rate, format.max_frames); !status) return status;
    // The stick of a strike before a reconnection would never be released.
    if (!built_.plant->plan().controls.empty())
      (void)built_.plant->post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, kStrikeControl, 0.0});
    // The simulated card is on from the first frame, as when the scene is rendered; the real one starts
    // softly.
    guarded_.skip_soft_start();
    return {};
  }

  void process(const BlockIo& io) noexcept override {
    io_ = &io;
    done_ = 0;
    loop_.run(io.frames, listener_);
  }

  void copy_monitor(const ClosedLoop::Block& block) noexcept {
    const auto& from = plays_sensors_ ? block.sensors : block.drives;
    for (std::size_t c = 0; c < monitor_.size(); ++c)
      std::transform(from[monitor_[c]], from[monitor_[c]] + block.frames, io_->out[c] + done_,
                     [this](double sample) { return gain_ * sample; });
    done_ += block.frames;
    if (watching_.load(std::memory_order_relaxed)) ports_.take(*built_.plant, block.frames);
  }

  PerformerSetup setup_;
  SceneSpec scene_;  ///< as it was at first
  BuiltScene built_;
  PortWatches ports_;
  std::atomic<bool> watching_ = true;  ///< its signals lie where they did
  Guarded guarded_;
  ClosedLoop loop_;
  double gain_ = scene_.monitor_gain;
  std::vector<int> monitor_;  ///< channels of the instrument's outputs, or of its inputs, for each speaker
  bool plays_sensors_ = false;
  ClosedLoop::Listener listener_;
  int max_frames_ = 0;
  const BlockIo* io_ = nullptr;
  int done_ = 0;
};

}  // namespace

std::unique_ptr<Performer> make_instrument(PerformerSetup setup) {
  return std::make_unique<LiveInstrument>(std::move(setup));
}

std::unique_ptr<Performer> make_world(PerformerSetup setup) {
  auto read = read_scene(setup);
  announce_raises(read.scene.drives, *read.compiled.instrument);
  return std::make_unique<LiveWorld>(std::move(setup), std::move(read));
}

}  // namespace tactus::app
