#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <regex>
#include <set>
#include <sstream>
#include <thread>

#include "apps/cli/backends.h"
#include "apps/cli/console.h"
#include "apps/cli/json.h"
#include "apps/cli/rig_files.h"
#include "apps/doctor/findings.h"
#include "apps/doctor/support_report.h"
#include "backends/realtime_thread.h"
#include "engine/core/named.h"
#include "engine/core/prefixed.h"
#include "latency/measured.h"

namespace tactus::app {
namespace {

using Text = std::optional<std::string>;

constexpr int kSlowWake_us = 100;  // a tenth of a block of 64 frames at 48 kHz
constexpr int kLongQuantum = 256;  // frames: 5 ms at 48 kHz
constexpr int kLowSwappiness = 10;

SystemFinding ok(std::string what) { return {SystemFinding::State::Ok, std::move(what)}; }
SystemFinding warn(std::string what, std::string command) {
  return {SystemFinding::State::Warn, std::move(what), std::move(command)};
}
SystemFinding unknown(std::string what, std::string command = "") {
  return {SystemFinding::State::Unknown, std::move(what), std::move(command)};
}

struct Findings : std::vector<SystemFinding> {
  void add(const char* name, SystemFinding finding) {
    finding.name = name;
    push_back(std::move(finding));
  }
};

bool contains(const Text& text, const std::string& word) {
  return text && text->find(word) != std::string::npos;
}

std::optional<int> number_in(const std::string& text) {
  int number = 0;
  const auto first = std::min(text.find_first_not_of(" \t"), text.size());
  const auto parsed = std::from_chars(text.data() + first, text.data() + text.size(), number);
  return parsed.ec == std::errc{} ? std::optional{number} : std::nullopt;
}

/// The line that begins with `start`, without it.
Text line_after(const Text& text, const std::string& start) {
  std::istringstream lines{text.value_or("")};
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with(start)) return line.substr(start.size());
  return std::nullopt;
}

/// "audio:x:29:me,you" in /etc/group: is 29 one of the user's groups?
bool in_audio_group(const SystemFiles& system) {
  const auto entry = line_after(system.text("etc/group"), "audio:").value_or("");
  const auto wanted = number_in(entry.substr(std::min(entry.size(), entry.find(':') + 1)));
  std::istringstream ids{line_after(system.text("proc/self/status"), "Groups:").value_or("")};
  for (int id = 0; ids >> id;)
    if (wanted == id) return true;
  return false;
}

/// The number behind one of the `names` of an option: "-p 64", "-p64", "--period=64".
std::optional<int> option_in(const std::string& arguments, const std::string& names) {
  std::smatch found;
  const std::regex option{" (" + names + ")[ =]?([0-9]+)"};
  return std::regex_search(arguments, found, option) ? number_in(found[2]) : std::nullopt;
}

/// Warns of a block of a sound server that is long.
SystemFinding check_block(const std::string& what, int frames, int rate, const char* command) {
  if (frames <= kLongQuantum) return ok(what);
  return warn(what + fmt::format(": {:.1f} ms each way", 1e3 * frames / rate), command);
}

SystemFinding check_jack(const std::vector<std::string>& all) {
  const auto driver = std::find_if(all.begin(), all.end(), [](const std::string& argument) {
    return argument.starts_with("-d") || argument.starts_with("--driver");
  });
  if (driver == all.end())
    return unknown("a JACK server is running but does not report its settings",
                   "jack_bufsize; jack_samplerate");
  const auto options = fmt::format(" {}", fmt::join(driver + 1, all.end(), " "));
  const int period = option_in(options, "-p|--period").value_or(1024);
  const int rate = option_in(options, "-r|--rate").value_or(48000);
  const auto what = fmt::format("jackd runs at {} Hz with {} frames per period", rate, period);
  if (std::any_of(all.begin(), driver,
                  [](const auto& text) { return text == "-r" || text == "--no-realtime"; }))
    return warn(what + ", without real-time priority (-r)",
                "jackd -R -d alsa -p 64   # restart it with -R added to its options");
  return check_block(what, period, rate, "jack_bufsize 64");
}

/// value:'1024' of  key:'clock.quantum'
std::optional<int> pipewire_setting(const std::string& text, const std::string& key) {
  const auto value = text.find("value:'", std::min(text.size(), text.find("key:'" + key + "'")));
  return value == std::string::npos ? std::nullopt : number_in(text.substr(value + 7));
}

SystemFinding check_pipewire(const std::string& settings) {
  const auto quantum = pipewire_setting(settings, "clock.quantum");
  const int rate = pipewire_setting(settings, "clock.rate").value_or(48000);
  if (!quantum)
    return unknown("PipeWire is running but does not report its quantum", "pw-metadata -n settings 0");
  const int forced = pipewire_setting(settings, "clock.force-quantum").value_or(0);
  const int frames = forced > 0 ? forced : *quantum;
  return check_block(fmt::format("PipeWire {} {} frames at {} Hz",
                                 forced > 0 ? "is forced to" : "runs by default at", frames, rate),
                     frames, rate, "pw-metadata -n settings 0 clock.force-quantum 64   # 0 undoes it");
}

const std::string kUsb = "sys/bus/usb/devices/";  // "1-2.3": port 3 of the hub at port 2 of bus 1

/// An interface of class 1 is audio, a device of class 9 a hub: USB-IF, "Defined class codes".
bool is_usb_audio(const SystemFiles& system, const std::string& device) {
  const auto interfaces = system.names(kUsb + device);
  return std::any_of(interfaces.begin(), interfaces.end(), [&](const std::string& name) {
    return system.line(kUsb + device + "/" + name + "/bInterfaceClass") == "01";
  });
}

std::string usb_name(const SystemFiles& system, const std::string& device) {
  const auto product = system.line(kUsb + device + "/product");
  return "'" + (product.empty() ? device : product) + "'";
}

/// "1-2" of "1-2.3"; empty for a device at a port of the machine itself.
std::string usb_parent(const std::string& device) {
  const auto dot = device.rfind('.');
  return dot == std::string::npos ? "" : device.substr(0, dot);
}

bool is_realtime(const SystemFiles& system) {
  return contains(system.text("sys/kernel/realtime"), "1") ||
         contains(system.text("proc/version"), "PREEMPT_RT");
}

/// Of every processor.
std::vector<std::string> processor_files(const SystemFiles& system, const std::string& file) {
  auto files = system.names("sys/devices/system/cpu/");
  for (auto& name : files) name = "sys/devices/system/cpu/" + name + "/" + file;
  return files;
}

struct Process {
  std::string name;
  std::vector<std::string> arguments;
};

std::vector<Process> processes_of(const SystemFiles& system) {
  std::vector<Process> all;
  for (const auto& id : system.names("proc")) {
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    Process process{system.line("proc/" + id + "/comm"), {}};
    std::istringstream line{system.text("proc/" + id + "/cmdline").value_or("")};
    for (std::string argument; std::getline(line, argument, '\0');) process.arguments.push_back(argument);
    all.push_back(std::move(process));
  }
  return all;
}

/// `item`: "rtprio", "memlock".
SystemFinding check_right(const SystemFiles& system, const Status& tried, const char* item,
                          const char* granted) {
  if (tried) return ok(granted);
  const auto& what = tried.error().what;
  if (!system.exists("proc")) return warn(what, tried.error().remedy);
  if (!contains(system.text("etc/security/limits.d/audio.conf"), item))
    return warn(what,
                "printf '@audio - rtprio 95\\n@audio - memlock unlimited\\n' | sudo tee "
                "/etc/security/limits.d/audio.conf && sudo usermod -aG audio $USER   # then log in again");
  if (!in_audio_group(system)) return warn(what, "sudo usermod -aG audio $USER   # then log in again");
  return warn(what,
              "exec su - $USER   # or log in again: the limits of this session are older than their file");
}

SystemFinding check_governor(const SystemState& system) {
  std::set<std::string> governors;
  for (const auto& file : processor_files(system, "cpufreq/scaling_governor"))
    governors.insert(system.line(file));
  governors.erase("");
  if (governors.empty()) return unknown("the processor clock cannot be read (a virtual machine?)");
  governors.erase("performance");
  if (governors.empty()) return ok("every processor runs at full clock speed");
  return warn("the governor '" + *governors.begin() + "' lowers the processor clock between blocks",
              "sudo cpupower frequency-set -g performance");
}

SystemFinding check_idle(const SystemState& system) {
  int longest = -1;
  for (const auto& folder : processor_files(system, "cpuidle"))
    for (const auto& state : system.names(folder))
      if (system.line(folder + "/" + state + "/disable") != "1")
        longest = std::max(longest, number_in(system.line(folder + "/" + state + "/latency")).value_or(-1));
  if (longest < 0) return unknown("idle states cannot be read");
  const auto what = fmt::format("processors wake up within {} us", longest);
  if (longest <= kSlowWake_us) return ok(what);
  return warn(what + ", too long for small blocks",
              fmt::format("sudo cpupower idle-set -D {}   # or: tactus play --awake", kSlowWake_us + 1));
}

SystemFinding check_kernel(const SystemState& system) {
  constexpr auto* kFull = "echo full | sudo tee /sys/kernel/debug/sched/preempt";
  const auto version = system.text("proc/version"), command_line = system.text("proc/cmdline"),
             preemption = system.text("sys/kernel/debug/sched/preempt");
  if (!version) return unknown("the kernel version cannot be read");
  if (is_realtime(system)) return ok("a real-time kernel (PREEMPT_RT)");
  if (contains(version, "PREEMPT_DYNAMIC")) {
    if (contains(preemption, "(full)") || contains(command_line, "preempt=full"))
      return ok("preemptible (PREEMPT_DYNAMIC, full)");
    if (contains(preemption, "(lazy)") || contains(command_line, "preempt=lazy"))
      return ok("preemptible by real-time threads (PREEMPT_DYNAMIC, lazy)");
    if (!preemption && !contains(command_line, "preempt="))
      return unknown("the preemption model is chosen at boot (PREEMPT_DYNAMIC), and only root can read it",
                     kFull);
    return warn("system calls of other programs delay the audio thread (not fully preemptible)", kFull);
  }
  if (contains(version, "PREEMPT")) return ok("preemptible (PREEMPT)");
  return warn("system calls of other programs delay the audio thread (a kernel without preemption)",
              "sudo apt-get install linux-image-rt-amd64   # then boot it");
}

SystemFinding check_interrupts(const SystemState& system) {
  const auto command_line = system.text("proc/cmdline");
  if (!system.text("proc/version") || !command_line) return unknown("the interrupt settings cannot be read");
  if (!is_realtime(system) && !contains(command_line, "threadirqs"))
    return warn(
        "disk and network interrupts have priority over the audio thread",
        "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&threadirqs /' /etc/default/grub && sudo update-grub   # "
        "then boot");
  if (system.exists("usr/sbin/rtirq") || system.exists("etc/init.d/rtirq"))
    return ok("interrupts run in threads; rtirq gives the sound card's interrupt the highest priority");
  return warn("interrupts run in threads; the sound card's interrupt has no higher priority than others",
              "sudo apt-get install rtirq-init");
}

SystemFinding check_swap(const SystemState& system) {
  const auto swaps = system.text("proc/swaps");
  if (!swaps) return unknown("swap cannot be read");
  if (std::count(swaps->begin(), swaps->end(), '\n') <= 1) return ok("no swap");
  if (system.memory) return ok("swap is in use, but the program's memory is locked");
  const auto swappiness = number_in(system.line("proc/sys/vm/swappiness"));
  if (swappiness && *swappiness <= kLowSwappiness)
    return ok(fmt::format("memory is rarely swapped out (swappiness {})", *swappiness));
  return warn(
      "the program's memory may be swapped out during playback",
      fmt::format("echo vm.swappiness={} | sudo tee /etc/sysctl.d/90-audio.conf && sudo sysctl --system",
                  kLowSwappiness));
}

SystemFinding check_machine(const SystemState& system) {
  const auto processors = system.text("proc/cpuinfo");
  if (!processors) return unknown("the processor cannot be read");
  if (!contains(processors, " hypervisor")) return ok("no virtual machine");
  return warn(
      "a virtual machine may be paused for milliseconds by its host: use blocks of 256 frames or more",
      "systemd-detect-virt   # shows which one; play on the host instead, or with tactus play --awake");
}

SystemFinding check_cards(const SystemState& system) {
  const auto cards = system.text("proc/asound/cards");
  if (!cards) return unknown("the kernel does not list sound cards (no ALSA)");
  std::vector<std::string> names;
  std::istringstream lines{*cards};
  for (std::string line; std::getline(lines, line);) {
    const auto open = line.find('['), dash = line.find(" - ", open);
    if (open != std::string::npos && dash != std::string::npos) names.push_back(line.substr(dash + 3));
  }
  if (!names.empty()) return ok(fmt::format("{}", fmt::join(names, ", ")));
  return warn("no sound card is connected",
              "sudo dmesg | tail   # shows what happened when it was connected");
}

/// For a loop of one frame a call; only where there is a data acquisition card.
void check_acquisition(const SystemState& system, Findings& findings) {
  const auto numbered = [&](const char* folder, const std::string& what) {
    auto names = system.names(folder);
    std::erase_if(names, [&](const std::string& name) {
      return !name.starts_with(what) || name.size() == what.size() ||
             name.find_first_not_of("0123456789", what.size()) != std::string::npos;
    });
    return names;
  };
  const auto cards = fmt::format("{}", fmt::join(numbered("dev", "comedi"), ", "));
  if (cards.empty()) return;
  const auto isolated = system.line("sys/devices/system/cpu/isolated");
  if (!isolated.empty())
    return findings.add("data acquisition", ok(cards + ": core " + isolated + " is isolated for its loop"));
  const auto cores = numbered("sys/devices/system/cpu", "cpu").size();
  findings.add(
      "data acquisition",
      warn(cards + ": other programs run on the core of its loop, and frames come late",
           fmt::format("sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&isolcpus={0} nohz_full={0} /' "
                       "/etc/default/grub && sudo update-grub   # then boot, and add ,core={0} to the "
                       "device",
                       std::max<std::size_t>(cores, 2) - 1)));
}

/// A finding for each sound card on USB, or one that says that there is none.
void check_usb(const SystemFiles& system, Findings& findings) {
  const auto before = findings.size();
  auto devices = system.names(kUsb);
  std::erase_if(devices, [](const std::string& name) {
    return name.find('-') == std::string::npos || name.find(':') != std::string::npos;
  });
  for (const auto& device : devices) {
    if (!is_usb_audio(system, device)) continue;
    const auto name = usb_name(system, device), parent = usb_parent(device);
    const auto neighbour = std::find_if(devices.begin(), devices.end(), [&](const std::string& other) {
      return other != device && !parent.empty() && usb_parent(other) == parent &&
             system.line(kUsb + other + "/bDeviceClass") != "09";
    });
    findings.add("USB",
                 system.line(kUsb + device + "/power/control") == "auto"
                     ? warn(name + " may be suspended when idle",
                            "echo on | sudo tee /sys/bus/usb/devices/" + device + "/power/control")
                 : neighbour != devices.end()
                     ? warn(name + " shares a hub with " + usb_name(system, *neighbour),
                            "lsusb -t   # shows the ports; connect the card to a port of the computer itself")
                     : ok(name + " is never suspended and does not share a hub"));
  }
  if (findings.size() == before)
    findings.add("USB", devices.empty() ? unknown("USB devices cannot be read")
                                        : ok("no sound card is connected by USB"));
}

/// The same for sound servers that run.
void check_servers(const SystemState& system, Findings& findings) {
  const auto before = findings.size();
  std::set<std::string> seen;
  for (const auto& [name, arguments] : processes_of(system)) {
    const bool first = seen.insert(name).second;
    if (name == "jackd") findings.add("JACK", check_jack(arguments));
    if (!first) continue;
    if (name == "jackdbus")
      findings.add("JACK",
                   unknown("jackdbus is running but does not report its settings", "jack_control dp"));
    if (name == "pipewire") findings.add("PipeWire", check_pipewire(system.pipewire));
    if (name == "pulseaudio")
      findings.add("PulseAudio", warn("PulseAudio occupies the sound cards", "pasuspender -- tactus play …"));
  }
  if (findings.size() == before)
    findings.add("sound server", ok("none is running: Tactus has exclusive access to the cards"));
}

constexpr std::pair<const char*, SystemFinding (*)(const SystemState&)> kChecks[] = {
    {"CPU governor", check_governor},
    {"CPU idle states", check_idle},
    {"kernel", check_kernel},
    {"interrupts", check_interrupts},
    {"swap", check_swap},
    {"machine", check_machine}};

constexpr int kPriority = 70;  // below that of the threads of interrupts, 50 + 40 with rtirq

/// The settings of a PipeWire that runs; empty where there is none.
std::string pipewire_settings([[maybe_unused]] const SystemFiles& system) {
  std::string text;
#if defined(__linux__)
  const auto processes = processes_of(system);
  if (find_named(processes, "pipewire") == nullptr) return text;
  std::FILE* pipe = popen("timeout 2 pw-metadata -n settings 0 2>/dev/null </dev/null", "r");
  if (pipe == nullptr) return text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  pclose(pipe);
#endif
  return text;
}

const char* name_of(SystemFinding::State state) {
  return state == SystemFinding::State::Ok ? "ok" : state == SystemFinding::State::Warn ? "warn" : "unknown";
}

Json finding_json(const SystemFinding& finding) {
  return {{"name", finding.name},
          {"state", name_of(finding.state)},
          {"what", finding.what},
          {"command", finding.command}};
}

struct DoctorOptions {
  std::string rig, report;
  bool json = false;
};

/// The devices of every backend as `tactus devices` knows them.
std::string devices_text() {
  std::string text;
  for (const auto& backend : all_backends()) {
    const auto devices = backend.make()->devices();
    if (!devices) {
      text += backend.name + ": " + to_string(devices.error()) + "\n";
      continue;
    }
    for (const auto& device : *devices) {
      std::vector<double> rates;
      for (const auto& rate : device.sample_rates) rates.push_back(rate.value / 1e3);
      text += fmt::format("{}: {} in, {} out, {:g} kHz ({:g})\n", device.id, device.in_channels,
                          device.out_channels, device.default_rate.value / 1e3, fmt::join(rates, ", "));
    }
  }
  return text.empty() ? "none" : text;
}

std::string delay_line(const MeasuredDelay& measured) {
  return fmt::format("{}: {:.4f} ms, {:g} Hz, {} frames per block{}, {}\n", measured.key.output,
                     1e3 * measured.delay.value, measured.key.sample_rate.value, measured.key.block_frames,
                     measured.key.periods > 0 ? fmt::format(", {} periods", measured.key.periods) : "",
                     measured.when);
}

void write_report(const DoctorOptions& options, const SystemState& system,
                  const std::vector<SystemFinding>& findings) {
  std::string delays;
  const auto known = MeasuredDelays::load();
  for (const auto& measured : known.all()) delays += delay_line(measured);
  std::vector<std::pair<std::string, std::string>> sections{
      {"devices", devices_text()}, {"measured latencies", delays.empty() ? "none on this computer" : delays}};
  if (!options.rig.empty())
    if (const auto text = SystemFiles{""}.text(options.rig)) sections.emplace_back("rig", *text);
  const auto report = support_report(system, findings, sections, PersonalNames::of_process());
  if (!(std::ofstream{options.report, std::ios::binary} << report))
    exit_with({Errc::BadFile, options.report, "it cannot be written", "choose another file"}, kBadFile);
  fmt::print(stderr, "written: {}; read it through, then attach it to the description of your problem\n",
             options.report);
}

int run_doctor(const DoctorOptions& options) {
  SystemState system;
  // A thread takes its priority with it when it ends.
  std::thread{[&] { system.priority = become_realtime(kPriority); }}.join();
  system.memory = lock_memory();
  system.pipewire = pipewire_settings(system);
  auto findings = check_system(system);
  if (!options.rig.empty())
    for (auto& finding : check_rig_outputs(open_rig(options.rig), options.rig))
      findings.push_back(std::move(finding));
  const bool warned = std::ranges::count(findings, SystemFinding::State::Warn, &SystemFinding::state) > 0;
  if (options.json) print_json({{"ok", !warned}, {"findings", list_of(findings, finding_json)}});
  for (const auto& [state, what, command, name] : findings) {
    if (options.json) continue;
    fmt::print("{:8} {:18}  {}\n", name_of(state), name, what);
    if (!command.empty()) fmt::print("{:29}{}\n", "", command);
  }
  if (!options.report.empty()) write_report(options, system, findings);
  return warned ? kNo : kDone;
}

}  // namespace

std::vector<SystemFinding> check_system(const SystemState& system) {
  Findings all;
  all.add("real-time priority",
          check_right(system, system.priority, "rtprio", "this user's threads can use SCHED_FIFO"));
  all.add("memory lock", check_right(system, system.memory, "memlock", "the program can lock its memory"));
  if (!system.exists("proc")) {
    all.add("system", unknown("processors, kernel, sound servers and USB can only be checked on Linux"));
    return all;
  }
  for (const auto& [name, check] : kChecks) all.add(name, check(system));
  check_servers(system, all);
  all.add("sound cards", check_cards(system));
  check_acquisition(system, all);
  check_usb(system, all);
  return all;
}

std::vector<SystemFinding> check_rig_outputs(const Rig& rig, const std::string& file) {
  Findings all;
  if (!has_capacitors(backend_of(rig.device.output))) return {};
  for (const auto& output : rig.outputs) {
    if (output.channels.empty() || output.on_second_device()) continue;
    const auto name = "output '" + output.name + "'";
    if (output.highpass)
      all.add("rig",
              warn(fmt::format("{} passes a high-pass of {}: {}; walls, springs and detents leak away", name,
                               prefixed(output.highpass->value, "Hz"), decay_text(*output.highpass)),
                   "tactus check INSTRUMENT --rig " + file));
    else
      all.add("rig", unknown(name + ": it is not known whether it is AC-coupled (output_highpass)",
                             "tactus latency measure --rig " + file));
  }
  return all;
}

void add_doctor(CLI::App& app, int& exit_code) {
  auto [command, options] = add_command(
      app, "doctor", "Check whether this system is set up for low-latency audio", exit_code, run_doctor);
  command.add_option("--rig", options.rig, "rig file; what its outputs can hold");
  command
      .add_option_function<std::string>(
          "--report",
          [&report = options.report](const std::string& file) {
            if (file.empty()) throw CLI::ValidationError{"--report", "the text is empty; give a file"};
            report = file;
          },
          "text file to send to who helps you; no names of users and computers are in it")
      ->expected(0, 1)
      ->default_str("tactus_report.txt")
      ->check(writable_file());
  command.add_flag("--json", options.json, "print the report as JSON");
  command.footer(
      "Examples:\n  tactus doctor\n  tactus doctor --rig desk.toml --report problem.txt\nIt only reads "
      "settings. Each finding is followed by the command that fixes "
      "it or shows more.\nExit code 1: at least one warning.");
}

}  // namespace tactus::app
