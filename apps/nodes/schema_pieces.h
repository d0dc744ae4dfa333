#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/graph/node_type.h"
#include "engine/nodes/networks/network_elements.h"

namespace tactus::schema {

using Json = nlohmann::ordered_json;

/// A string that is not empty.
Json text(const std::string& description);
/// A number or a quantity ("15 ms"); the bounds hold for bare numbers, which count in SI.
Json quantity(const std::string& description, double low = -kUnlimited, double high = kUnlimited);
/// Where a signal belongs: a number, an expression, a list of lanes or a spread over lanes.
Json signal(const std::string& description, double low = -kUnlimited, double high = kUnlimited);
Json whole_number(const std::string& description, double low, double high);
Json choice(const std::string& description, const std::vector<std::string>& words);
/// [x, y], [a, b, …]: at least one item, at most `most` unless that is 0.
Json list(const std::string& description, Json items, int least = 1, int most = 0);

/// Two quantities, the lower one first.
Json range(const std::string& description);

/// What every file begins with.
Json heading();

/// An object with just these keys; nothing else is allowed in it.
Json object(const std::string& description, Json properties, const std::vector<std::string>& required = {});
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
