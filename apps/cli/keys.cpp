#include "apps/cli/keys.h"

#include <cstdio>
#include <utility>

namespace tactus::app {
namespace {

constexpr unsigned char kEscape = 0x1b, kBell = 0x07;
constexpr std::size_t kMostParameters = 16;  // bytes that are kept of a sequence
constexpr int kMouseBytes = 3;               // of a report in the protocol of X10

unsigned char small_letter(unsigned char byte) {
  return byte >= 'A' && byte <= 'Z' ? static_cast<unsigned char>(byte - 'A' + 'a') : byte;
}

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
  if (over(now)) state_ = State::Ground;
  last_ = now;
  const bool a = may_be_a(byte);
  const Key key = key_of(byte, now);
  return a && key == kNoKey ? kDisarmKey : key;
}

bool KeyDecoder::over(Clock::time_point now) const {
  const bool endless = state_ == State::Paste || state_ == State::String;
  return now - last_ > (state_ == State::Escape ? kPatienceAfterEscape : kPatience) ||
         (endless && now - began_ > kPatience);
}

/// The A of a control sequence belongs to an arrow.
bool KeyDecoder::may_be_a(unsigned char byte) const {
  return byte == 'a' || (byte == 'A' && state_ != State::Csi && state_ != State::OneMore);
}

Key KeyDecoder::key_of(unsigned char byte, Clock::time_point now) {
  switch (state_) {
    case State::Ground:
      return first_byte(byte);
    case State::Escape:
      return after_escape(byte, now);
    case State::Csi:
      return in_csi(byte, now);
    case State::OneMore:
      return one_more(byte);
    case State::Mouse:
      return in_mouse(byte);
    case State::Paste:
      return in_paste(byte);
    case State::String:
      return in_string(byte);
  }
  return kNoKey;
}

Key KeyDecoder::first_byte(unsigned char byte) {
  if (byte != kEscape) return byte < 0x80 ? Key{small_letter(byte)} : kNoKey;
  state_ = State::Escape;
  return kNoKey;
}

Key KeyDecoder::after_escape(unsigned char byte, Clock::time_point now) {
  parameters_.clear();
  if (byte == kEscape) return kNoKey;
  began_ = now;
  state_ = byte == '['          ? State::Csi
           : byte == 'O'        ? State::OneMore
           : opens_string(byte) ? State::String
                                : State::Ground;
  return kNoKey;
}

Key KeyDecoder::in_csi(unsigned char byte, Clock::time_point now) {
  if (is_parameter(byte)) {
    if (parameters_.size() < kMostParameters) parameters_ += static_cast<char>(byte);
    return kNoKey;
  }
  state_ = after_csi(byte);
  began_ = now;
  mouse_bytes_ = kMouseBytes;
  if (const Key key = after_protocol(byte); key != kNoKey) return parameters_.clear(), key;
  return std::exchange(parameters_, state_ == State::OneMore ? "[" : "").empty() ? arrow(byte) : kNoKey;
}

KeyDecoder::State KeyDecoder::after_csi(unsigned char byte) const {
  if (byte == kEscape) return State::Escape;
  if (byte == '~' && parameters_ == "200") return State::Paste;
  if (!parameters_.empty()) return State::Ground;
  return byte == '[' ? State::OneMore : byte == 'M' ? State::Mouse : State::Ground;
}

/// CSI code ; modifiers [: event] u, and CSI 27 ; modifiers ; code ~. The modifiers are one above a sum of 1
/// Shift, 2 Alt, 4 Ctrl and others; event 3 is the release of the key.
Key KeyDecoder::after_protocol(unsigned char final) const {
  int code = 0, modifiers = 1, event = 1;
  const bool kitty =
      final == 'u' && (std::sscanf(parameters_.c_str(), "%d;%d:%d", &code, &modifiers, &event) >= 2 ||
                       std::sscanf(parameters_.c_str(), "%d", &code) == 1);
  const bool xterm = final == '~' && std::sscanf(parameters_.c_str(), "27;%d;%d", &modifiers, &code) == 2;
  if ((!kitty && !xterm) || event == 3 || code <= 0 || code >= 0x80) return kNoKey;
  const auto key = small_letter(static_cast<unsigned char>(code));
  const int held = modifiers - 1;
  if ((held & 4) != 0) return key == 'c' || key == '\\' ? kStopKey : kNoKey;
  if ((held & 2) != 0) return kNoKey;
  return key == 'a' ? kDisarmKey : Key{key};
}

/// Some terminals put parameters between ESC O and the final byte.
Key KeyDecoder::one_more(unsigned char byte) {
  if (is_parameter(byte)) return kNoKey;
  state_ = byte == kEscape ? State::Escape : State::Ground;
  return parameters_.empty() ? arrow(byte) : kNoKey;
}

/// Three bytes, each of them above 32.
Key KeyDecoder::in_mouse(unsigned char byte) {
  state_ = byte == kEscape ? State::Escape : --mouse_bytes_ > 0 ? State::Mouse : State::Ground;
  return kNoKey;
}

Key KeyDecoder::in_paste(unsigned char byte) {
  static const std::string kEnd = "\x1b[201~";
  parameters_ += static_cast<char>(byte);
  if (parameters_.size() > kEnd.size()) parameters_.erase(0, 1);
  if (parameters_ == kEnd) state_ = State::Ground;
  return kNoKey;
}

/// ST is ESC \, which also ends what follows any other Escape.
Key KeyDecoder::in_string(unsigned char byte) {
  if (byte == kEscape) state_ = State::Escape;
  if (byte == kBell) state_ = State::Ground;
  return kNoKey;
}

}  // namespace tactus::app
