#pragma once

#include <string>
#include <utility>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// [any] The device with exactly this id, or the default one where it is empty. An id may name the hardware
/// ("ID@HARDWARE") although no other device has the name; `hardware`: what decides where several have it.
/// Errors: UnknownName, listing what there is, or naming the backend that has a JACK client which RtAudio and
/// PortAudio cannot open (jack_names.h).
Result<Device> device_with_id(const std::vector<Device>& devices, const std::string& id,
                              const std::string& hardware = {});

/// [any] The device that a person means by `text`: its id, or a part of its id or name, in any case; nothing
/// means the default. For what a person types; ids of files are compared exactly. Errors: UnknownName,
/// listing what there is; BadArgument, listing those that it may mean.
Result<Device> find_device(const std::vector<Device>& devices, const std::string& text);

/// The rate of a joystick, wheel or gamepad where none is requested. It is read and written every
/// millisecond, whatever the rate is.
inline constexpr Hertz kHapticRate{8000};

/// What a request comes to. Where one direction has no channels, both are the device of the other.
struct DeviceChoice {
  Device input, output;
  StreamGranted granted;  ///< without what only the driver reports
};

/// [control] The devices that `request` means, at the rate it asks for or else at the default one of the
/// outputs. Of a device that returns, that on the same hardware where several have its name. Errors: those of
/// `device_with_id`; BadArgument and OutOfRange for a rate, a block, channels or channel maps that they do
/// not have, for no channel at all, and for devices of two APIs; Device for an ALSA device that another
/// program has open.
Result<DeviceChoice> choose(const std::vector<Device>& devices, const StreamRequest& request);

/// [any] Devices of the same id get their hardware added to it: "ID@HARDWARE". Where that is unknown, or the
/// same, they are numbered in their order, the second one as "ID #2", and ambiguous.
void distinguish_same_ids(std::vector<Device>& devices);

/// [any] In what a device that returned differs from what it was, one sentence each for the user; empty: it
/// is the same one, as far as the library can tell.
std::vector<std::string> differences(const StreamGranted& before, const StreamGranted& now);
/// [any] The same for a stream that is closed and opened again at once: unknown hardware is no difference,
/// but a device that left its server and came back in between is one. `same_settings`: sample rate, block and
/// periods were requested as before.
std::vector<std::string> differences_between_openings(const StreamGranted& before, const StreamGranted& now,
                                                      bool same_settings);

/// [any] For an error: these numbers of channels of two devices cannot be had together.
std::string two_devices_text(const Device& input, const Device& output, std::pair<int, int> channels,
                             double rate);

/// [any] Channels that a library must open to reach those of a map.
int channels_to_open(int channels, const std::vector<int>& map);

}  // namespace tactus
