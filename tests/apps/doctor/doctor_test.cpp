#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/check/judge_system.h"
#include "tests/support/temporary_folder.h"

// Texts of real systems, and what the doctor must say of them.

using namespace tactus;
using namespace tactus::app;

namespace {

using State = Finding::State;

const Status kGranted = {};
const Status kRefused = fail(Errc::Device, "", "Operation not permitted");

constexpr auto* kDebian =
    "Linux version 6.1.0-13-amd64 (debian-kernel@lists.debian.org) #1 SMP PREEMPT_DYNAMIC Debian 6.1.55-1";
constexpr auto* kDebianRt =
    "Linux version 6.1.0-13-rt-amd64 (debian-kernel@lists.debian.org) #1 SMP PREEMPT_RT Debian 6.1.55-1";
constexpr auto* kServer = "Linux version 3.10.0-1160.el7.x86_64 (mockbuild@kbuilder) #1 SMP Mon Oct 19 2020";

State kernel(const char* version, SystemFacts::Text preemption = {}, const char* command_line = "quiet") {
  SystemFacts facts;
  facts.version = version;
  facts.preemption = std::move(preemption);
  facts.command_line = command_line;
  return judge_kernel(facts).state;
}

State interrupts(const char* version, const char* command_line, bool rtirq) {
  SystemFacts facts;
  facts.version = version;
  facts.command_line = command_line;
  facts.rtirq = rtirq;
  return judge_interrupts(facts).state;
}

Finding server(const std::string& name, std::vector<std::string> arguments, SystemFacts::Text pipewire = {}) {
  SystemFacts facts;
  facts.processes = {{"bash", {"-bash"}}, {name, std::move(arguments)}};
  facts.pipewire = std::move(pipewire);
  const auto findings = judge_servers(facts);
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

TEST_CASE("doctor: who gets no priority is told what mends it, step by step", "[doctor]") {
  SystemFacts facts;
  facts.known = true;
  CHECK(judge_priority(facts, kGranted).state == State::Ok);
  facts.groups = "root:x:0:\naudio:x:29:pulse\nme:x:1000:\n";
  facts.user_groups = "\t1000 ";
  CHECK(judge_priority(facts, kRefused).state == State::Warn);
  CHECK(judge_priority(facts, kRefused).command.find("sudo tee /etc/security/limits.d/audio.conf") !=
        std::string::npos);
  facts.audio_limits = "@audio   -  rtprio     95\n@audio   -  memlock    unlimited\n";
  CHECK(judge_priority(facts, kRefused).command == "sudo usermod -aG audio $USER   # then log in again");
  CHECK(judge_memory(facts, kRefused).command == "sudo usermod -aG audio $USER   # then log in again");
  facts.user_groups = "\t29 1000 ";
  CHECK(judge_memory(facts, kRefused).command.starts_with("exec su - $USER"));
}

TEST_CASE("doctor: kernels and their preemption", "[doctor]") {
  CHECK(kernel(kDebianRt) == State::Ok);
  CHECK(kernel(kDebian) == State::Unknown);
  CHECK(kernel(kDebian, "none voluntary (full)\n") == State::Ok);
  CHECK(kernel(kDebian, "none (voluntary) full\n") == State::Warn);
  CHECK(kernel(kDebian, "none voluntary full (lazy)\n") == State::Ok);
  CHECK(kernel(kDebian, {}, "quiet preempt=full") == State::Ok);
  CHECK(kernel(kDebian, {}, "quiet preempt=voluntary") == State::Warn);
  CHECK(kernel("Linux version 5.15.0-86-lowlatency (buildd@lcy02) #95-Ubuntu SMP PREEMPT") == State::Ok);
  CHECK(kernel(kServer) == State::Warn);
  CHECK(judge_kernel({}).state == State::Unknown);
}

TEST_CASE("doctor: interrupts are threads, and the card's comes first", "[doctor]") {
  CHECK(interrupts(kDebian, "quiet", false) == State::Warn);
  CHECK(interrupts(kDebian, "quiet threadirqs", false) == State::Warn);
  CHECK(interrupts(kDebian, "quiet threadirqs", true) == State::Ok);
  CHECK(interrupts(kDebianRt, "quiet", true) == State::Ok);
}

TEST_CASE("doctor: governors, idle states, swap and virtual machines", "[doctor]") {
  SystemFacts facts;
  CHECK(judge_governor(facts).state == State::Unknown);
  facts.governors = {"performance", "performance"};
  CHECK(judge_governor(facts).state == State::Ok);
  facts.governors = {"performance", "powersave"};
  CHECK(judge_governor(facts).what == "the governor 'powersave' slows processors down between blocks");
  CHECK(judge_idle(facts).state == State::Unknown);
  facts.idle_latencies_us = {0, 2, 10, 85};  // POLL, C1, C1E, C3
  CHECK(judge_idle(facts).state == State::Ok);
  facts.idle_latencies_us.push_back(1034);  // C10 of a laptop
  CHECK(judge_idle(facts).command == "sudo cpupower idle-set -D 101");
  CHECK(judge_swap(facts, false).state == State::Unknown);
  facts.swaps = "Filename\t\t\t\tType\t\tSize\t\tUsed\t\tPriority\n";
  CHECK(judge_swap(facts, false).state == State::Ok);
  *facts.swaps += "/dev/dm-2                               partition\t16777212\t0\t\t-2\n";
  facts.swappiness = "60\n";
  CHECK(judge_swap(facts, false).state == State::Warn);
  CHECK(judge_swap(facts, true).state == State::Ok);
  facts.swappiness = "10\n";
  CHECK(judge_swap(facts, false).state == State::Ok);
  facts.cpu_info = "flags\t\t: fpu vme de sse2 ht syscall nx rdtscp lm\n";
  CHECK(judge_machine(facts).state == State::Ok);
  facts.cpu_info = "flags\t\t: fpu vme de sse2 ht syscall nx rdtscp lm hypervisor lahf_lm\n";
  CHECK(judge_machine(facts).state == State::Warn);
}

TEST_CASE("doctor: sound servers, their rates and their blocks", "[doctor]") {
  CHECK(server("cron", {"cron"}).what == "none runs: Tactus has the cards for itself");
  const auto good =
      server("jackd", {"jackd", "-R", "-P", "80", "-d", "alsa", "-r", "96000", "-p", "64", "-n", "2"});
  CHECK(good.state == State::Ok);
  CHECK(good.what == "jackd runs at 96000 Hz with 64 frames a period");
  CHECK(server("jackd", {"/usr/bin/jackd", "-dalsa", "-dhw:USB", "-r48000", "-p128"}).what ==
        "jackd runs at 48000 Hz with 128 frames a period");
  CHECK(server("jackd", {"jackd", "-r", "-d", "dummy", "--period=64"}).state == State::Warn);
  const auto slow = server("jackd", {"jackd", "-d", "alsa"});
  CHECK(slow.state == State::Warn);
  CHECK(slow.what == "jackd runs at 48000 Hz with 1024 frames a period: 21.3 ms each way");
  CHECK(slow.command == "jack_bufsize 64");
  CHECK(server("jackdbus", {"jackdbus", "auto"}).state == State::Unknown);
  CHECK(server("pulseaudio", {"pulseaudio"}).state == State::Warn);
  CHECK(server("pipewire", {"pipewire"}).state == State::Unknown);
  const auto usual = server("pipewire", {"pipewire"}, quantum(1024, 0));
  CHECK(usual.state == State::Warn);
  CHECK(usual.what == "PipeWire runs by default at 1024 frames at 48000 Hz: 21.3 ms each way");
  CHECK(server("pipewire", {"pipewire"}, quantum(1024, 64)).what ==
        "PipeWire is held at 64 frames at 48000 Hz");
  CHECK(server("pipewire", {"pipewire"}, quantum(128, 0)).state == State::Ok);
}

TEST_CASE("doctor: cards, and how they hang on USB", "[doctor]") {
  SystemFacts facts;
  CHECK(judge_cards(facts).state == State::Unknown);
  facts.cards = "--- no soundcards ---\n";
  CHECK(judge_cards(facts).state == State::Warn);
  facts.cards =
      " 0 [PCH            ]: HDA-Intel - HDA Intel PCH\n                      HDA Intel PCH at 0xa1228000 "
      "irq 137\n"
      " 1 [USB            ]: USB-Audio - Scarlett 2i2 USB\n                      Focusrite Scarlett 2i2 "
      "USB\n";
  CHECK(judge_cards(facts).what == "HDA Intel PCH, Scarlett 2i2 USB");
  facts.usb = {{"1-1", "USB2.0 Hub", "auto", false, true},
               {"1-1.2", "Scarlett 2i2 USB", "on", true, false},
               {"1-2", "Keyboard", "on", false, false}};
  REQUIRE(judge_usb(facts).size() == 1);
  CHECK(judge_usb(facts)[0].state == State::Ok);
  facts.usb.push_back({"1-1.4", "Webcam", "on", false, false});
  CHECK(judge_usb(facts)[0].what == "'Scarlett 2i2 USB' shares a hub with 'Webcam'");
  facts.usb[1].power = "auto";
  CHECK(judge_usb(facts)[0].command == "echo on | sudo tee /sys/bus/usb/devices/1-1.2/power/control");
  facts.usb.erase(facts.usb.begin() + 1);
  CHECK(judge_usb(facts)[0].what == "no sound card hangs on USB");
}

#if defined(__linux__)
TEST_CASE("doctor: reads a system from its files", "[doctor]") {
  const test::TemporaryFolder root;
  root.write("proc/version", kDebianRt);
  root.write("proc/self/status", "Name:\ttactus\nGroups:\t29 1000 \nNStgid:\t7\n");
  root.write("proc/self/limits", "Max realtime priority     95                   95\n");
  root.write("proc/42/comm", "jackd\n");
  root.write("proc/42/cmdline", std::string{"jackd\0-d\0dummy\0-p\0"
                                            "64\0",
                                            20});
  root.write("etc/group", "audio:x:29:me\n");
  root.write("sys/kernel/realtime", "1\n");
  root.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  root.write("sys/devices/system/cpu/cpu0/cpuidle/state0/latency", "2\n");
  root.write("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "900\n");
  root.write("sys/devices/system/cpu/cpu0/cpuidle/state1/disable", "1\n");
  root.write("sys/bus/usb/devices/1-3/product", "Scarlett\n");
  root.write("sys/bus/usb/devices/1-3/power/control", "auto\n");
  root.write("sys/bus/usb/devices/1-3/1-3:1.0/bInterfaceClass", "01\n");
  const auto facts = read_system(root.path());
  CHECK(facts.user_groups == "\t29 1000 ");
  CHECK(facts.governors == std::vector<std::string>{"performance"});
  CHECK(facts.idle_latencies_us == std::vector{2});
  REQUIRE(facts.processes.size() == 1);
  CHECK(facts.processes[0].arguments == std::vector<std::string>{"jackd", "-d", "dummy", "-p", "64"});
  REQUIRE(facts.usb.size() == 1);
  CHECK(facts.usb[0].audio);
  CHECK(facts.usb[0].power == "auto");
  CHECK(judge_kernel(facts).state == State::Ok);
  const auto all = judge_system(facts, kGranted, kGranted);
  CHECK(std::count_if(all.begin(), all.end(),
                      [](const Finding& finding) { return finding.name == "JACK"; }) == 1);
}
#endif

TEST_CASE("doctor: of a system that it cannot read it says so", "[doctor]") {
  const auto findings = judge_system({}, kRefused, kGranted);
  REQUIRE(findings.size() == 3);
  CHECK(findings[0].state == State::Warn);
  CHECK(findings[1].state == State::Ok);
  CHECK(findings[2].what == "processors, kernel, sound servers and USB can only be looked at on Linux");
}

#if defined(TACTUS_PROGRAM) && defined(__unix__)
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
#endif
