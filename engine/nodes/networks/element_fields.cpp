#include "engine/nodes/networks/element_fields.h"

namespace tactus {

std::vector<std::string> element_keys(ElementType::Ends ends, const std::vector<ElementField>& fields,
                                      const std::vector<Setting>& settings) {
  using enum ElementType::Ends;
  std::vector<std::string> keys = {"type"};
  if (ends == On || ends == Against) keys.push_back("on");
  if (ends == Against) keys.push_back("against");
  if (ends == Between) keys.push_back("between");
  for (const auto& field : fields) keys.push_back(field.name);
  for (const auto& setting : settings) keys.push_back(setting.name);
  return keys;
}

void check_alternatives(const NodeSpec& element, const std::vector<ElementField>& fields,
                        const std::string& owner, ErrorList& errors) {
  for (const auto& field : fields) {
    if (field.instead_of.empty()) continue;
    const auto* one = find(element.fields, field.instead_of);
    const auto* other = find(element.fields, field.name);
    if (one != nullptr && other != nullptr)
      errors.add(Errc::Duplicate, other->at,
                 owner + " has both '" + field.instead_of + "' and '" + field.name + "'",
                 "remove one of them");
    if (field.one_required && one == nullptr && other == nullptr)
      errors.add(Errc::Missing, element.at,
                 owner + " lacks '" + field.instead_of + "' or '" + field.name + "'", "give one of them");
  }
}

}  // namespace tactus
