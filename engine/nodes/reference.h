#pragma once

#include <string>

#include "engine/graph/node_type.h"

namespace tactus {

/// [any] "choice", "whole number", …: what a setting is, for people.
const char* setting_kind_name(Setting::Kind kind);
/// [control] All types by group, a line each. Text, here and below, is at most 100 columns
/// wide, but for examples.
std::string reference_overview(const NodeTable& table);
/// [control] One type in full: equation, ports with units, ranges and defaults, settings, an example, the
/// source.
std::string reference_text(const NodeType& type);
/// [control] The elements of networks.
std::string network_reference();
/// [control] Those of worlds.
std::string world_reference();
/// [control] All of it as docs/nodes.md.
std::string reference_markdown(const NodeTable& table);

}  // namespace tactus
