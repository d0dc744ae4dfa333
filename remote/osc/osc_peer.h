#pragma once

#include <array>
#include <compare>
#include <cstdint>

namespace tactus {

/// Where a packet comes from.
struct OscPeer {
  std::array<unsigned char, 16> address{};  ///< IPv6, or IPv4 mapped into it
  std::uint16_t port = 0;
  bool local = false;  ///< the loopback address of this computer

  auto operator<=>(const OscPeer&) const = default;
};

}  // namespace tactus
