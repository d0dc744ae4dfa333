#include "backends/alsa_devices.h"

#include <catch2/catch.hpp>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

/// Two equal USB cards, one of them with a serial number, and one on the PCI bus.
struct Cards {
  Cards() {
    folder.write("proc/asound/cards",
                 " 0 [PCH            ]: HDA-Intel - HDA Intel PCH\n"
                 "                      HDA Intel PCH at 0xf7d10000 irq 32\n"
                 " 1 [U192k          ]: USB-Audio - UMC204HD 192k\n"
                 "                      BEHRINGER UMC204HD 192k at usb-0000:00:14.0-2, high speed\n"
                 " 2 [U192k_1        ]: USB-Audio - UMC204HD 192k\n"
                 "                      BEHRINGER UMC204HD 192k at usb-0000:00:14.0-3, high speed\n");
    folder.write("proc/asound/pcm",
                 "00-00: ALC269 Analog : ALC269 Analog : playback 1 : capture 1\n"
                 "00-03: HDMI 0 : HDMI 0 : playback 1\n"
                 "01-00: USB Audio : USB Audio : playback 1 : capture 1\n"
                 "02-00: USB Audio : USB Audio : playback 1 : capture 1\n");
    connect(0, "sys/devices/pci0000:00/0000:00:1f.3");
    connect(1, "sys/devices/usb1/1-2/1-2:1.0");
    connect(2, "sys/devices/usb1/1-3/1-3:1.0");
    folder.write("sys/devices/usb1/1-3/serial", "42\n");
  }
  void connect(int card, const std::string& device) const {
    namespace fs = std::filesystem;
    const auto at = folder.path() / ("sys/class/sound/card" + std::to_string(card));
    fs::create_directories(folder.path() / device);
    fs::create_directories(at);
    fs::create_directory_symlink(folder.path() / device, at / "device");
  }
  test::TemporaryFolder folder;
};

}  // namespace

TEST_CASE("alsa devices: equal cards differ in where they are connected", "[backends]") {
  const Cards cards;
  const auto devices = alsa_devices(cards.folder.path());
  REQUIRE(devices.size() == 4);
  CHECK(devices[0] == AlsaDevice{0, 0, "HDA Intel PCH", "0000:00:1f.3"});
  CHECK(devices[1] == AlsaDevice{0, 3, "HDA Intel PCH", "0000:00:1f.3"});
  CHECK(devices[2] == AlsaDevice{1, 0, "UMC204HD 192k", "1-2:1.0"});
  CHECK(devices[3] == AlsaDevice{2, 0, "UMC204HD 192k", "1-3:1.0 serial 42"});
}

TEST_CASE("alsa devices: without ALSA there are none, and a card that is gone has no hardware",
          "[backends]") {
  const test::TemporaryFolder empty;
  CHECK(alsa_devices(empty.path()).empty());
  CHECK(alsa_hardware(0, empty.path()).empty());
  CHECK(alsa_hardware(7, Cards{}.folder.path()).empty());
}

TEST_CASE("alsa devices: the card that a text names is found by number and by id", "[backends]") {
  const Cards cards;
  std::filesystem::create_directory_symlink("card2", cards.folder.path() / "proc/asound/U192k_1");
  const auto named = [&](const std::string& text) { return alsa_hardware_named(text, cards.folder.path()); };
  CHECK(named("alsa_pcm:hw:1:out1") == "1-2:1.0");
  CHECK(named("alsa_pcm:hw:U192k_1,0:in1") == "1-3:1.0 serial 42");
  CHECK(named("hw:0") == "0000:00:1f.3");
  CHECK(named("alsa_pcm:plughw:1,0:out1") == "1-2:1.0");
  for (const auto* text :
       {"usb:left", "alsa_pcm:hw:9:out1", "hw:", "hw:nowhere", "hw:99999999999", "alsa_pcm:my_hw:1:out1",
        "alsa_pcm:default:out1", "alsa_pcm:front:1:out1", "alsa_pcm:dmix:1,0:out1"})
    CHECK(named(text).empty());
}

TEST_CASE("alsa devices: a device is in use when all of its substreams are, and by whom", "[backends]") {
  const Cards cards;
  const auto& folder = cards.folder;
  const auto user = [&](bool inputs) { return alsa_user(1, 0, inputs, folder.path()); };
  const std::string open = "state: RUNNING\nowner_pid   : 268\ntrigger_time: 1.0\n";
  folder.write("proc/268/status", "Name:\taplay\nUmask:\t0022\nTgid:\t267\nPid:\t268\n");
  CHECK(user(false).empty());
  folder.write("proc/asound/card1/pcm0p/info", "card: 1\n");
  folder.write("proc/asound/card1/pcm0p/sub0/status", open);
  folder.write("proc/asound/card1/pcm0c/sub0/status", "closed\n");
  CHECK(user(false) == "aplay (process 267)");
  CHECK(user(true).empty());
  folder.write("proc/asound/card1/pcm0p/sub1/status", "closed\n");
  CHECK(user(false).empty());
}

TEST_CASE("alsa devices: where a device is missing, those that are in use are named", "[backends]") {
  const Cards cards;
  const Error missing{Errc::UnknownName, "", "there is no device 'rtaudio:alsa:hw:x,0'", "there is 'y'"};
  CHECK(with_alsa_users(missing, cards.folder.path()).remedy == "there is 'y'");
  cards.folder.write("proc/asound/card1/pcm0p/sub0/status", "state: OPEN\nowner_pid   : 9\n");
  CHECK(with_alsa_users(missing, cards.folder.path()).remedy ==
        "there is 'y'; the outputs of 'hw:UMC204HD 192k,0' are in use by another program");
}
