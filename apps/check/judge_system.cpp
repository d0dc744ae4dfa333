#include "apps/check/judge_system.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <set>
#include <sstream>

namespace tactus::app {
namespace {

using State = Finding::State;

constexpr int kSlowWake_us = 100;  // a tenth of a block of 64 frames at 48 kHz
constexpr int kLongQuantum = 256;  // frames: 5 ms at 48 kHz
constexpr int kCalmSwappiness = 10;

bool contains(const SystemFacts::Text& text, const std::string& word) {
  return text && text->find(word) != std::string::npos;
}

std::optional<int> number_in(const std::string& text) {
  int number = 0;
  const auto first = std::min(text.find_first_not_of(" \t"), text.size());
  const auto parsed = std::from_chars(text.data() + first, text.data() + text.size(), number);
  return parsed.ec == std::errc{} ? std::optional{number} : std::nullopt;
}

/// "audio:x:29:me,you" -> 29
std::optional<int> id_of_group(const SystemFacts::Text& groups, const std::string& name) {
  std::istringstream lines{groups.value_or("")};
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name + ":")) continue;
    const auto id = line.find(':', name.size() + 1);
    if (id != std::string::npos) return number_in(line.substr(id + 1));
  }
  return std::nullopt;
}

bool in_group(const SystemFacts& facts, const std::string& name) {
  const auto wanted = id_of_group(facts.groups, name);
  std::istringstream ids{facts.user_groups.value_or("")};
  for (int id = 0; ids >> id;)
    if (wanted == id) return true;
  return false;
}

/// The way to a right that the group 'audio' has by /etc/security/limits.d.
std::string limits_command(const SystemFacts& facts, const std::string& item) {
  if (!contains(facts.audio_limits, item))
    return "printf '@audio - rtprio 95\\n@audio - memlock unlimited\\n' | sudo tee "
           "/etc/security/limits.d/audio.conf && sudo usermod -aG audio $USER   # then log in again";
  if (!in_group(facts, "audio")) return "sudo usermod -aG audio $USER   # then log in again";
  return "exec su - $USER   # or log in again: the limits of this session are older than their file";
}

/// What stands behind an option, given short or long, or within it: "-p 64", "-p64", "--period=64".
std::optional<int> option_in(const std::vector<std::string>& arguments, std::size_t from,
                             const std::array<std::string, 2>& names) {
  for (std::size_t i = from; i < arguments.size(); ++i)
    for (const auto& name : names) {
      if (arguments[i] == name && i + 1 < arguments.size()) return number_in(arguments[i + 1]);
      if (!arguments[i].starts_with(name)) continue;
      return number_in(arguments[i].substr(name.size() + (arguments[i][name.size()] == '=' ? 1 : 0)));
    }
  return std::nullopt;
}

Finding judge_jack(const SystemFacts::Process& process) {
  const auto& all = process.arguments;
  const auto driver = std::find_if(all.begin(), all.end(), [](const std::string& argument) {
    return argument.starts_with("-d") || argument.starts_with("--driver");
  });
  if (driver == all.end())
    return {"JACK", State::Unknown, "a JACK server runs and does not show its settings",
            "jack_bufsize; jack_samplerate"};
  const auto at = static_cast<std::size_t>(driver - all.begin());
  const bool ordinary = std::any_of(all.begin(), driver, [](const std::string& argument) {
    return argument == "-r" || argument == "--no-realtime";
  });
  const int period = option_in(all, at + 1, {"-p", "--period"}).value_or(1024);
  const int rate = option_in(all, at + 1, {"-r", "--rate"}).value_or(48000);
  const auto what = fmt::format("jackd runs at {} Hz with {} frames a period", rate, period);
  if (ordinary)
    return {"JACK", State::Warn, what + ", without real-time priority (-r)",
            "jackd -R -d alsa -p 64   # as it is started, with -R"};
  if (period > kLongQuantum)
    return {"JACK", State::Warn, what + fmt::format(": {:.1f} ms each way", 1e3 * period / rate),
            "jack_bufsize 64"};
  return {"JACK", State::Ok, what, ""};
}

/// value:'1024' of  key:'clock.quantum'
std::optional<int> pipewire_setting(const std::string& text, const std::string& key) {
  const auto at = text.find("key:'" + key + "'");
  if (at == std::string::npos) return std::nullopt;
  const auto value = text.find("value:'", at);
  return value == std::string::npos ? std::nullopt : number_in(text.substr(value + 7));
}

Finding judge_pipewire(const SystemFacts::Text& settings) {
  constexpr auto* kCommand = "pw-metadata -n settings 0 clock.force-quantum 64   # 0 undoes it";
  const auto text = settings.value_or("");
  const auto quantum = pipewire_setting(text, "clock.quantum"),
             forced = pipewire_setting(text, "clock.force-quantum");
  const int rate = pipewire_setting(text, "clock.rate").value_or(48000);
  if (!quantum)
    return {"PipeWire", State::Unknown, "PipeWire runs and does not tell its quantum",
            "pw-metadata -n settings 0"};
  const bool is_forced = forced.value_or(0) > 0;
  const int frames = is_forced ? *forced : *quantum;
  const auto what = fmt::format("PipeWire {} {} frames at {} Hz",
                                is_forced ? "is held at" : "runs by default at", frames, rate);
  if (frames <= kLongQuantum) return {"PipeWire", State::Ok, what, ""};
  return {"PipeWire", State::Warn, what + fmt::format(": {:.1f} ms each way", 1e3 * frames / rate), kCommand};
}

/// "1-2" of "1-2.3"; empty for what hangs on a port of the machine itself.
std::string hub_of(const std::string& path) {
  const auto dot = path.rfind('.');
  return dot == std::string::npos ? "" : path.substr(0, dot);
}

}  // namespace

const char* name_of(Finding::State state) {
  return state == State::Ok ? "ok" : state == State::Warn ? "warn" : "unknown";
}

Finding judge_priority(const SystemFacts& facts, const Status& tried) {
  constexpr auto* kName = "real-time priority";
  if (tried) return {kName, State::Ok, "threads of this user get SCHED_FIFO", ""};
  return {kName, State::Warn, tried.error().what,
          facts.known ? limits_command(facts, "rtprio") : tried.error().remedy};
}

Finding judge_memory(const SystemFacts& facts, const Status& tried) {
  constexpr auto* kName = "memory lock";
  if (tried) return {kName, State::Ok, "the program can stay in memory", ""};
  return {kName, State::Warn, tried.error().what,
          facts.known ? limits_command(facts, "memlock") : tried.error().remedy};
}

Finding judge_governor(const SystemFacts& facts) {
  constexpr auto* kName = "CPU governor";
  if (facts.governors.empty())
    return {kName, State::Unknown, "the clock of the processors is not to be seen (a virtual machine?)", ""};
  const auto slow = std::find_if(facts.governors.begin(), facts.governors.end(),
                                 [](const std::string& governor) { return governor != "performance"; });
  if (slow == facts.governors.end()) return {kName, State::Ok, "every processor runs at full clock", ""};
  return {kName, State::Warn, "the governor '" + *slow + "' slows processors down between blocks",
          "sudo cpupower frequency-set -g performance"};
}

Finding judge_idle(const SystemFacts& facts) {
  constexpr auto* kName = "CPU idle states";
  if (facts.idle_latencies_us.empty()) return {kName, State::Unknown, "idle states are not to be seen", ""};
  const int longest = *std::max_element(facts.idle_latencies_us.begin(), facts.idle_latencies_us.end());
  const auto what = fmt::format("a processor wakes up within {} us", longest);
  if (longest <= kSlowWake_us) return {kName, State::Ok, what, ""};
  return {kName, State::Warn, what + ", which small blocks have no time for",
          fmt::format("sudo cpupower idle-set -D {}", kSlowWake_us + 1)};
}

Finding judge_kernel(const SystemFacts& facts) {
  constexpr auto* kName = "kernel";
  constexpr auto* kFull = "echo full | sudo tee /sys/kernel/debug/sched/preempt";
  if (!facts.version) return {kName, State::Unknown, "the kernel does not tell its version", ""};
  if (contains(facts.realtime_kernel, "1") || contains(facts.version, "PREEMPT_RT"))
    return {kName, State::Ok, "a real-time kernel (PREEMPT_RT)", ""};
  if (contains(facts.version, "PREEMPT_DYNAMIC")) {
    if (contains(facts.preemption, "(full)") || contains(facts.command_line, "preempt=full"))
      return {kName, State::Ok, "preemptible (PREEMPT_DYNAMIC, full)", ""};
    if (contains(facts.preemption, "(lazy)") || contains(facts.command_line, "preempt=lazy"))
      return {kName, State::Ok, "preemptible by real-time threads (PREEMPT_DYNAMIC, lazy)", ""};
    if (!facts.preemption && !contains(facts.command_line, "preempt="))
      return {kName, State::Unknown,
              "preemption is chosen at boot (PREEMPT_DYNAMIC), and only root sees which", kFull};
    return {kName, State::Warn,
            "system calls of other programs hold up the audio thread (not fully preemptible)", kFull};
  }
  if (contains(facts.version, "PREEMPT")) return {kName, State::Ok, "preemptible (PREEMPT)", ""};
  return {kName, State::Warn,
          "system calls of other programs hold up the audio thread (a kernel without preemption)",
          "sudo apt-get install linux-image-rt-amd64   # then boot it"};
}

Finding judge_interrupts(const SystemFacts& facts) {
  constexpr auto* kName = "interrupts";
  if (!facts.version || !facts.command_line)
    return {kName, State::Unknown, "how interrupts run is not to be seen", ""};
  const bool realtime = contains(facts.realtime_kernel, "1") || contains(facts.version, "PREEMPT_RT");
  if (!realtime && !contains(facts.command_line, "threadirqs"))
    return {kName, State::Warn, "interrupts of disks and networks come before the audio thread",
            "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&threadirqs /' /etc/default/grub && sudo update-grub   # "
            "then boot"};
  if (!facts.rtirq)
    return {kName, State::Warn,
            "interrupts are threads, and that of the sound card has no higher priority than others",
            "sudo apt-get install rtirq-init"};
  return {kName, State::Ok, "interrupts are threads, and rtirq puts the sound card's first", ""};
}

Finding judge_swap(const SystemFacts& facts, bool memory_locked) {
  constexpr auto* kName = "swap";
  if (!facts.swaps) return {kName, State::Unknown, "swap is not to be seen", ""};
  const bool any = std::count(facts.swaps->begin(), facts.swaps->end(), '\n') > 1;
  if (!any) return {kName, State::Ok, "there is no swap", ""};
  if (memory_locked) return {kName, State::Ok, "there is swap, and the program stays out of it", ""};
  const auto swappiness = number_in(facts.swappiness.value_or(""));
  if (swappiness && *swappiness <= kCalmSwappiness)
    return {kName, State::Ok, fmt::format("memory is swapped out late (swappiness {})", *swappiness), ""};
  return {kName, State::Warn, "memory of the program may be swapped out while it plays",
          fmt::format("echo vm.swappiness={} | sudo tee /etc/sysctl.d/90-audio.conf && sudo sysctl --system",
                      kCalmSwappiness)};
}

Finding judge_machine(const SystemFacts& facts) {
  constexpr auto* kName = "machine";
  if (!facts.cpu_info) return {kName, State::Unknown, "the processor is not to be seen", ""};
  if (!contains(facts.cpu_info, " hypervisor")) return {kName, State::Ok, "no virtual machine", ""};
  return {kName, State::Warn,
          "a virtual machine is held up for milliseconds by its host: use blocks of 256 frames or more",
          "systemd-detect-virt   # shows which; play on the machine itself"};
}

Finding judge_cards(const SystemFacts& facts) {
  constexpr auto* kName = "sound cards";
  if (!facts.cards) return {kName, State::Unknown, "the kernel shows no sound cards at all (no ALSA)", ""};
  std::string names;
  std::istringstream lines{*facts.cards};
  for (std::string line; std::getline(lines, line);) {
    const auto open = line.find('['), dash = line.find(" - ", open);
    if (open == std::string::npos || dash == std::string::npos) continue;
    names += (names.empty() ? "" : ", ") + line.substr(dash + 3);
  }
  if (!names.empty()) return {kName, State::Ok, names, ""};
  return {kName, State::Warn, "no sound card is plugged in",
          "sudo dmesg | tail   # says what happened when it was plugged in"};
}

std::vector<Finding> judge_usb(const SystemFacts& facts) {
  std::vector<Finding> findings;
  for (const auto& device : facts.usb) {
    if (!device.audio) continue;
    const auto name = device.product.empty() ? device.path : device.product;
    Finding finding{"USB", State::Ok, "'" + name + "' stays awake, on a port of its own", ""};
    const auto hub = hub_of(device.path);
    const auto neighbour = std::find_if(facts.usb.begin(), facts.usb.end(), [&](const auto& other) {
      return &other != &device && !other.hub && !hub.empty() && hub_of(other.path) == hub;
    });
    if (neighbour != facts.usb.end())
      finding = {"USB", State::Warn,
                 "'" + name + "' shares a hub with '" +
                     (neighbour->product.empty() ? neighbour->path : neighbour->product) + "'",
                 "lsusb -t   # shows the ports; plug it into one of the machine itself"};
    if (device.power == "auto")
      finding = {"USB", State::Warn, "'" + name + "' may be sent to sleep when it is idle",
                 "echo on | sudo tee /sys/bus/usb/devices/" + device.path + "/power/control"};
    findings.push_back(std::move(finding));
  }
  if (findings.empty())
    findings.push_back({"USB", facts.usb.empty() ? State::Unknown : State::Ok,
                        facts.usb.empty() ? "no USB is to be seen" : "no sound card hangs on USB", ""});
  return findings;
}

std::vector<Finding> judge_servers(const SystemFacts& facts) {
  std::vector<Finding> findings;
  std::set<std::string> seen;
  for (const auto& process : facts.processes) {
    if (process.name == "jackd") findings.push_back(judge_jack(process));
    if (process.name == "jackdbus" && seen.insert("jackdbus").second)
      findings.push_back(
          {"JACK", State::Unknown, "jackdbus runs and keeps its settings to itself", "jack_control dp"});
    if (process.name == "pipewire" && seen.insert("pipewire").second)
      findings.push_back(judge_pipewire(facts.pipewire));
    if (process.name == "pulseaudio" && seen.insert("pulseaudio").second)
      findings.push_back(
          {"PulseAudio", State::Warn, "PulseAudio holds the sound cards", "pasuspender -- tactus play …"});
  }
  if (findings.empty())
    findings.push_back({"sound server", State::Ok, "none runs: Tactus has the cards for itself", ""});
  return findings;
}

std::vector<Finding> judge_system(const SystemFacts& facts, const Status& priority, const Status& memory) {
  std::vector<Finding> all{judge_priority(facts, priority), judge_memory(facts, memory)};
  if (!facts.known) {
    all.push_back({"system", State::Unknown,
                   "processors, kernel, sound servers and USB can only be looked at on Linux", ""});
    return all;
  }
  for (auto* judge : {judge_governor, judge_idle, judge_kernel, judge_interrupts})
    all.push_back(judge(facts));
  all.push_back(judge_swap(facts, memory.has_value()));
  all.push_back(judge_machine(facts));
  for (auto& finding : judge_servers(facts)) all.push_back(std::move(finding));
  all.push_back(judge_cards(facts));
  for (auto& finding : judge_usb(facts)) all.push_back(std::move(finding));
  return all;
}

}  // namespace tactus::app
