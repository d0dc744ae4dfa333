#pragma once
// Thread: [control]

#include <map>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/guard/guarded.h"

namespace tactus {

/// What is connected to an output.
enum class OutputTarget {
  Drive,         ///< an actuator
  Sound,         ///< loudspeakers or headphones: an output of kind "audio" in a rig or a simulation
  UnknownSound,  ///< an output of kind "audio" on a device without a rig: it may be an actuator
};

/// One source of limits of an output.
struct LimitSource {
  enum class Kind {
    Profile,       ///< of an actuator, whoever names it
    Ceiling,       ///< the key `ceiling` of an entry
    Take,          ///< recorded limits
    Drive,         ///< built in, for a drive without a profile
    UnknownSound,  ///< built in
    Sound,         ///< built in
  };
  Kind kind = Kind::Profile;
  std::string name;       ///< for messages: "[outputs] woofer"
  DriveLimits limits;     ///< those that this kind of source states count
  std::string file = {};  ///< of a profile
};

/// [any] The limits of an output, limit by limit the lowest (the longest soft start) of all `sources` that
/// state it and of the built-in ones; of equal ones the first is named as the origin. Of two heat or
/// excursion models the one that allows the smaller steady signal counts. Which source states which limit:
/// the table in limits.cpp and docs/drive_guard.md.
GuardedChannel combine_limits(OutputTarget target, const std::vector<LimitSource>& sources);

/// Raises one limit: "ceiling", "slew", "power", "travel", "direct_level" or "direct_time". Errors, at
/// `where`, which leave it as it was: UnknownName; OutOfRange if `text` is no raise, or is one that `check`
/// refuses; those of read_quantity.
Status raise_limit(GuardedChannel& channel, const std::string& limit, const std::string& text,
                   const std::string& where);

/// "0.8", "25 W", "3 mm": the value of a limit in its unit.
std::string limit_text(const std::string& limit, double value);

/// --raise-limit LIMIT=VALUE or OUTPUT.LIMIT=VALUE
struct LimitRaise {
  std::string output;  ///< empty: every drive
  std::string limit, value;

  std::string name() const { return output.empty() ? limit : output + "." + limit; }
};

/// An output of an instrument, or one of its lanes, as in "strings[2]".
struct LimitedOutput {
  std::string name;
  OutputUse use = OutputUse::Drive;
};

/// The sources of limits of all outputs of an instrument.
struct LimitBook {
  std::map<std::string, std::vector<LimitSource>> named;  ///< by the name of an output or of one of its lanes
  std::vector<LimitSource> drives;                        ///< of every drive
  std::vector<LimitRaise> raises;
  bool sound_known = true;  ///< false: outputs of kind "audio" may be actuators (OutputTarget::UnknownSound)

  /// A raise that `raise_limit` refuses for this output has no effect on it.
  GuardedChannel of(const LimitedOutput& output) const;
  /// Does each raise raise a limit of one of `outputs`? Errors: UnknownName if it is for none of them; else
  /// of raise_limit, for the first one.
  Status check_raises(const std::vector<LimitedOutput>& outputs) const;

 private:
  GuardedChannel raised(const LimitedOutput& output, std::size_t raise_count) const;
};

}  // namespace tactus
