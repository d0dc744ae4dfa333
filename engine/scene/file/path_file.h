#pragma once

#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/graph/file/load.h"

namespace tactus {

/// What a drive does to a sensor, as it was measured: an impulse response, a tap each sample at `rate`. Its
/// file is a graph of one node, a fir called 'path' from one input to one output, so that a scene can use it
/// as its plant or as a part of it.
struct PathFile {
  std::string name, about, source;
  Hertz rate;
  std::vector<double> taps;
};

/// [control] The file. Taps have eight digits: each is wrong by 5e-8 of itself at most, and so the response
/// by 5e-8 of the sum of all |taps|, which is what the float32 of a recording loses too. All else reads back
/// exactly.
std::string to_text(const PathFile& path);

/// [control] All errors of such a file at once: those of any graph, and all that a path file cannot contain.
Checked<PathFile> read_path(LoadedGraph loaded);

}  // namespace tactus
