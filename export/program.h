#pragma once

// Thread: [control].

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/guarded.h"
#include "export/number.h"

namespace tactus {

/// How recurrences run.
enum class RecurrenceForm {
  Grid,   ///< in groups of eight frames, with the bits of the engine
  Plain,  ///< frame by frame, as their equations are written
};

/// What does not change while a program runs, or only with its controls.
enum class Pace { Constant, Control, Frame };

struct ProgramPort {
  std::string name, unit, about;
  bool audio = false;
  std::optional<GuardedChannel> limits = {};
};

struct ProgramControl {
  std::string name;   ///< as a C identifier
  std::string about;  ///< "stiffness of the wall, 0 to 20000 N/m, default 400"
  double value = 0, low = 0, high = 0;
  long smooth_frames = 0;
  bool decibel = false;
};

/// A member of the state: "tactus_filter low", "double line_samples[128]".
struct ProgramMember {
  std::string declaration;
  std::string about;
  std::size_t bytes = 0;   ///< with numbers of 8 bytes
  std::string where = {};  ///< in the file
};

/// Statements, each a line or several.
struct Statement {
  std::string text;
  int divisor = 1;  ///< runs in one of so many frames
  int lanes = 0;    ///< more than 0: runs for each `lane` below it

  /// With the loop.
  std::string with_loop() const;
};

/// A graph as C text that still knows no target: kernels have the names that they have in the engine, and
/// numbers are doubles. `s->` is the state of the nodes, `group_position` the frame number modulo
/// 8, `frame_number` the number itself.
struct CProgram {
  std::string name;  ///< a C identifier, which everything that is defined begins with: "haptic_drum"
  std::string title, about, source, file;
  Hertz sample_rate = 48_kHz;
  Seconds system_delay = 0_s;
  RecurrenceForm recurrence = RecurrenceForm::Grid;
  const NumberType* number = nullptr;
  bool guard = true;
  std::string limits_from = {};  ///< for people

  std::vector<ProgramPort> inputs, outputs;
  std::vector<int> read_inputs;  ///< indices of those that something reads
  std::vector<ProgramControl> controls;
  std::vector<std::string> fixed_controls;  ///< what was left out of them, and its value

  std::vector<ProgramMember> members;
  std::vector<std::string> tables;  ///< constants, each a declaration at file scope
  std::size_t table_bytes = 0;
  std::vector<std::string> functions;  ///< at file scope, behind the tables
  std::vector<std::string> start;      ///< statements; the state is all zero before
  std::vector<std::string> follow;     ///< what depends on controls alone
  std::vector<std::string> designs;    ///< the same, at the start of a group of eight frames
  std::vector<std::string> variables;  ///< of a frame, declared at its start
  std::vector<Statement> frame;
  std::vector<std::string> checked;  ///< what, all of it finite, says that no value is non-finite
  std::vector<std::string> faults;   ///< variables that are not 0 where one of several values is non-finite

  bool needs_frame_number() const;
};

}  // namespace tactus
