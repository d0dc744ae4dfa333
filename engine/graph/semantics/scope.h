#pragma once

// Thread: [control].

#include <filesystem>
#include <map>
#include <set>
#include <string>

#include "engine/core/error.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/value.h"
#include "engine/graph/semantics/flat_graph.h"

namespace tactus {

/// What the names of one file mean: signals by their full dotted name ("hit", "hit.level",
/// "drum.lens.force"). Parts show only their outputs.
class Scope {
 public:
  /// A name given twice was reported already and means neither.
  void add(const std::string& name, int signal) {
    if (!signals_.emplace(name, signal).second) hide(name);
  }
  /// A name that exists but is no signal by itself; `why` is the remedy.
  void explain(const std::string& name, std::string why) { not_signals_[name] = std::move(why); }

  /// A name whose own error was reported already: it and all below it are FlatGraph::kMissing.
  void hide(const std::string& name) { hidden_.insert(first_word(name)); }
  /// What is not found below `name` ("": at all) may be in a part that could not be read:
  /// FlatGraph::kMissing.
  void tolerate(const std::string& name) { tolerated_.insert(name); }

  /// The signal, or an error with the nearest right name.
  Result<int> find(const std::string& name, const Source& at) const;
  /// Whether the signal was found under any of its names.
  bool is_read(int signal) const { return read_.contains(signal); }
  /// The same of the signal with this name; true if there is none.
  bool is_read(const std::string& name) const {
    const auto signal = signals_.find(name);
    return signal == signals_.end() || is_read(signal->second);
  }

 private:
  static std::string first_word(const std::string& name) { return name.substr(0, name.find('.')); }
  bool tolerates(const std::string& name) const {
    return tolerated_.contains("") || tolerated_.contains(first_word(name));
  }

  /// The name that may have been meant; "" if none is near.
  std::string suggestion(const std::string& name) const;

  std::map<std::string, int> signals_;
  std::map<std::string, std::string> not_signals_;
  std::set<std::string> hidden_, tolerated_;
  mutable std::set<int> read_;
  mutable int suggestions_ = 0;
};

/// Names that must differ from each other: those of the inputs, controls, nodes and networks of a file, for
/// example. A name is [a-z][a-z0-9_]*, no unit of more than one letter ("ms" would be read as one behind a
/// number; the letter of "2 * s" is not), and none that expressions reserve (see `is_reserved`).
class NameSpace {
 public:
  /// AfterDots: expressions name them as "part.output", or not at all; they may be called like a constant.
  enum class Names { InExpressions, AfterDots };
  explicit NameSpace(Names names = Names::InExpressions) : names_(names) {}

  /// `kind` is what messages call it: "node", "control".
  void add(const std::string& name, const std::string& kind, const Source& at, ErrorList& errors);

 private:
  struct Owner {
    std::string kind;
    Source at;
  };
  Names names_;
  std::map<std::string, Owner, std::less<>> owners_;
};

/// A value in a signal port as a Expression: a number, a quantity or expression in a string, a list of lanes,
/// or a spread { from, to, curve } over the lanes. After an error, the missing signal.
Expression bind_signal(const Value& value, const Scope& scope, ErrorList& errors);

/// A number with its unit, SI; `bare`: without one.
Expression number_expression(double si, Dimension dimension, bool bare, const Source& at);

/// Replaces what an error left out, and raises no second error.
Expression missing_signal(const Source& at);

/// A setting read from the `fields` of its node, or its fallback. `folder` is where files start.
SettingValue bind_setting(const Setting& setting, const Value::Table& fields,
                          const std::filesystem::path& folder, const std::string& owner, const Source& at,
                          ErrorList& errors);

}  // namespace tactus
