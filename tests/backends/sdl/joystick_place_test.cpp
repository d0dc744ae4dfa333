#include "backends/sdl/joystick_place.h"

#include <catch2/catch.hpp>

#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::TemporaryFolder;

TEST_CASE("joystick place: the port in which it is, whatever number Linux gave it") {
  const TemporaryFolder root;
  root.write("sys/class/input/event5/device/phys", "usb-0000:00:14.0-2/input0\n");
  root.write("sys/class/input/event5/device/uniq", "\n");
  root.write("sys/class/input/event7/device/phys", "usb-0000:00:14.0-2/input0\n");
  root.write("sys/class/input/event7/device/uniq", "42\n");
  root.write("sys/class/hidraw/hidraw2/device/uevent",
             "DRIVER=hid-generic\nHID_PHYS=usb-0000:00:14.0-3/input0\nHID_UNIQ=a1:b2\n");
  CHECK(joystick_place("/dev/input/event5", root.path()) == "usb-0000:00:14.0-2/input0");
  CHECK(joystick_place("/dev/input/event7", root.path()) == "usb-0000:00:14.0-2/input0 serial 42");
  CHECK(joystick_place("/dev/hidraw2", root.path()) == "usb-0000:00:14.0-3/input0 serial a1:b2");
}

TEST_CASE("joystick place: unknown where Linux does not tell, a path elsewhere") {
  const TemporaryFolder root;
  root.write("sys/class/input/event5/device/uniq", "42\n");
  CHECK(joystick_place("/dev/input/event5", root.path()).empty());
  CHECK(joystick_place("/dev/input/event6", root.path()).empty());
  CHECK(joystick_place("/dev/hidraw2", root.path()).empty());
  const std::string windows = R"(\\?\HID#VID_054C&PID_0CE6#7&2d8)";
  CHECK(joystick_place(windows, root.path()) == windows);
}
