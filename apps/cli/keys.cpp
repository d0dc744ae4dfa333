#include "apps/cli/keys.h"

#include <utility>

namespace tactus::app {
namespace {

constexpr unsigned char kEscape = 0x1b, kBell = 0x07;
constexpr std::size_t kMostParameters = 16;  // bytes that are kept of a sequence

Key arrow(unsigned char final) {
  constexpr Key kArrows[] = {kUpKey, kDownKey, kRightKey, kLeftKey};
  return final >= 'A' && final <= 'D' ? kArrows[final - 'A'] : kNoKey;
}

/// Parameters and intermediate bytes of a control sequence (ECMA-48, 5.4).
bool is_parameter(unsigned char byte) { return byte >= 0x20 && byte <= 0x3f; }

/// DCS, SOS, OSC, PM and APC, after their Escape (ECMA-48, 5.6).
bool opens_string(unsigned char byte) {
  return byte == 'P' || byte == 'X' || byte == ']' || byte == '^' || byte == '_';
}

}  // namespace

Key KeyDecoder::decode(unsigned char byte, Clock::time_point now) {
  if (now - std::exchange(last_, now) > kPatience) state_ = State::Ground;
  switch (state_) {
    case State::Ground:
      return first_byte(byte);
    case State::Escape:
      return after_escape(byte, now);
    case State::Csi:
      return in_csi(byte);
    case State::OneMore:
      return one_more(byte);
    case State::Paste:
      return in_paste(byte);
    case State::String:
      return in_string(byte, now);
  }
  return kNoKey;
}

Key KeyDecoder::first_byte(unsigned char byte) {
  if (byte != kEscape) return byte < 0x80 ? Key{byte} : kNoKey;
  state_ = State::Escape;
  return kNoKey;
}

Key KeyDecoder::after_escape(unsigned char byte, Clock::time_point now) {
  parameters_.clear();
  if (byte == kEscape) return kNoKey;
  string_began_ = now;
  state_ = byte == '['          ? State::Csi
           : byte == 'O'        ? State::OneMore
           : opens_string(byte) ? State::String
                                : State::Ground;
  return kNoKey;
}

Key KeyDecoder::in_csi(unsigned char byte) {
  if (is_parameter(byte)) {
    if (parameters_.size() < kMostParameters) parameters_ += static_cast<char>(byte);
    return kNoKey;
  }
  const bool pasted = byte == '~' && parameters_ == "200";
  const bool linux_function_key = byte == '[' && parameters_.empty();
  state_ = pasted               ? State::Paste
           : linux_function_key ? State::OneMore
           : byte == kEscape    ? State::Escape
                                : State::Ground;
  return std::exchange(parameters_, linux_function_key ? "[" : "").empty() ? arrow(byte) : kNoKey;
}

/// Some terminals put parameters between ESC O and the final byte.
Key KeyDecoder::one_more(unsigned char byte) {
  if (is_parameter(byte)) return kNoKey;
  state_ = byte == kEscape ? State::Escape : State::Ground;
  return parameters_.empty() ? arrow(byte) : kNoKey;
}

Key KeyDecoder::in_paste(unsigned char byte) {
  static const std::string kEnd = "\x1b[201~";
  parameters_ += static_cast<char>(byte);
  if (parameters_.size() > kEnd.size()) parameters_.erase(0, 1);
  if (parameters_ == kEnd) state_ = State::Ground;
  return kNoKey;
}

/// ST is ESC \, which also ends what follows any other Escape.
Key KeyDecoder::in_string(unsigned char byte, Clock::time_point now) {
  if (now - string_began_ > kPatience) {
    state_ = State::Ground;
    return first_byte(byte);
  }
  if (byte == kEscape) state_ = State::Escape;
  if (byte == kBell) state_ = State::Ground;
  return kNoKey;
}

}  // namespace tactus::app
