#include "apps/cli/platform.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include "engine/core/index.h"

namespace tactus::app {

#if defined(__linux__)
namespace {

namespace fs = std::filesystem;

// Files of /proc have no size: they are read to their end. Some have no end.
constexpr std::size_t kLongest = 1 << 20;

SystemFacts::Text text_of(const fs::path& file) {
  std::ifstream in{file, std::ios::binary};
  if (!in) return std::nullopt;
  std::string text(kLongest, '\0');
  in.read(text.data(), static_cast<std::streamsize>(kLongest));
  if (in.bad()) return std::nullopt;
  text.resize(index(in.gcount()));
  return text;
}

std::string line_of(const fs::path& file) {
  auto text = text_of(file).value_or("");
  text.resize(std::min(text.size(), text.find('\n')));
  return text;
}

/// In order of their names.
std::vector<fs::path> entries(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> all;
  for (fs::directory_iterator entry{folder, error}, end; !error && entry != end; entry.increment(error))
    all.push_back(entry->path());
  std::sort(all.begin(), all.end());
  return all;
}

bool is_number(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

std::vector<SystemFacts::Process> processes(const fs::path& proc) {
  std::vector<SystemFacts::Process> all;
  for (const auto& folder : entries(proc)) {
    if (!is_number(folder.filename().string())) continue;
    SystemFacts::Process process{line_of(folder / "comm"), {}};
    const auto line = text_of(folder / "cmdline").value_or("");
    for (std::size_t at = 0; at < line.size();) {
      const auto end = std::min(line.find('\0', at), line.size());
      process.arguments.push_back(line.substr(at, end - at));
      at = end + 1;
    }
    all.push_back(std::move(process));
  }
  return all;
}

/// An interface of class 1 is audio, a device of class 9 a hub: USB-IF, "Defined class codes".
std::vector<SystemFacts::UsbDevice> usb_devices(const fs::path& folder) {
  std::vector<SystemFacts::UsbDevice> all;
  for (const auto& device : entries(folder)) {
    const auto name = device.filename().string();
    if (name.find('-') == std::string::npos || name.find(':') != std::string::npos) continue;
    SystemFacts::UsbDevice found{name, line_of(device / "product"), line_of(device / "power" / "control"),
                                 false, line_of(device / "bDeviceClass") == "09"};
    for (const auto& interface : entries(device))
      if (line_of(interface / "bInterfaceClass") == "01") found.audio = true;
    all.push_back(std::move(found));
  }
  return all;
}

void read_processors(const fs::path& folder, SystemFacts& facts) {
  for (const auto& processor : entries(folder)) {
    const auto governor = line_of(processor / "cpufreq" / "scaling_governor");
    if (!governor.empty()) facts.governors.push_back(governor);
    for (const auto& state : entries(processor / "cpuidle")) {
      const auto latency = line_of(state / "latency");
      if (is_number(latency) && line_of(state / "disable") != "1")
        facts.idle_latencies_us.push_back(static_cast<int>(std::strtol(latency.c_str(), nullptr, 10)));
    }
  }
}

std::string output_of(const char* command) {
  std::FILE* pipe = popen(command, "r");
  if (pipe == nullptr) return "";
  std::string text;
  std::array<char, 4096> part{};
  while (const auto size = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), size);
  pclose(pipe);
  return text;
}

}  // namespace

SystemFacts read_system(const fs::path& root) {
  const auto proc = root / "proc", sys = root / "sys", etc = root / "etc";
  SystemFacts facts;
  facts.known = true;
  facts.limits = text_of(proc / "self" / "limits");
  facts.groups = text_of(etc / "group");
  const auto status = text_of(proc / "self" / "status").value_or("");
  if (const auto at = status.find("\nGroups:"); at != std::string::npos)
    facts.user_groups = status.substr(at + 8, status.find('\n', at + 1) - at - 8);
  facts.audio_limits = text_of(etc / "security" / "limits.d" / "audio.conf");
  facts.version = text_of(proc / "version");
  facts.command_line = text_of(proc / "cmdline");
  facts.realtime_kernel = text_of(sys / "kernel" / "realtime");
  facts.preemption = text_of(sys / "kernel" / "debug" / "sched" / "preempt");
  facts.cpu_info = text_of(proc / "cpuinfo");
  facts.swaps = text_of(proc / "swaps");
  facts.swappiness = text_of(proc / "sys" / "vm" / "swappiness");
  read_processors(sys / "devices" / "system" / "cpu", facts);
  facts.cards = text_of(proc / "asound" / "cards");
  facts.usb = usb_devices(sys / "bus" / "usb" / "devices");
  facts.processes = processes(proc);
  std::error_code ignored;
  facts.rtirq =
      fs::exists(root / "usr" / "sbin" / "rtirq", ignored) || fs::exists(etc / "init.d" / "rtirq", ignored);
  const bool pipewire = std::any_of(facts.processes.begin(), facts.processes.end(),
                                    [](const auto& process) { return process.name == "pipewire"; });
  if (pipewire && root == "/")
    facts.pipewire = output_of("timeout 2 pw-metadata -n settings 0 2>/dev/null </dev/null");
  return facts;
}
#else
SystemFacts read_system(const std::filesystem::path&) { return {}; }
#endif

}  // namespace tactus::app
