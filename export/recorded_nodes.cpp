#include "export/recorded_nodes.h"

namespace tactus {

RecordedNodes::RecordedNodes(const NodeTable& table) : table_(table) {
  for (auto& type : table_.types) {
    types_.push_back(std::make_unique<NodeType>(*type));
    types_.back()->make = recorded(type->make);
    type = types_.back().get();
  }
  table_.network =
      [this, declare = table.network](const NetworkSpec& spec) -> Checked<std::shared_ptr<const NodeType>> {
    auto declared = declare(spec);
    if (!declared) return declared;
    const auto type = std::make_shared<NodeType>(**declared);
    type->make = recorded((*declared)->make);
    return std::shared_ptr<const NodeType>{type};
  };
}

MakeNode RecordedNodes::recorded(const MakeNode& make) {
  return [this, make](const NodeSetup& setup) {
    auto made = make(setup);
    if (made) setups_.insert_or_assign(made->get(), setup);
    return made;
  };
}

const NodeSetup* RecordedNodes::setup_of(const Node& node) const {
  const auto found = setups_.find(&node);
  return found == setups_.end() ? nullptr : &found->second;
}

}  // namespace tactus
