#include "engine/graph/semantics/scope.h"

#include <algorithm>
#include <tuple>

#include "engine/core/dimension.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/semantics/operators.h"

namespace tactus {
std::string Scope::suggestion(const std::string& name) const {
  // Each costs a look at every name: a file with thousands of wrong ones shall not take minutes.
  constexpr int kMostSuggestions = 100;
  if (++suggestions_ > kMostSuggestions) return {};
  std::vector<std::string> names;
  for (const auto& [signal, node] : signals_) names.push_back(signal);
  return nearest_name(name, names);
}

Result<int> Scope::find(const std::string& name, const Source& at) const {
  if (hidden_.contains(first_word(name))) return FlatGraph::kMissing;
  if (const auto it = signals_.find(name); it != signals_.end()) {
    read_.insert(it->second);
    return it->second;
  }
  if (const auto it = not_signals_.find(name); it != not_signals_.end())
    return fail(Errc::UnknownName, at.text(), "'" + name + "' is not a signal", it->second);
  if (tolerates(name)) return FlatGraph::kMissing;
  if (const auto* function = find_function(name))
    return fail(Errc::UnknownName, at.text(), "there is no '" + name + "', only the function",
                "write " + function->use());
  const auto near = suggestion(name), owner = first_word(name);
  if (near.empty() && owner != name && signals_.contains(owner))
    return fail(Errc::UnknownName, at.text(),
                "'" + owner + "' has no output '" + name.substr(owner.size() + 1) + "'",
                "`tactus nodes` lists the outputs of every type");
  return fail(
      Errc::UnknownName, at.text(), "there is no '" + name + "'",
      near.empty() ? "write an input, a control or a node of this file" : "did you mean '" + near + "'?");
}

void NameSpace::add(const std::string& name, const std::string& kind, const Source& at, ErrorList& errors) {
  const auto quoted = "'" + name + "'";
  const auto refuse = [&](const char* because, const char* remedy) {
    errors.add(Errc::Syntax, at, quoted + because + " cannot name " + kind, remedy);
  };
  if (!is_name(name))
    return refuse("", "names begin with a lower-case letter, followed by lower-case letters, digits and _");
  if (name.size() > 1 && is_unit_symbol(name)) return refuse(" is a unit and", "choose another name");
  if (find_constant(name) == nullptr && is_reserved(name))
    return refuse(" is reserved and", "choose another name");
  if (find_constant(name) != nullptr && names_ == Names::InExpressions)
    return refuse(" is a constant of expressions and", "choose another name");
  const auto [owner, is_new] = owners_.try_emplace(name, Owner{kind, at});
  if (is_new) return;
  // The error is the later one in the file, whichever section was read first.
  const bool later = std::tie(at.line, at.column) > std::tie(owner->second.at.line, owner->second.at.column);
  const Owner here = later ? Owner{kind, at} : owner->second;
  const Owner there = later ? owner->second : Owner{kind, at};
  errors.add(Errc::Duplicate, here.at,
             quoted + " cannot name " + here.kind + ": it names " + there.kind + " in line " +
                 std::to_string(there.at.line),
             "choose another name");
}

}  // namespace tactus
