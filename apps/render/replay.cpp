#include "apps/render/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <system_error>

#include "apps/cli/take_files.h"
#include "engine/graph/plan/compile.h"
#include "engine/nodes/table.h"
#include "engine/rig/check_rig.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

/// A rig that does nothing but leave these ports out.
Rig leaving_out(const std::vector<std::string>& ports) {
  Rig rig;
  for (const auto& port : ports) {
    rig.inputs.emplace_back().name = port;
    rig.outputs.emplace_back().name = port;
  }
  return rig;
}

fs::path new_folder() {
  static std::atomic<int> count{0};
  const auto ticks = std::chrono::steady_clock::now().time_since_epoch().count();
  return fs::temp_directory_path() / fmt::format("tactus_replay_{}_{}", ticks, count++);
}

std::unique_ptr<RigInputs> rig_of(const TakeHeader& header, BlockProcessor& instrument) {
  if (!RigInputs::needed(header.input_scales, header.padding_frames)) return nullptr;
  return std::make_unique<RigInputs>(instrument, header.input_scales, header.padding_frames);
}

}  // namespace

RebuiltGraph::RebuiltGraph(const TakeHeader& header) : header_(header), folder_(new_folder()) {}

RebuiltGraph::~RebuiltGraph() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

Checked<std::unique_ptr<Plan>> RebuiltGraph::compile_version(const TakeFiles& files,
                                                             const std::map<std::string, double>& settings) {
  // All versions in one place: a node that plays a sound file is another one if the path is another one.
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
  const auto file = unpack(files, folder_);
  if (!file) return tl::unexpected(std::vector{file.error()});
  auto loaded = load_graph_leniently(*file, folder_);
  if (loaded.spec == nullptr) return tl::unexpected(loaded.errors);
  loaded.spec = without_left_out(leaving_out(header_.left_out), loaded.spec);
  name_ = loaded.spec->name;
  CompileOptions options;
  options.sample_rate = header_.sample_rate;
  options.system_delay = header_.system_delay;
  options.taps = header_.taps;
  for (const auto& [control, value] : settings) options.controls[control] = value;
  return compile(loaded, standard_nodes(), options);
}

Checked<std::unique_ptr<RebuiltGraph>> RebuiltGraph::build(const TakeHeader& header) {
  std::unique_ptr<RebuiltGraph> graph{new RebuiltGraph{header}};
  auto schedule = graph->compile_version(header.files, header.settings);
  if (!schedule) return tl::unexpected(schedule.error());
  graph->engine_ = std::make_unique<Player>(std::move(*schedule));
  graph->rig_ = rig_of(header, *graph->engine_);
  return graph;
}

Status RebuiltGraph::replace(const TakeEdit& edit) {
  auto schedule = compile_version(edit.files, edit.settings);
  if (!schedule) return tl::unexpected(schedule.error().front());
  return engine_->replace(std::move(*schedule));
}

std::vector<JournalEntry> journal_for(const Take& take, const Player& engine) {
  // Numbers stay; edits only add some.
  const auto& names = take.edits.empty() ? take.header.controls : take.edits.back().controls;
  std::vector<JournalEntry> entries;
  for (auto entry : take.engine) {
    if (entry.kind == JournalEntry::Kind::ControlChange) {
      const auto number = static_cast<std::size_t>(entry.index);
      entry.index = number < names.size() ? engine.control_index(names[number]) : -1;
      if (entry.index < 0) continue;
    }
    entries.push_back(entry);
  }
  return entries;
}

std::vector<int> sensors_for(const TakeHeader& header, const std::vector<std::string>& inputs) {
  std::vector<int> sensors;
  for (const auto& input : inputs) {
    const auto found = std::find(header.inputs.begin(), header.inputs.end(), input);
    sensors.push_back(found == header.inputs.end() ? -1 : static_cast<int>(found - header.inputs.begin()));
  }
  return sensors;
}

std::vector<double> scales_for(const TakeHeader& header, const std::vector<int>& sensors) {
  std::vector<double> scales;
  for (const int sensor : sensors) {
    const auto known = sensor >= 0 && static_cast<std::size_t>(sensor) < header.input_scales.size();
    scales.push_back(known ? header.input_scales[static_cast<std::size_t>(sensor)] : 1.0);
  }
  return scales;
}

bool is_same(const Take& take, const Replayed& replayed) {
  return !replayed.first_difference && why_not_exact(take).empty();
}

std::string verdict(const Take& take, const Replayed& replayed) {
  const auto seconds = [&](std::int64_t frame) {
    return static_cast<double>(frame) / take.header.sample_rate.value;
  };
  if (is_same(take, replayed))
    return fmt::format("the drives are the same, bit for bit, for {:.3f} s", seconds(replayed.frames));
  const auto why = why_not_exact(take);
  const auto reason = why.empty() ? "" : fmt::format("this take cannot be replayed bit for bit: {}; ", why);
  if (!replayed.first_difference) return reason + "what is there is the same";
  const auto& first = *replayed.first_difference;
  return reason + fmt::format("the drives differ from {:.4f} s on (frame {}): '{}' is {:.9g} and was {:.9g}",
                              seconds(first.frame), first.frame,
                              take.header.outputs[static_cast<std::size_t>(first.channel)], first.replayed,
                              first.recorded);
}

}  // namespace tactus::app
