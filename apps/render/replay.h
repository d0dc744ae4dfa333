#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "backends/take/replay.h"
#include "engine/rig/rig_inputs.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// A graph that was built again from what a take keeps, as it was when it was recorded.
class RebuiltGraph {
 public:
  /// [control] Errors: of the texts; BadFile for sound files that are not what they were.
  static Checked<std::unique_ptr<RebuiltGraph>> build(const TakeHeader& header);
  /// Removes the texts that it unpacked.
  ~RebuiltGraph();
  RebuiltGraph(const RebuiltGraph&) = delete;
  RebuiltGraph& operator=(const RebuiltGraph&) = delete;

  const std::string& name() const { return name_; }
  Player& engine() { return *engine_; }
  /// What the guard takes: the engine, and before it what the rig did to the inputs.
  BlockProcessor& processor() { return rig_ == nullptr ? static_cast<BlockProcessor&>(*engine_) : *rig_; }
  /// [control] What `ReplayHost::replace` wants.
  Status replace(const TakeEdit& edit);

 private:
  explicit RebuiltGraph(const TakeHeader& header);
  Checked<std::unique_ptr<Plan>> compile_version(const TakeFiles& files,
                                                 const std::map<std::string, double>& settings);

  const TakeHeader& header_;
  std::filesystem::path folder_;
  std::string name_;
  std::unique_ptr<Player> engine_;
  std::unique_ptr<RigInputs> rig_;
};

/// The changes of controls of a take as another graph counts them, by name; those that it does not have are
/// left out, like edits.
std::vector<JournalEntry> journal_for(const Take& take, const Player& engine);

/// Which recorded sensor each input of a graph hears, by name; -1: none.
std::vector<int> sensors_for(const TakeHeader& header, const std::vector<std::string>& inputs);

/// What the rig made of these sensors: its scale of each.
std::vector<double> scales_for(const TakeHeader& header, const std::vector<int>& sensors);

/// "the same, bit for bit, for 12.345 s", or where it is not, or why that cannot be said.
std::string verdict(const Take& take, const Replayed& replayed);
/// It could be promised, and it is the same.
bool is_same(const Take& take, const Replayed& replayed);

}  // namespace tactus::app
