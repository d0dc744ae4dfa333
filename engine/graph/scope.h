#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/core/error.h"
#include "engine/graph/flat_graph.h"

namespace tactus {

/// What the names of one file mean: signals by their full dotted name ("hit", "hit.level",
/// "drum.lens.force"). Parts show only their outputs.
class Scope {
 public:
  void add(const std::string& name, int signal) { signals_[name] = signal; }
  /// A name that exists but is no signal by itself; `why` says what to write instead.
  void explain(const std::string& name, std::string why) { not_signals_[name] = std::move(why); }

  /// A name whose own mistake was reported already: it and all below it are FlatGraph::kMissing.
  void hide(const std::string& name) { hidden_.insert(name); }

  /// The signal, or an error with the nearest right name.
  Result<int> find(const std::string& name, const Source& at) const;

 private:
  std::map<std::string, int> signals_;
  std::map<std::string, std::string> not_signals_;
  std::set<std::string> hidden_;
};

}  // namespace tactus
