#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "engine/graph/file/spec.h"
#include "engine/nodes/networks/network_elements.h"

// What the elements of networks and of worlds have in common in a file.
namespace tactus {

/// The keys of an element of a type.
std::vector<std::string> element_keys(ElementType::Ends ends, const std::vector<ElementField>& fields,
                                      const std::vector<Setting>& settings);

/// Reports fields that exclude each other and are both there, and those of which one is required. `owner` is
/// how messages call the element: "spring 's'".
void check_alternatives(const NodeSpec& element, const std::vector<ElementField>& fields,
                        const std::string& owner, ErrorList& errors);

}  // namespace tactus
