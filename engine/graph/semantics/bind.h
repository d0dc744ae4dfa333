#pragma once

// Thread: [control].

#include <filesystem>

#include "engine/graph/file/mistakes.h"
#include "engine/graph/file/value.h"
#include "engine/graph/node_type.h"
#include "engine/graph/semantics/flat_graph.h"
#include "engine/graph/semantics/scope.h"

namespace tactus {

/// A value in a signal port as a Expression: a number, a quantity or expression in a string, a list of lanes,
/// or a spread { from, to, curve } over the lanes. After an error, the missing signal.
Expression bind_signal(const Value& value, const Scope& scope, Mistakes& mistakes);

/// Replaces what an error left out, and raises no second error.
Expression missing_signal(const Source& at);

/// A setting read from the `fields` of its node, or its fallback. `folder` is where files start.
SettingValue bind_setting(const Setting& setting, const Value::Table& fields,
                          const std::filesystem::path& folder, const std::string& owner, const Source& at,
                          Mistakes& mistakes);

}  // namespace tactus
