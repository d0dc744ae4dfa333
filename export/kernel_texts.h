#pragma once

// Thread: [control].

#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/embedded_file.h"

namespace tactus {

/// The headers of kernels, by their paths in the source tree.
std::span<const EmbeddedFile> kernel_files();

/// One declaration at the top level of a kernel header: a type, a function, a constant or a macro.
struct KernelItem {
  std::string_view path;           ///< of its file
  std::string text;                ///< with the comment above it
  std::string code;                ///< without comments
  std::vector<std::string> names;  ///< that it declares
  std::set<std::string> uses;      ///< identifiers that it mentions
  bool is_type = false;  ///< a type or a macro, which headers may contain; else a function or a constant
};

/// All declarations of a kernel header.
std::vector<KernelItem> kernel_items(const EmbeddedFile& file);

/// How the text of kernels is taken.
struct KernelChoice {
  /// Files whose declarations take the place of those of the same name in other files.
  std::vector<std::string> instead = {};
  /// Files that are not used otherwise.
  std::vector<std::string> without = {};
};

/// What code that mentions `identifiers` needs of the kernels, each declaration behind those that it uses.
std::vector<KernelItem> needed_kernel_items(const std::set<std::string>& identifiers,
                                            const KernelChoice& choice);

/// The identifiers of a C text outside its comments.
std::set<std::string> identifiers_of(std::string_view text);

/// The `entry`th element of the array that is `name`, braces included.
std::string kernel_array_entry(const std::string& name, int entry);

}  // namespace tactus
