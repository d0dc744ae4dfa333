#pragma once

#include <filesystem>
#include <string>

namespace tactus {

/// [control] Where the joystick is connected that SDL knows by `path`, with its serial number if it has one:
/// "usb-0000:00:14.0-2/input0 serial 42". Linux numbers "/dev/input/event5" and "/dev/hidraw2" in the order
/// in which devices come; other systems have a path for each place. Empty: unknown. `root`: where sys is.
std::string joystick_place(const std::string& path, const std::filesystem::path& root = "/");

}  // namespace tactus
