#pragma once
// Thread: [control]

#include <string>

namespace tactus {

/// Files and other programs can put any character into a name: none of them may reach a terminal as a
/// command, or, unless `lines` are allowed, look like a line of ours. Those that could are question marks.
inline std::string printable(std::string text, bool lines = false) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if ((c < 0x20 && !(lines && c == '\n')) || c == 0x7f) text[i] = '?';
    // U+0080 to U+009F are commands, too, in two bytes of UTF-8.
    if (c == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0)
      text.replace(i, 2, "?");
  }
  return text;
}

}  // namespace tactus
