#pragma once
// Thread: [control]

#include <string>

namespace tactus {

/// How many bytes of UTF-8 at `i` turn the direction of a text, end its line, or cannot be seen: U+061C,
/// U+200B to U+200F, U+2028 to U+202E, U+2060 to U+206F, U+FEFF.
inline std::size_t unseen(const std::string& text, std::size_t i) {
  const auto at = [&](std::size_t n) {
    return i + n < text.size() ? static_cast<unsigned char>(text[i + n]) : 0u;
  };
  if (at(0) == 0xD8 && at(1) == 0x9C) return 2;
  if (at(0) == 0xEF && at(1) == 0xBB && at(2) == 0xBF) return 3;
  if (at(0) != 0xE2) return 0;
  const bool general =
      at(1) == 0x80 && ((at(2) >= 0x8B && at(2) <= 0x8F) || (at(2) >= 0xA8 && at(2) <= 0xAE));
  return general || (at(1) == 0x81 && at(2) >= 0xA0 && at(2) <= 0xAF) ? 3 : 0;
}

/// Files and other programs can put any character into a name: none of them may reach a terminal as a
/// command, turn what stands beside it, or, unless `lines` are allowed, look like a line of ours. Those that
/// could are question marks.
inline std::string printable(std::string text, bool lines = false) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && !(lines && c == '\n')) || c == 0x7f) text[i] = '?';
    // U+0080 to U+009F are commands, too, in two bytes of UTF-8.
    if (c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0)
      text.replace(i, 2, "?");
    if (const auto bytes = unseen(text, i); bytes > 0) text.replace(i, bytes, "?");
  }
  return text;
}

}  // namespace tactus
