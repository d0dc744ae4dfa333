#include "engine/graph/semantics/scope.h"

#include "engine/graph/file/nearest.h"

namespace tactus {

std::string Scope::suggestion(const std::string& name) const {
  // Each costs a look at every name: a file with thousands of wrong ones shall not take minutes.
  constexpr int kMostSuggestions = 100;
  if (++suggestions_ > kMostSuggestions) return {};
  std::vector<std::string> names;
  names.reserve(signals_.size());
  for (const auto& [known, signal] : signals_) names.push_back(known);
  return nearest_name(name, names);
}

Result<int> Scope::find(const std::string& name, const Source& at) const {
  if (hidden_.contains(first_word(name))) return FlatGraph::kMissing;
  if (const auto it = signals_.find(name); it != signals_.end()) return it->second;
  if (const auto it = not_signals_.find(name); it != not_signals_.end())
    return fail(Errc::UnknownName, at.text(), "'" + name + "' is not a signal", it->second);
  if (tolerates(name)) return FlatGraph::kMissing;
  const auto near = suggestion(name);
  const auto dot = name.find('.');
  if (near.empty() && dot != std::string::npos && signals_.contains(name.substr(0, dot)))
    return fail(Errc::UnknownName, at.text(),
                "'" + name.substr(0, dot) + "' has no output '" + name.substr(dot + 1) + "'",
                "`tactus nodes` lists the outputs of every type");
  return fail(
      Errc::UnknownName, at.text(), "there is no '" + name + "'",
      near.empty() ? "name an input, a control or a node of this file" : "did you mean '" + near + "'?");
}

}  // namespace tactus
