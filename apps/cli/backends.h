#pragma once
// Thread: [control]

#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/midi.h"

namespace tactus::app {

/// Names of the backends for sound cards that this program was built with, the best first.
std::vector<std::string> card_backends();
/// Why there is none, where there is none, and what to do.
const char* no_card_backend();
/// One of them, or "loop", the simulated cards. Errors: UnknownName, with what there is and how to have it.
Result<std::unique_ptr<Backend>> make_card_backend(const std::string& name);

/// All that a backend can open now, or why that is unknown.
struct BackendDevices {
  std::string backend;
  Result<std::vector<Device>> devices;
};
/// Asks `backend`, or all of those for sound cards if it is empty.
std::vector<BackendDevices> list_devices(const std::string& backend = {});

/// Where a stream is to be opened.
struct ChosenDevices {
  std::unique_ptr<Backend> backend;
  Device output, input;
};
/// `output` and `input`: ids, or parts of them; an empty `input` means the output's device, an empty `output`
/// the default. Several backends often reach the same card: without a `backend`, and where no id names it,
/// they are asked in turn, and the first that has such a device counts. Errors: of find_device; Device if no
/// backend has any.
Result<ChosenDevices> choose_devices(const std::string& backend, const std::string& output,
                                     const std::string& input);

/// nullptr: this program was built without MIDI. `api`: see RtMidiSettings.
std::unique_ptr<MidiInputs> make_midi_inputs(const std::string& api);

}  // namespace tactus::app
