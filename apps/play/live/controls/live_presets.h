#pragma once
// Thread: [control, one thread]

#include <filesystem>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/rig/preset.h"

namespace tactus::app {

/// The presets of what plays. Files are read and written on threads of their own: no function waits for one.
class LivePresets {
 public:
  /// A preset that was read, to be applied now.
  struct Recalled {
    std::string name;
    Preset preset;
    Seconds ramp{0.0};
  };

  explicit LivePresets(std::filesystem::path folder) : folder_(std::move(folder)) { list(); }

  /// As of a moment ago, sorted.
  const std::vector<std::string>& names() const { return names_; }
  /// How often they changed.
  int version() const { return version_; }
  /// `controls`: those of the instrument. While another one is being read or written, nothing happens but a
  /// message.
  void recall(const std::string& name, Seconds ramp, std::vector<FlatControl> controls);
  /// Replaces one of that name. The values are those of `controls`.
  void save(const std::string& name, std::vector<FlatControl> controls);
  /// The first name that is free: "preset 1", "preset 2" and so on.
  std::string free_name() const;

  /// To be called often: a preset that was read.
  std::optional<Recalled> tick();
  /// Messages for the user since the last call.
  std::vector<std::string> take_messages() { return std::exchange(messages_, {}); }

 private:
  struct Outcome {
    std::optional<Recalled> recalled;
    std::vector<std::string> messages;
  };

  bool busy();
  void list();
  std::filesystem::path file_of(const std::string& name) const { return folder_ / (name + ".toml"); }

  std::filesystem::path folder_;
  std::vector<std::string> names_;
  int version_ = 0;
  std::future<std::vector<std::string>> listing_;
  std::future<Outcome> working_;
  std::vector<std::string> messages_;
};

}  // namespace tactus::app
