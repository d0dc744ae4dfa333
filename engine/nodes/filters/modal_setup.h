#pragma once

// Thread: [control].

#include <cstddef>
#include <vector>

#include "engine/nodes/filters/mode_table.h"

namespace tactus {

/// What a `modal` is made of.
struct ModalSetup {
  ModeTable table;
  std::vector<double> gains;
  std::vector<std::size_t> modes;  ///< those of the table that may sound; rising
};

/// Errors: OutOfRange.
Result<ModalSetup> modal_setup(const NodeSetup& setup);

}  // namespace tactus
