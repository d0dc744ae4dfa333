#pragma once

#include <filesystem>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "engine/guard/guarded.h"
#include "engine/runtime/player.h"

namespace tactus::realtime {

/// Something that a sound card would call back, with a control side that moves it meanwhile.
class Subject {
 public:
  virtual ~Subject() = default;
  /// [realtime] One block.
  virtual void callback() noexcept TACTUS_NONBLOCKING = 0;
  /// [audio thread, not watched] Before each callback; may wait for what this one is to meet.
  virtual void await() {}
  /// [control] What a person at the controls might do: moves controls, mutes, disarms, reads every counter.
  virtual void disturb(std::mt19937& random) = 0;
  /// [control] How many edited versions were put in its place while it played.
  virtual long edits() const { return 0; }
  std::string name;
};

using Subjects = std::vector<std::unique_ptr<Subject>>;

/// Every scene below `instruments` as it is played, the graph of every_node.h, once as it is and once
/// replaced over and over by its edited version and back, and a world that messages change; all in blocks of
/// `frames`. Throws a text: what is wrong.
Subjects all_subjects(const std::filesystem::path& instruments, int frames);

}  // namespace tactus::realtime
