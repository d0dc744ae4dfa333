#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tactus::app {

/// Facts of the operating system as it gives them; empty where it gives none.
struct SystemFacts {
  using Text = std::optional<std::string>;
  struct Process {
    std::string name;
    std::vector<std::string> arguments;
  };
  struct UsbDevice {
    std::string path;  ///< "1-2.3": port 3 of the hub at port 2 of bus 1
    std::string product;
    std::string power;  ///< "auto": sent to sleep when it is idle; "on"
    bool audio = false;
    bool hub = false;
  };
  bool known = false;  ///< a system that this file can read

  Text limits;        ///< /proc/self/limits
  Text groups;        ///< /etc/group
  Text user_groups;   ///< group ids, of /proc/self/status
  Text audio_limits;  ///< /etc/security/limits.d/audio.conf
  Text version, command_line;
  Text realtime_kernel;  ///< /sys/kernel/realtime
  Text preemption;       ///< /sys/kernel/debug/sched/preempt
  Text cpu_info, swaps, swappiness;
  std::vector<std::string> governors;  ///< of every processor that has one
  std::vector<int> idle_latencies_us;  ///< to wake up, of every idle state in use
  Text cards;                          ///< /proc/asound/cards
  std::vector<UsbDevice> usb;
  std::vector<Process> processes;
  bool rtirq = false;
  Text pipewire;  ///< what `pw-metadata -n settings 0` prints
};

/// [control] Reads all that is to be read without being root. `root`: another one than "/" is for tests, and
/// no program is run then.
SystemFacts read_system(const std::filesystem::path& root = "/");

}  // namespace tactus::app
