#pragma once

#include "tests/support/graphs/node_runner.h"

namespace tactus::test {

/// The first output of a fresh node over `frames` frames.
inline Samples play_node(const NodeType& type, int frames, const std::map<std::string, InputValue>& inputs,
                         const std::map<std::string, std::string>& settings = {}) {
  return NodeRunner(type, inputs, settings).run(even_cutting(frames, kLongestSubBlock))[0];
}

/// What a node type says when it refuses to make a node; "" if it does not.
inline std::string refusal(const NodeType& type, const std::map<std::string, InputValue>& inputs,
                           const std::map<std::string, std::string>& settings = {}) {
  return NodeRunner(type, inputs, settings).error();
}

}  // namespace tactus::test
