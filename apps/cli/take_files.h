#pragma once
// Thread: [control]

#include <filesystem>

#include "backends/take/take.h"
#include "engine/graph/file/load.h"
#include "engine/graph/node_type.h"
#include "engine/rig/rig.h"
#include "engine/runtime/player.h"

namespace tactus::app {

/// What a take keeps of a graph: its texts as they were read, and fingerprints of the sound files that its
/// nodes play. `root`: the folder that no path leaves.
TakeFiles take_files(const LoadedGraph& graph, const NodeTable& table, const std::filesystem::path& root);

/// [control & prepared] The header of a take of this engine behind this guard, as they are before the stream
/// starts. Still to be filled in: `program`, `files`, `taps` and what the rig does.
TakeHeader take_header(const Player& engine, const Guarded& guarded);

/// What the rig of a take did: its text, and the ports that it left out.
void add_rig(const Rig& rig, const std::string& text, TakeHeader& header);

/// Where the controls of a version of a graph start: for TakeHeader and TakeEdit.
std::map<std::string, double> take_settings(const Plan& schedule);

/// Writes the graph of a take below `folder`, with copies of today's sound files. Gives the file to load.
/// Errors: BadFile for a path that would lead out of the folder, and for a sound file that is gone or not
/// what it was.
Result<std::filesystem::path> unpack(const TakeFiles& files, const std::filesystem::path& folder);

}  // namespace tactus::app
