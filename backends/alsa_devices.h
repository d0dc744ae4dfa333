#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/core/error.h"

namespace tactus {

/// A device of one of this computer's sound cards.
struct AlsaDevice {
  int card = 0, device = 0;
  std::string name;      ///< of the card; two may have the same
  std::string hardware;  ///< see `alsa_hardware`

  bool operator==(const AlsaDevice&) const = default;
};

/// [control] In the order in which ALSA lists them; empty where there is no ALSA. `root`: where proc and sys
/// are.
std::vector<AlsaDevice> alsa_devices(const std::filesystem::path& root = "/");

/// [control] Where card number `card` is connected, with its serial number if it has one: "1-2:1.0 serial 42"
/// for a USB interface, "0000:00:1f.3" on the PCI bus. Card numbers depend on the order in which cards were
/// connected; this does not. Empty: unknown.
std::string alsa_hardware(int card, const std::filesystem::path& root = "/");

/// [control] The same of the card that a text names as ALSA does, by number or by id: "alsa_pcm:hw:1:out1",
/// "hw:USB,0". Empty: it names none, or unknown.
std::string alsa_hardware_named(const std::string& text, const std::filesystem::path& root = "/");

/// [control] The program that has this device open for all inputs, or for all outputs, so that no other can
/// open it: "aplay (process 267)". Empty: it is free, or there is no such device.
std::string alsa_user(int card, int device, bool inputs, const std::filesystem::path& root = "/");

/// [control] The same error, with the devices that are in use in its remedy if it says that a device is not
/// there and its id names ALSA: libraries do not list what is in use.
Error with_alsa_users(Error error, const std::filesystem::path& root = "/");

/// [control] Libraries open devices by a number in a list that may be old. Errors: Device, if cards came or
/// went since `before` was read.
Status same_cards(const std::vector<AlsaDevice>& before);

}  // namespace tactus
