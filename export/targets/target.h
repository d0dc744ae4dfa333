#pragma once

// Thread: [control].

#include <string>
#include <string_view>
#include <vector>

#include "export/program.h"

namespace tactus {

struct ExportedFile {
  std::string name, text;
};

/// What a program is exported for.
struct ExportTarget {
  const char* name;
  const char* about;
  RecurrenceForm recurrence;  ///< by default
  const char* number;         ///< by default
  int machine;                ///< in `machine_types`
  std::vector<ExportedFile> (*files)(const CProgram& program);
};

/// The entry of that name, or nullptr.
const ExportTarget* find_export_target(std::string_view name);
std::vector<std::string> export_target_names();

// One function for each, in the file of its name.
std::vector<ExportedFile> c_files(const CProgram& program);
std::vector<ExportedFile> library_files(const CProgram& program);
std::vector<ExportedFile> pd_files(const CProgram& program);

}  // namespace tactus
