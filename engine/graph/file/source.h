#pragma once

// Thread: [control]

#include <memory>
#include <string>

namespace tactus {

/// Where something stands in a graph file. The file's name is shared by all that was read from it.
struct Source {
  std::shared_ptr<const std::string> file;
  int line = 0;
  int column = 0;

  /// "file:line:column", as compilers print it.
  std::string text() const {
    if (!file) return {};
    return line > 0 ? *file + ":" + std::to_string(line) + ":" + std::to_string(column) : *file;
  }
};

}  // namespace tactus
