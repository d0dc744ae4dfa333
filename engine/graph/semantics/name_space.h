#pragma once

#include <map>
#include <string>

#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/source.h"

namespace tactus {

/// Names that must differ from each other: those of the inputs, controls, nodes and networks of a file, say.
/// A name is [a-z][a-z0-9_]*, no unit of more than one letter ("ms" would be read as one behind a number; the
/// letter of "2 * s" is not), and none of `system`, `min`, `max`, `abs`.
class NameSpace {
 public:
  /// `kind` says in messages what is named: "node", "control".
  void add(const std::string& name, const std::string& kind, const Source& at, Mistakes& mistakes);

 private:
  struct Owner {
    std::string kind;
    Source at;
  };
  std::map<std::string, Owner, std::less<>> owners_;
};

}  // namespace tactus
