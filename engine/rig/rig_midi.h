#pragma once

#include <string>
#include <vector>

#include "engine/graph/file/error_list.h"
#include "engine/graph/file/field.h"
#include "engine/rig/rig.h"

namespace tactus {

/// [any] The keys of an entry of [midi].
const SectionType& midi_fields();

/// `[midi]` of a rig:  strength = { device = "nanoKONTROL", channel = 1, control = 7 }
std::vector<RigMidi> read_midi(const Value::Table& rig, ErrorList& mistakes);

/// The line of one, as `read_midi` reads it.
std::string to_text(const RigMidi& midi);

}  // namespace tactus
