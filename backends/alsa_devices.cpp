#include "backends/alsa_devices.h"

#include <charconv>
#include <cstdio>
#include <fstream>
#include <map>
#include <regex>
#include <system_error>

namespace tactus {
namespace {

namespace fs = std::filesystem;

/// " 0 [Loopback       ]: Loopback - Loopback" and a second line; the name is what follows the driver's.
std::map<int, std::string> card_names(const fs::path& root) {
  std::map<int, std::string> names;
  std::ifstream file{root / "proc/asound/cards"};
  for (std::string line; std::getline(file, line);) {
    const auto driver = line.find("]: "), name = line.find(" - ", driver);
    const auto number = line.find_first_of("0123456789");
    if (driver == std::string::npos || name == std::string::npos || number > driver) continue;
    names[std::stoi(line.substr(number, driver - number))] = line.substr(name + 3);
  }
  return names;
}

/// A line of the file that begins with `key`, without that.
std::string value_after(const fs::path& path, const std::string& key) {
  std::ifstream file{path};
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const auto value = line.find_first_not_of(" :\t", key.size());
    return value == std::string::npos ? "" : line.substr(value);
  }
  return {};
}

/// Of one substream: "closed", or its state and the thread that opened it. Empty: it is free.
std::string substream_user(const fs::path& status, const fs::path& root) {
  const auto thread = value_after(status, "owner_pid");
  if (thread.empty()) return {};
  const auto state = root / "proc" / thread / "status";
  const auto name = value_after(state, "Name:"), process = value_after(state, "Tgid:");
  return name.empty() ? "another program" : name + " (process " + process + ")";
}

}  // namespace

std::string alsa_hardware(int card, const fs::path& root) {
  std::error_code missing;
  const auto device =
      fs::canonical(root / ("sys/class/sound/card" + std::to_string(card)) / "device", missing);
  if (missing) return {};
  auto text = device.filename().string();
  std::string serial;
  if (std::getline(std::ifstream{device.parent_path() / "serial"}, serial) && !serial.empty())
    text += " serial " + serial;
  return text;
}

std::string alsa_hardware_named(const std::string& text, const fs::path& root) {
  static const std::regex kNamed{"(?:^|:)(?:plug)?hw:([^,: ]*)"};
  std::smatch found;
  if (!std::regex_search(text, found, kNamed)) return {};
  auto card = found[1].str();
  if (card.empty()) return {};
  if (card.find_first_not_of("0123456789") != std::string::npos) {
    std::error_code missing;
    card = fs::read_symlink(root / "proc/asound" / card, missing).filename().string();  // "card1"
    if (missing || !card.starts_with("card")) return {};
    card.erase(0, 4);
  }
  int number = 0;
  const auto read = std::from_chars(card.data(), card.data() + card.size(), number);
  return read.ec == std::errc{} ? alsa_hardware(number, root) : std::string{};
}

std::vector<AlsaDevice> alsa_devices(const fs::path& root) {
  const auto names = card_names(root);
  std::vector<AlsaDevice> devices;
  std::ifstream file{root /
                     "proc/asound/pcm"};  // "00-01: Loopback PCM : Loopback PCM : playback 8 : capture 8"
  for (std::string line; std::getline(file, line);) {
    AlsaDevice found;
    if (std::sscanf(line.c_str(), "%d-%d:", &found.card, &found.device) != 2) continue;
    const auto name = names.find(found.card);
    if (name == names.end()) continue;
    found.name = name->second;
    found.hardware = alsa_hardware(found.card, root);
    devices.push_back(std::move(found));
  }
  return devices;
}

std::string alsa_user(int card, int device, bool inputs, const fs::path& root) {
  const auto pcm = root / "proc/asound" / ("card" + std::to_string(card)) /
                   ("pcm" + std::to_string(device) + (inputs ? "c" : "p"));
  std::string user;
  for (int number = 0;; ++number) {
    const auto status = pcm / ("sub" + std::to_string(number)) / "status";
    std::error_code missing;  // the card may go while it is looked at
    if (!fs::exists(status, missing)) return user;
    user = substream_user(status, root);
    if (user.empty()) return {};
  }
}

Error with_alsa_users(Error error, const fs::path& root) {
  if (error.code != Errc::UnknownName || error.what.find(":alsa:") == std::string::npos) return error;
  for (const auto& pcm : alsa_devices(root))
    for (const bool inputs : {true, false})
      if (const auto user = alsa_user(pcm.card, pcm.device, inputs, root); !user.empty())
        error.remedy += "; the " + std::string{inputs ? "inputs" : "outputs"} + " of 'hw:" + pcm.name + "," +
                        std::to_string(pcm.device) + "' are in use by " + user;
  return error;
}

Status same_cards(const std::vector<AlsaDevice>& before) {
  if (alsa_devices() == before) return {};
  return fail(Errc::Device, "", "a sound card was connected or disconnected while the device was opened",
              "try again");
}

}  // namespace tactus
