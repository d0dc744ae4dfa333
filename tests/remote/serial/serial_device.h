#pragma once

#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string_view>
#include <utility>

namespace tactus::test {

/// A device that can be unplugged: a link to a pseudo-terminal.
class SerialDevice {
 public:
  explicit SerialDevice(std::filesystem::path link) : link_(std::move(link)) {}
  ~SerialDevice() { unplug(); }

  void plug_in() {
    char name[256];
    int other = -1;
    REQUIRE(::openpty(&fd_, &other, name, nullptr, nullptr) == 0);
    termios raw{};
    ::tcgetattr(other, &raw);
    ::cfmakeraw(&raw);
    ::tcsetattr(other, TCSANOW, &raw);
    other_ = other;
    std::filesystem::create_symlink(name, link_);
  }
  /// As if the cable was pulled out: reading fails, and the name is gone.
  void unplug() {
    std::error_code ignored;
    std::filesystem::remove(link_, ignored);
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
    if (other_ >= 0) ::close(std::exchange(other_, -1));
  }
  void send(std::string_view bytes) const {
    REQUIRE(::write(fd_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }

 private:
  std::filesystem::path link_;
  int fd_ = -1, other_ = -1;
};

}  // namespace tactus::test
