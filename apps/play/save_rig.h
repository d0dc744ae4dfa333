#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// Something about a rig that cannot be known.
struct RigQuestion {
  std::string text;
  std::string on_enter;  ///< the answer that an empty line stands for; empty: there is none
};

/// Asks for what cannot be known of an instrument on a device, one question after the other, and makes a rig
/// of the answers. Pure: whoever holds it reads the questions and gives the answers. Taking every default
/// gives a rig with cautious limits.
class RigInterview {
 public:
  /// `device`: as it was opened. `root`: the folder with the profiles.
  RigInterview(const GraphSpec& instrument, Rig::Device device, int device_inputs, int device_outputs,
               std::filesystem::path root);

  /// Nothing: all was asked.
  std::optional<RigQuestion> question() const;
  /// An answer that makes no sense changes nothing, and the error says what would.
  Status answer(const std::string& text);
  const Rig& rig() const { return rig_; }

  // Its steps know where it is.
  RigInterview(const RigInterview&) = delete;
  RigInterview& operator=(const RigInterview&) = delete;

 private:
  struct Step {
    std::function<std::optional<RigQuestion>()> ask;  ///< nothing: this need not be asked any more
    std::function<Status(const std::string&)> take;
  };

  void add(std::function<std::optional<RigQuestion>()> ask, std::function<Status(const std::string&)> take);
  void ask_input(const EntrySpec& port, std::size_t index);
  void ask_output(const EntrySpec& port, std::size_t index);
  void ask_actuators();
  void skip_needless();
  Status take_channels(const std::string& text, RigPort& port, int there, bool shared);
  Status take_actuators(const std::string& text);
  Status take_profile(const std::string& text, RigOutput& output);
  bool used_by_output(int channel) const;

  Rig rig_;
  int device_inputs_, device_outputs_;
  std::filesystem::path root_;
  std::vector<Step> steps_;
  std::size_t next_ = 0;
};

/// [control] Holds the interview on a terminal: shows each question with its default, takes Enter for it, and
/// asks again after nonsense. `take_defaults`: asks nobody. Errors: Missing, at the end of the input.
Result<Rig> hold_interview(RigInterview& interview, std::istream& in, std::ostream& out, bool take_defaults);

/// [control] Writes a rig, whole or not at all. A file that is there is asked for on `in`; `force`: is
/// overwritten. Errors: BadFile.
Status save_rig(const Rig& rig, const std::filesystem::path& file, std::istream& in, std::ostream& out,
                bool force);

/// [control] Writes a rig over its file, and keeps what that was beside it with a "~". Errors: BadFile.
Status replace_rig(const Rig& rig, const std::filesystem::path& file);

}  // namespace tactus::app
