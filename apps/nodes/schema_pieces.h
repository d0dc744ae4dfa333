#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/graph/file/field.h"
#include "engine/graph/node_type.h"
#include "engine/nodes/networks/network_elements.h"

// Thread: [control]

namespace tactus::schema {

using Json = nlohmann::ordered_json;

/// A number or a quantity ("15 ms"); the bounds hold for bare numbers, which count in SI.
Json quantity(const std::string& description, double low = -kUnlimited, double high = kUnlimited);
/// Where a signal belongs: a number, an expression, a list of lanes or a spread over lanes.
Json signal(const std::string& description, double low = -kUnlimited, double high = kUnlimited);

/// An object with the keys of a section; nothing else is allowed in it.
Json object(const SectionType& section);
/// An object of entries with free names, each like `entry`.
Json entries(const std::string& description, Json entry);
Json reference(const std::string& definition);

/// A node of one type, or an element of one type: its ports, settings and ends.
Json node(const NodeType& type);
Json element(const ElementType& type);

/// For `anyOf`: what an editor may complete from, which forbids nothing. Many editors complete from
/// alternatives only; but a checker that looks through alternatives says "none of them" where a condition
/// says what is wrong.
Json hints(Json alternatives);
/// An object whose `type` decides what it is: one definition called `prefix` + type for each of `types`.
Json by_type(const std::string& prefix, const std::vector<std::string>& types);

}  // namespace tactus::schema
