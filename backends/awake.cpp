#include "backends/awake.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

namespace tactus {

Result<Awake> Awake::begin(const char* file) {
  const std::int32_t longest_us = 0;
  char bytes[sizeof longest_us];
  std::memcpy(bytes, &longest_us, sizeof bytes);
  std::error_code unreadable;
  if (!std::filesystem::exists(file, unreadable) && !unreadable)
    return fail(Errc::Device, "", "processors cannot be kept awake: there is no " + std::string{file},
                "leave out --awake");
  errno = 0;
  std::ofstream held{file, std::ios::binary | std::ios::in};  // `in`: it is opened as it is
  if (held.write(bytes, sizeof bytes).flush()) return Awake{std::move(held)};
  return fail(Errc::Device, "",
              std::string{"processors cannot be kept awake: "} + file + ": " + std::strerror(errno),
              "echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"audio\", MODE=\"0660\"' | sudo tee "
              "/etc/udev/rules.d/99-awake.rules && sudo udevadm trigger /dev/cpu_dma_latency && "
              "sudo usermod -aG audio $USER   # then log in again");
}

}  // namespace tactus
