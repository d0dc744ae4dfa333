#pragma once

// Thread: [control].

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/semantics/interval.h"
#include "export/program.h"

namespace tactus {

struct ExportedFile {
  std::string name, text;
};

/// What the code of a board needs to know of a program.
struct BoardProgram {
  struct Port {
    std::string name;
    Interval range = {};
    int exponent = 0;  ///< of an integer
  };
  const CProgram* heading = nullptr;
  std::vector<Port> inputs, outputs;
  std::size_t state_bytes = 0;
};

/// What a program is exported for.
struct ExportTarget {
  const char* name;
  const char* about;
  RecurrenceForm recurrence;  ///< by default
  const char* number;         ///< by default
  int machine;                ///< in `machine_types`
  std::vector<ExportedFile> (*files)(const CProgram& program);
  /// Further files, for a board; nullptr: none.
  std::vector<ExportedFile> (*board)(const BoardProgram& program) = nullptr;
  bool converts = false;  ///< the board samples inputs with a converter, whose scale their ranges give
  /// That the state may take, if nothing else is said.
  std::size_t most_bytes = std::numeric_limits<std::size_t>::max();
};

/// The entry of that name, or nullptr.
const ExportTarget* find_export_target(std::string_view name);
std::vector<std::string> export_target_names();

// One function for each, in the file of its name.
std::vector<ExportedFile> c_files(const CProgram& program);
std::vector<ExportedFile> library_files(const CProgram& program);
std::vector<ExportedFile> pd_files(const CProgram& program);
std::vector<ExportedFile> avr_files(const BoardProgram& program);
std::vector<ExportedFile> arduino_files(const BoardProgram& program);
std::vector<ExportedFile> cortex_m_files(const BoardProgram& program);

}  // namespace tactus
