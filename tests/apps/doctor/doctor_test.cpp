#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/doctor/findings.h"
#include "apps/doctor/support_report.h"
#include "backends/acquisition_backends.h"
#include "backends/backend.h"
#include "engine/core/named.h"
#include "tests/support/error_summary.h"
#include "tests/support/temporary_folder.h"

// Texts of real systems, and what the doctor must say of them.

using namespace tactus;
using namespace tactus::app;

namespace {

using State = SystemFinding::State;

const Status kGranted = {};
const Status kRefused = fail(Errc::Device, "", "Operation not permitted");

constexpr auto* kDebian =
    "Linux version 6.1.0-13-amd64 (debian-kernel@lists.debian.org) #1 SMP PREEMPT_DYNAMIC Debian 6.1.55-1";
constexpr auto* kDebianRt =
    "Linux version 6.1.0-13-rt-amd64 (debian-kernel@lists.debian.org) #1 SMP PREEMPT_RT Debian 6.1.55-1";
constexpr auto* kServer = "Linux version 3.10.0-1160.el7.x86_64 (mockbuild@kbuilder) #1 SMP Mon Oct 19 2020";

/// A system made of some files.
class FakeSystem : public SystemState {
 public:
  explicit FakeSystem(
      std::unique_ptr<test::TemporaryFolder> folder = std::make_unique<test::TemporaryFolder>())
      : SystemState(folder->path()), folder_(std::move(folder)) {}
  void write(const std::string& path, const std::string& text) const { folder_->write(path, text); }
  void version(const char* version, const char* command_line) const {
    write("proc/version", version);
    write("proc/cmdline", command_line);
  }

 private:
  std::unique_ptr<test::TemporaryFolder> folder_;
};

/// What is found under a name; of a system without /proc, that it is unknown.
SystemFinding found(const SystemState& system, const std::string& name) {
  const auto all = check_system(system);
  const auto* finding = find_named(all, name);
  return finding != nullptr ? *finding : all.back();
}

State kernel(const char* version, const char* preemption = nullptr, const char* command_line = "quiet") {
  const FakeSystem system;
  system.version(version, command_line);
  if (preemption != nullptr) system.write("sys/kernel/debug/sched/preempt", preemption);
  return found(system, "kernel").state;
}

State interrupts(const char* version, const char* command_line, bool rtirq) {
  const FakeSystem system;
  system.version(version, command_line);
  if (rtirq) system.write("usr/sbin/rtirq", "");
  return found(system, "interrupts").state;
}

SystemFinding server(const std::string& name, const std::vector<std::string>& arguments,
                     const std::string& pipewire = "") {
  FakeSystem system;
  system.write("proc/41/comm", "bash\n");
  system.write("proc/42/comm", name + "\n");
  std::string line;
  for (const auto& argument : arguments) line += argument + '\0';
  system.write("proc/42/cmdline", line);
  system.pipewire = pipewire;
  auto findings = check_system(system);
  std::erase_if(findings, [](const SystemFinding& finding) {
    return std::string{"JACK PipeWire PulseAudio sound server"}.find(finding.name) == std::string::npos;
  });
  REQUIRE(findings.size() == 1);
  return findings[0];
}

std::string quantum(int usual, int forced) {
  return "Found \"settings\" metadata 31\nupdate: id:0 key:'clock.rate' value:'48000' type:''\n"
         "update: id:0 key:'clock.quantum' value:'" +
         std::to_string(usual) + "' type:''\nupdate: id:0 key:'clock.min-quantum' value:'32' type:''\n" +
         "update: id:0 key:'clock.force-quantum' value:'" + std::to_string(forced) + "' type:''\n";
}

}  // namespace

TEST_CASE("doctor: missing real-time priority is reported with each step that fixes it", "[doctor]") {
  FakeSystem system;
  const auto command = [&](const char* name) { return found(system, name).command; };
  CHECK(found(system, "real-time priority").state == State::Ok);
  system.priority = system.memory = kRefused;
  system.write("etc/group", "root:x:0:\naudio:x:29:pulse\nme:x:1000:\n");
  system.write("proc/self/status", "Name:\ttactus\nGroups:\t1000 \n");
  CHECK(found(system, "real-time priority").state == State::Warn);
  CHECK(command("real-time priority").find("sudo tee /etc/security/limits.d/audio.conf") !=
        std::string::npos);
  system.write("etc/security/limits.d/audio.conf",
               "@audio   -  rtprio     95\n@audio   -  memlock    unlimited\n");
  CHECK(command("real-time priority") == "sudo usermod -aG audio $USER   # then log in again");
  CHECK(command("memory lock") == "sudo usermod -aG audio $USER   # then log in again");
  system.write("proc/self/status", "Name:\ttactus\nGroups:\t29 1000 \n");
  CHECK(command("memory lock").starts_with("exec su - $USER"));
}

TEST_CASE("doctor: kernels and their preemption", "[doctor]") {
  CHECK(kernel(kDebianRt) == State::Ok);
  CHECK(kernel(kDebian) == State::Unknown);
  CHECK(kernel(kDebian, "none voluntary (full)\n") == State::Ok);
  CHECK(kernel(kDebian, "none (voluntary) full\n") == State::Warn);
  CHECK(kernel(kDebian, "none voluntary full (lazy)\n") == State::Ok);
  CHECK(kernel(kDebian, nullptr, "quiet preempt=full") == State::Ok);
  CHECK(kernel(kDebian, nullptr, "quiet preempt=voluntary") == State::Warn);
  CHECK(kernel("Linux version 5.15.0-86-lowlatency (buildd@lcy02) #95-Ubuntu SMP PREEMPT") == State::Ok);
  CHECK(kernel(kServer) == State::Warn);
  CHECK(found(FakeSystem{}, "kernel").state == State::Unknown);
}

TEST_CASE("doctor: interrupts are threads, and the card's comes first", "[doctor]") {
  CHECK(interrupts(kDebian, "quiet", false) == State::Warn);
  CHECK(interrupts(kDebian, "quiet threadirqs", false) == State::Warn);
  CHECK(interrupts(kDebian, "quiet threadirqs", true) == State::Ok);
  CHECK(interrupts(kDebianRt, "quiet", true) == State::Ok);
}

TEST_CASE("doctor: governors, idle states, swap and virtual machines", "[doctor]") {
  FakeSystem system;
  system.memory = kRefused;
  const std::string processors = "sys/devices/system/cpu/cpu";
  system.write("proc/version", kServer);
  CHECK(found(system, "CPU governor").state == State::Unknown);
  system.write(processors + "0/cpufreq/scaling_governor", "performance\n");
  CHECK(found(system, "CPU governor").state == State::Ok);
  system.write(processors + "1/cpufreq/scaling_governor", "powersave\n");
  CHECK(found(system, "CPU governor").state == State::Warn);
  CHECK(found(system, "CPU governor").what.find("'powersave'") != std::string::npos);
  CHECK(found(system, "CPU idle states").state == State::Unknown);
  int state = 0;
  const auto add_state = [&](int latency_us, const char* disable) {
    const auto folder = processors + "0/cpuidle/state" + std::to_string(state++);
    system.write(folder + "/latency", std::to_string(latency_us) + "\n");
    system.write(folder + "/disable", disable);
  };
  for (const int latency_us : {0, 2, 10, 85}) add_state(latency_us, "0\n");  // POLL, C1, C1E, C3
  add_state(900, "1\n");
  CHECK(found(system, "CPU idle states").state == State::Ok);
  add_state(1034, "0\n");  // C10 of a laptop
  CHECK(found(system, "CPU idle states").command ==
        "sudo cpupower idle-set -D 101   # or: tactus play --awake");
  CHECK(found(system, "swap").state == State::Unknown);
  const std::string heading = "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n";
  system.write("proc/swaps", heading);
  CHECK(found(system, "swap").state == State::Ok);
  system.write("proc/swaps",
               heading + "/dev/dm-2                               partition\t16777212\t0\t\t-2\n");
  system.write("proc/sys/vm/swappiness", "60\n");
  CHECK(found(system, "swap").state == State::Warn);
  system.memory = kGranted;
  CHECK(found(system, "swap").state == State::Ok);
  system.memory = kRefused;
  system.write("proc/sys/vm/swappiness", "10\n");
  CHECK(found(system, "swap").state == State::Ok);
  system.write("proc/cpuinfo", "flags\t\t: fpu vme de sse2 ht syscall nx rdtscp lm\n");
  CHECK(found(system, "machine").state == State::Ok);
  system.write("proc/cpuinfo", "flags\t\t: fpu vme de sse2 ht syscall nx rdtscp lm hypervisor lahf_lm\n");
  CHECK(found(system, "machine").state == State::Warn);
  CHECK(found(system, "machine").command.find("--awake") != std::string::npos);
}

TEST_CASE("doctor: sound servers, their rates and their blocks", "[doctor]") {
  CHECK(server("cron", {"cron"}).state == State::Ok);
  const auto good =
      server("jackd", {"jackd", "-R", "-P", "80", "-d", "alsa", "-r", "96000", "-p", "64", "-n", "2"});
  CHECK(good.state == State::Ok);
  CHECK(test::names_in(good.what) == "96000 64");
  CHECK(test::names_in(server("jackd", {"/usr/bin/jackd", "-dalsa", "-dhw:USB", "-r48000", "-p128"}).what) ==
        "48000 128");
  CHECK(server("jackd", {"jackd", "-r", "-d", "dummy", "--period=64"}).state == State::Warn);
  const auto slow = server("jackd", {"jackd", "-d", "alsa"});
  CHECK(slow.state == State::Warn);
  CHECK(test::names_in(slow.what) == "48000 1024 21.3");
  CHECK(slow.command == "jack_bufsize 64");
  CHECK(server("jackdbus", {"jackdbus", "auto"}).state == State::Unknown);
  CHECK(server("pulseaudio", {"pulseaudio"}).state == State::Warn);
  CHECK(server("pipewire", {"pipewire"}).state == State::Unknown);
  const auto usual = server("pipewire", {"pipewire"}, quantum(1024, 0));
  CHECK(usual.state == State::Warn);
  CHECK(test::names_in(usual.what) == "1024 48000 21.3");
  CHECK(test::names_in(server("pipewire", {"pipewire"}, quantum(1024, 64)).what) == "64 48000");
  CHECK(server("pipewire", {"pipewire"}, quantum(128, 0)).state == State::Ok);
}

TEST_CASE("doctor: cards, and where they are connected by USB", "[doctor]") {
  const FakeSystem system;
  system.write("proc/version", kServer);
  CHECK(found(system, "sound cards").state == State::Unknown);
  system.write("proc/asound/cards", "--- no soundcards ---\n");
  CHECK(found(system, "sound cards").state == State::Warn);
  system.write(
      "proc/asound/cards",
      " 0 [PCH            ]: HDA-Intel - HDA Intel PCH\n                      HDA Intel PCH at 0xa1228000 "
      "irq 137\n"
      " 1 [USB            ]: USB-Audio - Scarlett 2i2 USB\n                      Focusrite Scarlett 2i2 "
      "USB\n");
  CHECK(found(system, "sound cards").what == "HDA Intel PCH, Scarlett 2i2 USB");
  const std::string usb = "sys/bus/usb/devices/";
  CHECK(found(system, "USB").state == State::Unknown);
  system.write(usb + "1-1/product", "USB2.0 Hub\n");
  system.write(usb + "1-1/bDeviceClass", "09\n");
  system.write(usb + "1-2/product", "Keyboard\n");
  CHECK(found(system, "USB").state == State::Ok);
  system.write(usb + "1-1.2/product", "Scarlett 2i2 USB\n");
  system.write(usb + "1-1.2/power/control", "on\n");
  system.write(usb + "1-1.2/1-1.2:1.0/bInterfaceClass", "01\n");
  CHECK(found(system, "USB").state == State::Ok);
  system.write(usb + "1-1.4/product", "Webcam\n");
  CHECK(test::names_in(found(system, "USB").what) == "'Scarlett 2i2 USB' 'Webcam'");
  system.write(usb + "1-1.2/power/control", "auto\n");
  CHECK(found(system, "USB").command == "echo on | sudo tee /sys/bus/usb/devices/1-1.2/power/control");
}

TEST_CASE("doctor: of a system that it cannot read it says so", "[doctor]") {
  FakeSystem system;
  system.priority = kRefused;
  const auto findings = check_system(system);
  REQUIRE(findings.size() == 3);
  CHECK(findings[0].state == State::Warn);
  CHECK(findings[1].state == State::Ok);
  CHECK(findings[2].state == State::Unknown);
}

TEST_CASE("doctor: the command runs without a card, and its exit code says whether something warns",
          "[doctor]") {
  const test::TemporaryFolder folder;
  const auto report = folder.path() / "report.json";
  const int status =
      std::system((std::string{TACTUS_PROGRAM} + " doctor --json > " + report.string()).c_str());
  std::ifstream text{report};
  const auto json = nlohmann::json::parse(text);
  CHECK(json["findings"].size() >= 3);
  bool warns = false;
  for (const auto& finding : json["findings"]) warns = warns || finding["state"] == "warn";
  CHECK(json["ok"] == !warns);
  CHECK(status == (warns ? 256 : 0));  // as wait() reports an exit code of 1
}

TEST_CASE("doctor: an AC-coupled output of a rig is a warning with its time constant, an unknown one is said",
          "[doctor]") {
  Rig rig;
  rig.outputs.push_back({{"motor", {}, {1}, ""}, {}, Hertz{2.0}});
  rig.outputs.push_back({{"sound", {}, {2}, ""}, {}, {}});
  rig.outputs.push_back({{"spare", {}, {}, ""}, {}, {}});  // not connected
  const auto findings = check_rig_outputs(rig, "desk.toml");
  REQUIRE(findings.size() == 2);
  CHECK(findings[0].state == State::Warn);
  // 1 / (2 pi 2 Hz)
  CHECK(findings[0].what.find("79.58 ms") != std::string::npos);
  CHECK(findings[1].state == State::Unknown);
  CHECK(findings[1].command == "tactus latency measure --rig desk.toml");
}

TEST_CASE("doctor: motors of a gamepad are not asked for AC coupling", "[doctor]") {
  Rig rig;
  rig.outputs.push_back({{"motor", {}, {1}, ""}, {}, {}});
  rig.device.output = "alsa:Box";
  CHECK(check_rig_outputs(rig, "pad.toml").size() == 1);
  for (const auto& backend : haptic_backends()) {
    rig.device.output = backend.name + ":Xbox Wireless Controller";
    CHECK(check_rig_outputs(rig, "pad.toml").empty());
  }
}

TEST_CASE("doctor: a data acquisition card should have a core of its own", "[doctor]") {
  const FakeSystem system;
  system.version(kDebianRt, "quiet");
  system.write("dev/comedi0_subd0", "");  // a part of a card
  const auto none = check_system(system);
  CHECK(find_named(none, "data acquisition") == nullptr);
  system.write("dev/comedi0", "");
  for (const auto* core : {"cpu0", "cpu1", "cpu2", "cpu3", "cpufreq"})
    system.write(std::string{"sys/devices/system/cpu/"} + core + "/online", "1\n");
  const auto shared = found(system, "data acquisition");
  CHECK(shared.state == State::Warn);
  CHECK(shared.command.find("isolcpus=3") != std::string::npos);
  system.write("sys/devices/system/cpu/isolated", "3\n");
  CHECK(found(system, "data acquisition").state == State::Ok);
}

TEST_CASE("doctor: outputs of a data acquisition card are not asked for AC coupling", "[doctor]") {
  Rig rig;
  rig.outputs.push_back({{"motor", {}, {1}, ""}, {}, {}});
  for (const auto& backend : acquisition_backends()) {
    rig.device.output = backend.name + ":/dev/comedi0";
    CHECK(check_rig_outputs(rig, "arm.toml").empty());
  }
}

TEST_CASE("doctor: its report has system, servers, formats of cards and findings, and no personal names",
          "[doctor]") {
  const FakeSystem system;
  system.write("etc/os-release", "NAME=x\nPRETTY_NAME=\"Debian GNU/Linux 12 (bookworm)\"\n");
  system.write("proc/sys/kernel/osrelease", "6.1.0-13-amd64\n");
  system.write("proc/cpuinfo", "model name\t: Some CPU\nflags\t: a b\nmodel name\t: Some CPU\n");
  system.write("proc/asound/cards", " 0 [USB            ]: USB-Audio - Box\n");
  system.write("proc/asound/card0/stream0",
               "Box at usb-1, high speed : USB Audio\n\nPlayback:\n  Status: Stop\n    Format: S24_3LE\n    "
               "Rates: 44100, 48000\n");
  system.write("proc/12/comm", "jackd\n");
  system.write("proc/12/cmdline", std::string{"jackd\0-dalsa\0-p64\0", 17});
  const std::vector<SystemFinding> findings{{State::Warn, "the governor 'ondemand'", "", "CPU governor"}};
  const auto text =
      support_report(system, findings,
                     {{"rig",
                       "name = \"desk of anna\"\nprofile = \"/home/anna/woofer.toml\"\noutput = "
                       "\"hw:USB@1-2 serial 4711\"\n# annas box at pultpc\n"}},
                     {"/home/anna", "anna", "pultpc"});
  for (const auto* part : {"tactus 0.1.0", "Debian GNU/Linux 12 (bookworm)", "6.1.0-13-amd64", "2 x Some CPU",
                           "jackd -dalsa -p64", "Format: S24_3LE", "Rates: 44100, 48000", "CPU governor",
                           "desk of USER", "~/woofer.toml", "serial (left out)", "annas box at HOST"}) {
    CAPTURE(part);
    CHECK(text.find(part) != std::string::npos);
  }
  for (const auto* part : {"/home/anna", " anna\"", "pultpc", "4711", "Status"}) {
    CAPTURE(part);
    CHECK(text.find(part) == std::string::npos);
  }
}
