#pragma once

#include <string>
#include <vector>

#include "tests/conformance/extremes/extreme_case.h"

namespace tactus::test {

/// A kind of file, with a text in which every section is right.
struct FileKind;

/// One number of one key of a file is extreme.
struct FieldCase {
  const FileKind* kind = nullptr;
  std::string section;  ///< "drives.woofer"; empty: the top of the file
  FieldType field{};
  std::string shape = "@";  ///< what stands behind "key = ", with "@" for the number
  double value = 0;

  std::string name() const;
  std::string family() const;  ///< "scene"
};

/// Every number of every key of scene, graph, rig and profile files. A section that the text of its kind
/// lacks is reported by `missing_sections`.
std::vector<FieldCase> field_cases();
std::vector<std::string> missing_sections();
/// [control] Loads the file, and plays what can be played in a few seconds.
Judgement judge(const FieldCase& one);

}  // namespace tactus::test
