#include "tests/cards/sdl/hid_gadget.h"

#include <fcntl.h>
#include <linux/hid.h>
#include <linux/usb/functionfs.h>
#include <poll.h>
#include <sys/mount.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/support/skip.h"
#include "tests/support/wait_until.h"

namespace tactus::test {
namespace {

namespace fs = std::filesystem;

const fs::path kGadgets{"/sys/kernel/config/usb_gadget"};
const fs::path kGadget = kGadgets / "tactus";
const fs::path kFunction{"functions/ffs.tactus"}, kConfiguration{"configs/c.1"}, kStrings{"strings/0x409"};
const fs::path kLink = kConfiguration / "ffs.tactus";
const fs::path kEndpoints{"/dev/tactus_gadget"};  // FunctionFS is mounted here
constexpr int kReportBytes = 64;                  // of a packet at full speed

/// The modules of the kernel, and what is there when they are loaded.
constexpr std::pair<const char*, const char*> kModules[] = {
    {"/sys/class/udc/dummy_udc.0", "dummy_hcd"},
    {"/sys/module/usb_f_fs", "usb_f_fs"},
    {"/sys/bus/usb/drivers/usbhid", "usbhid"},
    {"/sys/bus/hid/drivers/hid-generic", "hid-generic"},
    {"/sys/module/evdev", "evdev"}};

void need_kernel() {
  for (const auto& [path, module] : kModules)
    if (!fs::exists(path))
      skip(std::string{"a simulated USB device needs the kernel module "} + module +
           ", as in the virtual machine: scripts/test_cards");
  if (!fs::exists(kGadgets)) skip("configfs is not mounted on /sys/kernel/config");
  const std::ifstream symbols{"/proc/kallsyms"};
  const std::string all{std::istreambuf_iterator<char>{symbols.rdbuf()}, {}};
  if (all.find(" hid_pidff_init") == all.npos)
    skip("this kernel has no force feedback of the USB PID class (CONFIG_HID_PID)");
}

bool is_set(const fs::path& attribute, const std::string& value) {
  std::ofstream file{kGadget / attribute};
  file << value << std::endl;
  return file.good();
}
/// Whether the kernel has the device as a HID device: bus 3 (USB), vendor and product.
bool is_plugged() {
  return std::ranges::any_of(fs::directory_iterator("/sys/bus/hid/devices"), [](const auto& device) {
    return device.path().filename().string().starts_with("0003:1209:0003.");
  });
}

void set(const fs::path& attribute, const std::string& value) {
  INFO(attribute);
  REQUIRE(is_set(attribute, value));
}

template <class T>
void append(Bytes& bytes, const T& value) {
  const auto* begin = reinterpret_cast<const std::uint8_t*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

usb_endpoint_descriptor_no_audio interrupt_endpoint(int address) {
  usb_endpoint_descriptor_no_audio endpoint{};
  endpoint.bLength = sizeof endpoint;
  endpoint.bDescriptorType = USB_DT_ENDPOINT;
  endpoint.bEndpointAddress = static_cast<std::uint8_t>(address);
  endpoint.bmAttributes = USB_ENDPOINT_XFER_INT;
  endpoint.wMaxPacketSize = kReportBytes;
  endpoint.bInterval = 1;  // [ms]
  return endpoint;
}

/// Device Class Definition for Human Interface Devices 1.11, section 6.2.1.
Bytes hid_descriptor(std::size_t report_descriptor_bytes) {
  const auto size = static_cast<std::uint16_t>(report_descriptor_bytes);
  return {9,
          HID_DT_HID,
          0x11,
          0x01,
          0,
          1,
          HID_DT_REPORT,
          static_cast<std::uint8_t>(size & 0xff),
          static_cast<std::uint8_t>(size >> 8)};
}

int open_endpoint(const char* name) {
  INFO(name);
  const int file = open((kEndpoints / name).c_str(), O_RDWR | O_NONBLOCK);
  REQUIRE(file >= 0);
  return file;
}

}  // namespace

HidGadget::HidGadget(const std::string& maker, const std::string& product, HidFunctions functions)
    : functions_(std::move(functions)) {
  need_kernel();
  make(maker, product);
  control_ = open_endpoint("ep0");
  describe();
  in_ = open_endpoint("ep1");
  out_ = open_endpoint("ep2");
  requests_ = std::thread{[this] { answer_requests(); }};
  outputs_ = std::thread{[this] { take_output_reports(); }};
  plug();
}

HidGadget::~HidGadget() {
  if (is_plugged()) unplug();
  stop_ = true;
  requests_.join();
  outputs_.join();
  for (const int file : {in_, out_, control_}) close(file);
  umount(kEndpoints.c_str());
  unlink((kGadget / kLink).c_str());
  for (const auto& folder : {kConfiguration, kFunction, kStrings, fs::path{}})
    rmdir((kGadget / folder).c_str());
}

void HidGadget::make(const std::string& maker, const std::string& product) const {
  for (const auto& folder : {kStrings, kConfiguration, kFunction}) fs::create_directories(kGadget / folder);
  set("idVendor", "0x1209");
  set("idProduct", "0x0003");
  set("max_speed", "full-speed");
  set(kStrings / "manufacturer", maker);
  set(kStrings / "product", product);
  fs::create_directory_symlink(kGadget / kFunction, kGadget / kLink);
  fs::create_directories(kEndpoints);
  REQUIRE(mount("tactus", kEndpoints.c_str(), "functionfs", 0, nullptr) == 0);
}

/// One interface with an endpoint in each direction, and no strings of its own.
void HidGadget::describe() const {
  usb_interface_descriptor interface {};
  interface.bLength = sizeof interface;
  interface.bDescriptorType = USB_DT_INTERFACE;
  interface.bNumEndpoints = 2;
  interface.bInterfaceClass = USB_CLASS_HID;
  Bytes descriptors;
  append(descriptors, interface);
  const auto hid = hid_descriptor(functions_.report_descriptor.size());
  descriptors.insert(descriptors.end(), hid.begin(), hid.end());
  append(descriptors, interrupt_endpoint(1 | USB_DIR_IN));
  append(descriptors, interrupt_endpoint(2 | USB_DIR_OUT));

  constexpr std::uint32_t kCount = 4;  // of the descriptors, at full speed
  usb_functionfs_descs_head_v2 head{};
  head.magic = FUNCTIONFS_DESCRIPTORS_MAGIC_V2;
  head.flags = FUNCTIONFS_HAS_FS_DESC;
  head.length = static_cast<std::uint32_t>(sizeof head + sizeof kCount + descriptors.size());
  Bytes message;
  append(message, head);
  append(message, kCount);
  message.insert(message.end(), descriptors.begin(), descriptors.end());
  REQUIRE(write(control_, message.data(), message.size()) == std::ssize(message));

  usb_functionfs_strings_head strings{};
  strings.magic = FUNCTIONFS_STRINGS_MAGIC;
  strings.length = sizeof strings;
  REQUIRE(write(control_, &strings, sizeof strings) == sizeof strings);
}

void HidGadget::plug() { set("UDC", "dummy_udc.0"); }
void HidGadget::unplug() {
  set("UDC", "");
  REQUIRE(wait_until([] { return !is_plugged(); }));
}

void HidGadget::send(const Bytes& report) const {
  REQUIRE(write(in_, report.data(), report.size()) == std::ssize(report));
}

/// A request is refused, that is stalled, by a transfer in the wrong direction.
void HidGadget::answer_requests() const {
  while (!stop_) {
    pollfd waits{control_, POLLIN, 0};
    if (poll(&waits, 1, 20) <= 0) continue;
    usb_functionfs_event event{};
    if (read(control_, &event, sizeof event) != sizeof event || event.type != FUNCTIONFS_SETUP) continue;
    const auto& request = event.u.setup;
    Bytes data(request.wLength);
    if ((request.bRequestType & USB_DIR_IN) == 0) {
      if (read(control_, data.data(), data.size()) == std::ssize(data) &&
          request.bRequest == HID_REQ_SET_REPORT)
        functions_.take(data);
      continue;
    }
    if (request.bRequest == USB_REQ_GET_DESCRIPTOR && request.wValue >> 8 == HID_DT_REPORT)
      data = functions_.report_descriptor;
    else if (request.bRequest == HID_REQ_GET_REPORT)
      data = functions_.give(static_cast<std::uint8_t>(request.wValue & 0xff));
    else
      data.clear();
    const auto size = std::min<std::size_t>(data.size(), request.wLength);
    (void)(data.empty() ? read(control_, nullptr, 0) : write(control_, data.data(), size));
  }
}

/// Reading fails while it is unplugged.
void HidGadget::take_output_reports() const {
  while (!stop_) {
    Bytes report(kReportBytes);
    const auto size = read(out_, report.data(), report.size());
    if (size <= 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds{1});
      continue;
    }
    report.resize(static_cast<std::size_t>(size));
    functions_.take(report);
  }
}

}  // namespace tactus::test
