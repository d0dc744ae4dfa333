#pragma once

// Thread: [control].

#include <bit>
#include <cstdint>
#include <string_view>

namespace tactus {

/// FNV-1a, 64 bits: equal for equal input, and else different but for one case in 2^64. Source: Fowler, Noll
/// and Vo, IETF draft-eastlake-fnv.
class Fingerprint {
 public:
  Fingerprint& add(std::string_view text) { return add_part(text).add(std::uint64_t{text.size()}); }
  /// A part of a text, behind whose last part comes the size of the whole.
  Fingerprint& add_part(std::string_view part) {
    for (const char c : part) byte(static_cast<unsigned char>(c));
    return *this;
  }
  Fingerprint& add(double number) { return add(std::bit_cast<std::uint64_t>(number + 0.0)); }
  Fingerprint& add(std::uint64_t number) {
    for (int i = 0; i < 8; ++i) byte(number >> (8 * i) & 0xff);
    return *this;
  }
  std::uint64_t value() const { return value_; }

 private:
  void byte(std::uint64_t b) { value_ = (value_ ^ b) * 1099511628211u; }

  std::uint64_t value_ = 14695981039346656037u;
};

}  // namespace tactus
