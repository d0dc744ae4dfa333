#include "apps/cli/console.h"
#include "apps/cli/take_files.h"
#include "apps/play/live/performer.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"
#include "engine/rig/rig_inputs.h"
#include "engine/scene/guard_report.h"

namespace tactus::app {
namespace {

class LiveInstrument final : public Performer {
 public:
  explicit LiveInstrument(PerformerSetup setup) : setup_(std::move(setup)) {
    files_ = {setup_.file};
    auto plan = compile_files();
    if (setup_.rig) wiring_ = or_exit(wire_rig(*setup_.rig, *plan));
    wiring_.drives = apply(setup_.guard, std::move(wiring_.drives), setup_.root);
    engine_ = std::make_unique<Player>(std::move(plan));
    loaded_ = std::move(read_);
    if (RigInputs::needed(wiring_.input_scales, setup_.padding_frames))
      rig_inputs_.emplace(*engine_, wiring_.input_scales, setup_.padding_frames);
  }

  BlockProcessor& processor() override {
    if (rig_inputs_) return *rig_inputs_;
    return *engine_;
  }
  Player& instrument() override { return *engine_; }
  std::vector<std::string> inputs() const override { return engine_->plan().input_names; }
  std::vector<std::string> outputs() const override { return output_names(engine_->plan()); }
  std::vector<GuardedChannel> guards() const override {
    auto channels = guarded_channels(engine_->plan(), wiring_.drives);
    if (setup_.rig) return channels;
    for (auto& channel : channels)
      if (channel.kind == DriveGuard::Kind::Audio) channel = {DriveGuard::Kind::Drive, cautious_limits()};
    return channels;
  }
  std::vector<int> in_map() const override { return wiring_.in_map; }
  std::vector<int> out_map() const override { return wiring_.out_map; }
  void describe(TakeHeader& header) const override {
    header.files = take_files(loaded_, standard_nodes(), setup_.root);
    header.input_scales = wiring_.input_scales;
    header.padding_frames = setup_.padding_frames;
    if (setup_.rig) add_rig(*setup_.rig, to_text(*setup_.rig), header);
  }

  void edit() override {
    or_exit(engine_->replace(compile_files()));
    loaded_ = std::move(read_);
  }

 private:
  std::unique_ptr<Plan> compile_files() {
    auto loaded = load_graph_leniently(setup_.file, setup_.root);
    if (loaded.spec == nullptr) throw CommandError{loaded.errors};
    read_ = loaded;
    files_.clear();
    add_files(*loaded.spec, files_);
    name_ = loaded.spec->name;
    if (setup_.rig) {
      for (auto& mistake : check_rig(*setup_.rig, *loaded.spec)) loaded.errors.push_back(std::move(mistake));
      loaded.spec = without_left_out(*setup_.rig, loaded.spec);
    }
    CompileOptions options;
    options.sample_rate = setup_.rate;
    options.system_delay =
        Seconds{setup_.delay.value_or(0_s).value + setup_.padding_frames / setup_.rate.value};
    if (options.system_delay.value > 0) announce_delay(*loaded.spec, options.system_delay.value);
    options.controls = setup_.controls;
    return or_exit(compile(loaded, standard_nodes(), options));
  }

  PerformerSetup setup_;
  RigWiring wiring_;
  LoadedGraph loaded_, read_;  ///< that plays; that was read last
  std::unique_ptr<Player> engine_;
  std::optional<RigInputs> rig_inputs_;
};

}  // namespace

std::unique_ptr<Performer> make_instrument(PerformerSetup setup) {
  return std::make_unique<LiveInstrument>(std::move(setup));
}

void add_files(const GraphSpec& graph, std::vector<std::filesystem::path>& files) {
  if (graph.file.file) files.emplace_back(*graph.file.file);
  for (const auto& [use, part] : graph.parts)
    if (part != nullptr) add_files(*part, files);
}

}  // namespace tactus::app
