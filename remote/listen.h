#pragma once
// Thread: [any]

#include <string>

#include "engine/core/error.h"

namespace tactus {

/// Where a server of remote control listens, and for whom.
struct ListenOptions {
  std::string address = "127.0.0.1";
  int port = 0;                     ///< 0: any free one
  bool arm_from_elsewhere = false;  ///< clients of other hosts may arm and unmute
};

/// "9000", "192.168.1.5:9000", "[::1]:9000". Errors, at `option`, with this remedy: Syntax.
Result<ListenOptions> parse_listen_address(const std::string& text, const std::string& option,
                                           const std::string& remedy);

}  // namespace tactus
