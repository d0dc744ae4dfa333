#pragma once
// Thread: [control]

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/file/load.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// Where the profiles of a rig are: a path is relative to the rig; a name is looked up in the folder of the
/// rig, in the "instruments" above it, in the
/// user's own instruments and in the shipped ones. The instrument that is played has no
/// say: it may be a stranger's, and the rig states the limits of the user's actuators.
ProfilePlaces profile_places(const std::filesystem::path& rig_file);

/// Where a name given to --profile is looked up: in the user's own and the shipped instruments, then in the
/// current folder and its "instruments".
ProfileFolders option_profile_folders();

/// "a constant force decays with a time constant of 79.58 ms = 1/(2 pi 2 Hz)": what a card's AC coupling
/// does.
std::string decay_text(Hertz highpass);

/// Throws a CommandError with all errors of the file, and for devices that cannot be played together.
Rig open_rig(const std::filesystem::path& file);

/// The instrument as the rig plays it: outputs that are left out are gone, inputs that are left out rest at
/// 0. What of the rig does not fit the instrument is among its errors.
void fit(LoadedGraph& instrument, const Rig& rig);

/// Reads a rig again, changes it and writes it over its file, whose former version gets the ending "~". What
/// was edited since the rig was read first stays. Gives the errors: those of the file; BadFile if the rig is
/// for another device than `device` by now, or cannot be written.
std::vector<Error> change_rig(const std::filesystem::path& file, const Rig::Device& device,
                              const std::function<void(Rig&)>& change);

}  // namespace tactus::app
