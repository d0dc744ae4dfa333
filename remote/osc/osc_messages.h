#pragma once
// Thread: [any]

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// Nothing stands for what has no use here (colours, MIDI). True and false are 1 and 0.
using OscValue = std::variant<std::monostate, double, std::int64_t, std::string>;

struct OscMessage {
  std::string address;
  std::vector<OscValue> values = {};
};

/// The messages of a packet, or of a bundle in it.
struct OscBundle {
  static constexpr double kNow = -1.0;

  double time_s = kNow;  ///< by the system clock, since 1970
  std::vector<OscMessage> messages = {};
};

/// More is refused.
inline constexpr int kMostOscMessages = 512, kMostOscValues = 16, kMostOscDepth = 4;
inline constexpr std::size_t kLongestOscText = 256;

/// Reads a packet of OSC 1.0 by oscpack. A bundle in a bundle is one of its own. `now_s`: of the system
/// clock; a time tag is the time next to it. Errors: Syntax, for the whole packet; also for one
/// with a blob.
Result<std::vector<OscBundle>> parse_osc(std::span<const char> packet, double now_s);
/// [any] Whether this text stands anywhere in a packet where a text may begin, in one that is no valid OSC,
/// too.
bool contains_text(std::span<const char> packet, std::string_view text);

/// Packets of at most 1400 bytes, so that none is split on its way: bundles with the time tag `time_s`, or
/// one message alone where that is kNow and there is no other. Doubles are sent as float32, integers as
/// int32 (beyond its range as int64). What does not fit into a packet is left out.
std::vector<std::string> build_osc(std::span<const OscMessage> messages, double time_s = OscBundle::kNow);

/// Does an OSC address pattern match: ?, *, [a-c], [!x], {one,two}, each between two slashes.
bool matches_osc(std::string_view pattern, std::string_view address);
/// It does, or it matches a beginning of the address that ends before a slash; "/" matches everything.
bool covers_osc(std::string_view pattern, std::string_view address);
bool is_osc_pattern(std::string_view address);

}  // namespace tactus
