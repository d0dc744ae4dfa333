#pragma once

#include "engine/graph/file/load.h"

namespace tactus::test {

/// A graph from text that is right, or the errors of the text.
inline Checked<std::shared_ptr<const GraphSpec>> parse_graph(std::string_view text,
                                                             const std::string& file_name) {
  auto loaded = parse_graph_leniently(text, file_name);
  if (!loaded.errors.empty()) return tl::unexpected(std::move(loaded.errors));
  return std::move(loaded.spec);
}

}  // namespace tactus::test
