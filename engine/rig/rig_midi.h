#pragma once

#include <string>
#include <vector>

#include "engine/graph/file/field.h"
#include "engine/graph/file/mistakes.h"
#include "engine/rig/rig.h"

namespace tactus {

/// [any] The keys of an entry of [midi].
const SectionType& midi_fields();

/// `[midi]` of a rig:  strength = { device = "nanoKONTROL", channel = 1, control = 7 }
std::vector<RigMidi> read_midi(const Value::Table& rig, Mistakes& mistakes);

/// The line of one, as `read_midi` reads it.
std::string to_text(const RigMidi& midi);

}  // namespace tactus
