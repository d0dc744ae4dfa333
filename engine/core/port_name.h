#pragma once

#include <string>

namespace tactus {

/// [any] The input or output that a channel is a lane of: "woofer" of "woofer[1]", and of "woofer".
inline std::string port_of(const std::string& channel) { return channel.substr(0, channel.find('[')); }

}  // namespace tactus
