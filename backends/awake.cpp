#include "backends/awake.h"

#include <cerrno>
#include <cstring>
#include <string>

namespace tactus {

Result<Awake> Awake::begin(const char* file) {
  const char longest_us[4] = {};  // a 32-bit number
  errno = 0;
  std::ofstream held{file, std::ios::binary | std::ios::in};  // `in`: it is opened as it is
  if (held.write(longest_us, sizeof longest_us).flush()) return Awake{std::move(held)};
  const int wrong = errno;
  const std::string what = "processors cannot be kept awake: ";
  if (wrong == ENOENT) return fail(Errc::Device, "", what + "there is no " + file, "leave out --awake");
  return fail(Errc::Device, "", what + file + ": " + std::strerror(wrong),
              "echo 'KERNEL==\"cpu_dma_latency\", GROUP=\"audio\", MODE=\"0660\"' | sudo tee "
              "/etc/udev/rules.d/99-awake.rules && sudo udevadm trigger /dev/cpu_dma_latency && "
              "sudo usermod -aG audio $USER   # then log in again");
}

}  // namespace tactus
