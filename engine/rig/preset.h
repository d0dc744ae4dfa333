#pragma once
// Thread: [control]

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/field.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

struct PresetValue {
  std::string control;
  double value = 0.0;  ///< SI

  bool operator==(const PresetValue&) const = default;
};

/// Values of controls under a name: a file `presets/NAME.toml` beside an instrument.
/// docs/howto/use_presets.md explains it.
struct Preset {
  std::vector<PresetValue> values;
  std::vector<Error> errors;  ///< of what is left out: unknown controls, values outside of their range
};

/// Its keys, for the reference and the schema.
const SectionType& preset_fields();

/// What of the file fits `controls`. Errors: BadFile, Syntax: it cannot be read at all.
Checked<Preset> load_preset(const std::filesystem::path& file, std::span<const FlatControl> controls);
Checked<Preset> parse_preset(std::string_view text, const std::string& file_name,
                             std::span<const FlatControl> controls);
/// The text of such a file. Reading it gives the same values, to within rounding of their units.
std::string to_text(std::span<const PresetValue> values, std::span<const FlatControl> controls);

/// The folder of presets beside an instrument.
std::filesystem::path preset_folder(const std::filesystem::path& instrument);
/// The names in a folder, sorted; none if there is no such folder.
std::vector<std::string> preset_names(const std::filesystem::path& folder);
/// Errors: BadArgument: it is no name of a file (letters, digits, '_', '-' and spaces; at most 64).
Status check_preset_name(const std::string& name);

}  // namespace tactus
