#include "backends/sdl/joystick_place.h"

#include <fstream>

namespace tactus {
namespace {

namespace fs = std::filesystem;

/// What follows `key` in the first line of `file` that begins with it.
std::string line_of(const fs::path& file, const std::string& key) {
  std::ifstream lines{file};
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(key)) return line.substr(key.size());
  return {};
}

}  // namespace

std::string joystick_place(const std::string& path, const fs::path& root) {
  if (!path.starts_with("/dev/")) return path;
  const fs::path node{path};
  const bool raw = node.parent_path() == "/dev";
  const auto device = root / "sys/class" / (raw ? "hidraw" : "input") / node.filename() / "device";
  auto place = raw ? line_of(device / "uevent", "HID_PHYS=") : line_of(device / "phys", "");
  const auto serial = raw ? line_of(device / "uevent", "HID_UNIQ=") : line_of(device / "uniq", "");
  if (!place.empty() && !serial.empty()) place += " serial " + serial;
  return place;
}

}  // namespace tactus
