#pragma once

#include <array>
#include <cstdint>
#include <tuple>

namespace tactus {

/// Where a packet comes from.
struct OscPeer {
  std::array<unsigned char, 16> address{};  ///< IPv6, or IPv4 mapped into it
  std::uint16_t port = 0;
  bool local = false;  ///< the loopback address of this computer

  /// [any] libc++ 16 has no three-way comparison of arrays.
  bool operator<(const OscPeer& other) const {
    return std::tie(address, port, local) < std::tie(other.address, other.port, other.local);
  }
  bool operator==(const OscPeer&) const = default;
};

}  // namespace tactus
