#pragma once
// Thread: [control]

#include <filesystem>
#include <iosfwd>

#include "engine/core/error.h"
#include "engine/graph/file/spec.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// A terminal with somebody who answers questions.
struct Dialog {
  std::istream& in;
  std::ostream& out;
  bool take_defaults = false;  ///< shows nothing, and takes what each question proposes
};

/// Asks what is unknown about an instrument on a device, and makes a rig of the answers. Each question is
/// shown with its default, which Enter takes, and is asked again after an answer that makes no sense. All
/// defaults give a rig with conservative limits. `device`: as it was opened, with so many channels;
/// `profiles`: those of the rig's file. Throws a CommandError: Missing, at the end of the input.
Rig ask_for_rig(const GraphSpec& instrument, Rig::Device device, int device_inputs, int device_outputs,
                const ProfilePlaces& profiles, const Dialog& dialog);

/// Writes a rig, whole or not at all. Asks before it overwrites a file, except with `force`. Errors: BadFile.
Status save_rig(const Rig& rig, const std::filesystem::path& file, const Dialog& dialog, bool force);

}  // namespace tactus::app
