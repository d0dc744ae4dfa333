#include "remote/serial/serial_sensors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <boost/asio.hpp>
#include <charconv>
#include <mutex>
#include <set>
#include <thread>
#include <vector>
#ifdef __unix__
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>
#endif
#ifdef __linux__
#include <sys/sysmacros.h>
#endif

#include "engine/graph/file/quantity.h"
#include "remote/serial/serial_line.h"

namespace tactus {
namespace {

namespace asio = boost::asio;
using ErrorCode = boost::system::error_code;

constexpr std::chrono::milliseconds kReopen{500};
constexpr std::size_t kMostNames = 16;  // unknown ones that are reported

#ifdef TIOCGDEV
/// The device that "/dev/tty" stands for, by whatever name it was opened, and also where the standard streams
/// lead elsewhere. 0: there is none.
dev_t controlling_terminal() {
  const int file = ::open("/dev/tty", O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (file < 0) return 0;
  unsigned number = 0;
  const bool known = ::ioctl(file, TIOCGDEV, &number) == 0;
  ::close(file);
  // The kernel's numbers are of 32 bits, those of the library of 64.
  return known ? makedev((number & 0xfff00) >> 8, (number & 0xff) | ((number >> 12) & 0xfff00)) : 0;
}
#endif

/// The terminal of this program: whoever reads it takes the keys that stop the drives.
bool is_own_terminal([[maybe_unused]] const std::string& device_name) {
#ifdef __unix__
  struct stat device {
  }, own{};
  if (stat(device_name.c_str(), &device) != 0) return false;
  if (stat("/dev/tty", &own) == 0 && own.st_rdev == device.st_rdev) return true;
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (isatty(standard) == 1 && fstat(standard, &own) == 0 && own.st_rdev == device.st_rdev) return true;
#endif
#ifdef TIOCGDEV
  if (device.st_rdev != 0 && device.st_rdev == controlling_terminal()) return true;
#endif
  return false;
}

class Sensors final : public SerialSensors {
 public:
  Sensors(const SerialOptions& options, RemoteTarget& target) : options_(options), target_(target) {}
  ~Sensors() override {
    io_.stop();
    if (thread_.joinable()) thread_.join();
  }

  Status start() {
    if (const auto error = open_port(); error)
      return fail(
          Errc::Device, "--serial", fmt::format("{} cannot be opened: {}", options_.device, error.message()),
          "check the name of the device, and that you may use it: on Linux the group dialout may; the "
          "terminal of this program is no sensor");
    read();
    thread_ = std::thread{[this] { io_.run(); }};
    return {};
  }

  SerialCounts counts() const override {
    const std::lock_guard lock{mutex_};
    return counts_;
  }

 private:
  ErrorCode open_port() {
    using Port = asio::serial_port;
    ErrorCode error;
    if (is_own_terminal(options_.device))  // opened, it would be in another mode
      return boost::system::errc::make_error_code(boost::system::errc::device_or_resource_busy);
    port_.open(options_.device, error);
    if (!error) port_.set_option(Port::baud_rate{static_cast<unsigned>(options_.baud)}, error);
    if (!error) port_.set_option(Port::character_size{8}, error);
    if (!error) port_.set_option(Port::flow_control{Port::flow_control::none}, error);
    if (!error) port_.set_option(Port::parity{Port::parity::none}, error);
    if (!error) port_.set_option(Port::stop_bits{Port::stop_bits::one}, error);
    ErrorCode ignored;
    if (error) port_.close(ignored);
    lines_.clear();
    refusal_reported_ = false;
    clock_.restart();
    return error;
  }

  void read() {
    port_.async_read_some(asio::buffer(bytes_), [this](ErrorCode error, std::size_t count) {
      if (error == asio::error::operation_aborted) return;
      if (error) return lost();
      const double now_s = system_seconds();
      lines_.add({bytes_.data(), count}, [&](std::string_view line) { use(line, now_s); });
      read();
    });
  }

  void lost() {
    ErrorCode ignored;
    port_.close(ignored);
    target_.report(options_.device + " is gone: its controls stay where they are");
    reopen_later();
  }
  void reopen_later() {
    timer_.expires_after(kReopen);
    timer_.async_wait([this](ErrorCode error) {
      if (error) return;
      if (open_port()) return reopen_later();
      target_.report(options_.device + " is back");
      read();
    });
  }

  void use(std::string_view text, double now_s) {
    const auto line = parse_serial_line(text);
    const std::lock_guard lock{mutex_};
    ++counts_.lines;
    if (!line) return refuse(text);
    const auto orders = orders_of(*line, clock_.time_of(line->micros, now_s) + kDelay.value);
    if (orders.empty()) return;
    if (target_.post(orders))
      counts_.changes += std::ssize(orders);
    else
      ++counts_.dropped;
  }

  /// The first one since the port was opened is reported.
  void refuse(std::string_view text) {
    ++counts_.refused;
    if (std::exchange(refusal_reported_, true)) return;
    std::string shown{text.substr(0, 40)};
    for (char& byte : shown)
      if (static_cast<unsigned char>(byte) < 0x20 || static_cast<unsigned char>(byte) > 0x7e) byte = '?';
    target_.report(fmt::format(
        "{}: the line '{}' is refused, and perhaps others: write 'NAME VALUE', and check that the "
        "sensor sends at {} baud",
        options_.device, shown, options_.baud));
  }
  /// The first one of each control is reported.
  double clamped(const RemoteControl& control, double si) {
    const double inside = std::clamp(si, control.low, control.high);
    if (inside != si && clamped_.insert(control.name).second)
      target_.report(fmt::format("{}: {}: {}; the nearest value is taken", options_.device, control.name,
                                 limits_text(control.low, control.high, control.unit)));
    return inside;
  }

  std::vector<RemoteOrder> orders_of(const SerialLine& line, double time_s) {
    const auto description = target_.description();
    std::vector<RemoteOrder> orders;
    for (const auto& [name, value] : line.values) {
      const int place = description->find_control(name);
      if (place < 0 || description->controls[static_cast<std::size_t>(place)].constant) {
        if (unknown_.size() < kMostNames && unknown_.insert(name).second)
          target_.report(
              fmt::format("{}: there is no control '{}' that can be changed", options_.device, name));
        continue;
      }
      const auto& control = description->controls[static_cast<std::size_t>(place)];
      orders.push_back({.number = control.number,
                        .value = clamped(control, control.unit.to_si(value)),
                        .time_s = time_s,
                        .received = std::chrono::steady_clock::now()});
    }
    return orders;
  }

  SerialOptions options_;
  RemoteTarget& target_;
  asio::io_context io_{1};
  asio::serial_port port_{io_};
  asio::steady_timer timer_{io_};
  std::array<char, 1024> bytes_{};
  SerialLines lines_;
  SerialClock clock_{kDelay.value};
  bool refusal_reported_ = false;
  std::set<std::string> unknown_, clamped_;
  mutable std::mutex mutex_;
  SerialCounts counts_;
  std::thread thread_;
};

}  // namespace

Result<SerialOptions> parse_serial_device(const std::string& text) {
  SerialOptions options{text};
  const auto at = text.rfind('@');
  if (at != std::string::npos) {
    options.device = text.substr(0, at);
    const auto* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + at + 1, end, options.baud);
    if (error != std::errc{} || stop != end || options.baud < 300 || options.baud > 4'000'000)
      options.device.clear();
  }
  if (options.device.empty())
    return fail(
        Errc::Syntax, "--serial", "'" + text + "' is no serial device",
        "write --serial /dev/ttyACM0, or --serial /dev/ttyUSB0@57600 with a rate from 300 to 4000000 baud");
  return options;
}

Result<std::unique_ptr<SerialSensors>> SerialSensors::open(const SerialOptions& options,
                                                           RemoteTarget& target) {
  auto sensors = std::make_unique<Sensors>(options, target);
  if (auto started = sensors->start(); !started) return tl::unexpected(started.error());
  return sensors;
}

}  // namespace tactus
