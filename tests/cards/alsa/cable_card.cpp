#include "tests/cards/alsa/cable_card.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/support/skip.h"
#include "tests/support/wait_until.h"

namespace tactus::test {
namespace {

namespace fs = std::filesystem;

void run_card(const std::string& what, int number) {
  const auto command = fmt::format("{}/scripts/vm/card {} {}", TACTUS_SOURCE_DIR, what, number);
  CAPTURE(command);
  REQUIRE(std::system(command.c_str()) == 0);
}

void need_virtual_machine() {
  if (std::getenv("TACTUS_VM") == nullptr)
    skip("real ALSA cards need the virtual machine: scripts/test_cards");
}

const fs::path kKeyboards{"/sys/bus/platform/drivers/snd_virmidi"};

/// The file that a keyboard's bytes are written to; empty: it is not plugged in.
fs::path keyboard_file() {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator("/dev/snd", ignored))
    if (entry.path().filename().string().starts_with("midiC")) return entry.path();
  return {};
}

/// [any] ALSA has this side of the card open.
bool is_open(const CableCard& card, const std::string& pcm) {
  std::string first;
  std::getline(std::ifstream{fmt::format("/proc/asound/{}/{}/sub0/status", card.id(), pcm)}, first);
  return !first.empty() && first != "closed";
}

}  // namespace

OtherProgram::OtherProgram(const CableCard& card, const std::string& program, int device,
                           const std::string& file)
    : process_(std::make_unique<ChildProcess>(
          std::vector<std::string>{program, "-q", "-D", fmt::format("hw:{},{}", card.id(), device), "-t",
                                   "raw", "-f", "S16_LE", "-c", "2", "-r", "48000", file},
          ChildProcess::Stdout::Logged)) {
  const auto pcm = fmt::format("pcm{}{}", device, program == "aplay" ? 'p' : 'c');
  const bool opened = wait_until([&] { return is_open(card, pcm) || !process_->running(); });
  if (process_->wait(std::chrono::milliseconds{0}) == ChildProcess::kCannotRun)
    skip("aplay and arecord are not installed (Debian: apt-get install alsa-utils)");
  INFO(process_->log());
  REQUIRE(opened);
  REQUIRE(process_->running());
}

OtherProgram OtherProgram::plays(const CableCard& card, int device, const std::string& file) {
  return {card, "aplay", device, file};
}
OtherProgram OtherProgram::records(const CableCard& card, int device, const std::string& file) {
  return {card, "arecord", device, file};
}

VirtualKeyboard::VirtualKeyboard() {
  need_virtual_machine();
  plug();
}
void VirtualKeyboard::plug() const {
  if (!fs::exists(kKeyboards / "snd_virmidi.0")) std::ofstream{kKeyboards / "bind"} << "snd_virmidi.0\n";
  REQUIRE(wait_until([] { return !keyboard_file().empty(); }));
}
void VirtualKeyboard::pull() const {
  std::ofstream{kKeyboards / "unbind"} << "snd_virmidi.0\n";
  REQUIRE(wait_until([] { return keyboard_file().empty(); }));
}
void VirtualKeyboard::play(const std::array<std::uint8_t, 3>& bytes) const {
  std::ofstream file{keyboard_file(), std::ios::binary};
  file.write(reinterpret_cast<const char*>(bytes.data()), 3);
  REQUIRE(file.flush());
}

CableCard::CableCard(int number) : number_(number) {
  need_virtual_machine();
  plug();
}

CableCard::~CableCard() {
  const auto command = fmt::format("{}/scripts/vm/card plug {}", TACTUS_SOURCE_DIR, number_);
  static_cast<void>(std::system(command.c_str()));
}

void CableCard::plug() const { run_card("plug", number_); }
void CableCard::pull() const { run_card("pull", number_); }

std::optional<Device> CableCard::side(Backend& backend, int device) const {
  const auto devices = backend.devices();
  REQUIRE(devices);
  for (const auto& one : *devices)
    if (is_side(one, device)) return one;
  return std::nullopt;
}

// RtAudio calls it "hw:Loopback,0", PortAudio "Loopback: PCM (hw:1,0)".
bool CableCard::is_side(const Device& listed, int device) const {
  const auto number = fmt::format(",{}", device);
  const auto& name = listed.library_name;
  return (listed.hardware + ",").starts_with(hardware() + ",") &&
         (name.ends_with(number) || name.ends_with(number + ")"));
}

StreamRequest CableCard::request(Backend& backend, double rate, int block, int channels) const {
  const auto output = output_of(backend), input = input_of(backend);
  REQUIRE(output);
  REQUIRE(input);
  StreamRequest request;
  request.device = output->id;
  request.input_device = input->id;
  request.sample_rate = Hertz{rate};
  request.block_frames = block;
  request.in_channels = request.out_channels = channels;
  return request;
}

std::vector<Way> alsa_ways() {
  std::vector<Way> ways;
  for (const auto& backend : sound_backends())
    if (backend.name != "jack") ways.push_back({backend.name + ":alsa", backend.make, true});
  return ways;
}

}  // namespace tactus::test
