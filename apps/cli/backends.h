#pragma once
// Thread: [control]

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/midi.h"
#include "engine/rig/rig.h"

namespace tactus::app {

/// The backend of this name, "loop" for the simulated cards; without one all for sound cards. Errors:
/// UnknownName, listing what there is; Device if this program was built without any.
Result<std::vector<BackendType>> backends_called(const std::string& name);

/// "jack" of "jack:system"; the whole where it names no backend.
std::string backend_of(const std::string& device);
/// Its devices are joysticks, wheels and gamepads, of which the outputs are motors and forces.
bool is_haptic(const std::string& backend);
/// Its outputs usually have coupling capacitors, as those of sound cards.
bool has_capacitors(const std::string& backend);

/// Options that say which card is played on.
struct DeviceOptions {
  std::string rig, backend, device, input_device;
  std::optional<int> periods;
};
/// --rig, --backend, --device and --input-device.
void add_device_options(CLI::App& command, DeviceOptions& options, const char* rig_help);

/// Where a stream is to be opened.
struct ChosenDevices {
  std::unique_ptr<Backend> backend;
  Device output, input;
  std::string second;  ///< id; see StreamRequest
};
/// How devices are named: by a person, to whom a part of an id or name suffices, or in a file, exactly.
enum class DeviceNames { Partial, Exact };
/// `output` and `input`: names of devices; an empty `input` means the output's device, an empty `output`
/// the default. Several backends often reach the same card: without a `backend`, and where no id names it,
/// they are asked in turn, and the first that has such a device counts. Errors: of find_device; of
/// backends_called; Device if no backend has any.
Result<ChosenDevices> choose_devices(const std::string& backend, const std::string& output,
                                     const std::string& input, DeviceNames names = DeviceNames::Partial);
/// Can the devices of a rig be played together, as far as their ids say? Nothing is opened. Errors:
/// BadArgument for a second device that is none, at the place of [device].
Status check_devices(const Rig::Device& device);
/// How the delay of a device becomes known, which is in no rig: an error's remedy. `rig_file` may be empty.
std::string delay_remedy(const std::string& device, const std::string& rig_file);
/// The devices of the rig, which passed `check_devices`, by their exact ids, or without one those of the
/// command line: what a part of a name means is printed. Throws a CommandError.
ChosenDevices choose_devices(const DeviceOptions& options, const Rig::Device& rig);

/// A request for them. `rate`, `block` and `periods`, as options give them, go before the setting of a rig,
/// and that before the device's own. Throws a CommandError.
StreamRequest request_for(const ChosenDevices& devices, const Rig::Device& rig, const std::string& rate,
                          std::optional<int> block, std::optional<int> periods);

/// `api`: "jack": those of the stream over `backend`; others: see make_rtmidi. nullptr: there are none, since
/// the program was built without MIDI, or the stream is not one over JACK.
std::shared_ptr<MidiInputs> make_midi_inputs(const std::string& api, Backend& backend);
/// There may be MIDI inputs by this API.
bool has_midi(const std::string& api);

}  // namespace tactus::app
