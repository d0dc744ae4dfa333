#pragma once

#include <string>

namespace tactus {

/// [any] The input or output that a channel is a lane of: "woofer" of "woofer[1]", and of "woofer".
inline std::string port_of(const std::string& channel) { return channel.substr(0, channel.find('[')); }

/// [any] The signals of a node's events, "node.trigger" and "node.level", the level that goes with each; of a
/// lane "node.trigger[1]".
struct EventSignal {
  std::string node;      ///< "node", "node[1]"
  std::string level_of;  ///< the signal of its level: "node.level[1]"
  bool is_level = false;

  explicit EventSignal(const std::string& signal) {
    const auto port = port_of(signal), lane = signal.substr(port.size());
    const auto owner = port.substr(0, port.rfind('.'));
    node = owner + lane;
    level_of = owner + ".level" + lane;
    is_level = signal == level_of;
  }
};

}  // namespace tactus
