#pragma once

#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// [any] The device with this id, or the default one where it is empty. Errors: UnknownName, listing what
/// there is.
Result<Device> device_with_id(const std::vector<Device>& devices, const std::string& id);

/// [any] The device that a person means by `text`: its id, or a part of its id or name, in any case; nothing
/// means the default. Errors: UnknownName, listing what there is; BadArgument, listing those that it may
/// mean.
Result<Device> find_device(const std::vector<Device>& devices, const std::string& text);

/// What a request comes to. Where one direction has no channels, both are the device of the other.
struct DeviceChoice {
  Device input, output;
  StreamGranted granted;  ///< without what only the driver reports
};

/// [any] The devices that `request` means, at the rate it asks for or else at the default one of the outputs.
/// Errors: those of `device_with_id`; BadArgument and OutOfRange for a rate, a block, channels or channel
/// maps that they do not have, for no channel at all, and for devices of two APIs.
Result<DeviceChoice> choose(const std::vector<Device>& devices, const StreamRequest& request);

/// [any] Adds " #2" to the id of the second device of the same id, and so on.
void number_same_ids(std::vector<Device>& devices);

/// [any] Channels that a library must open to reach those of a map.
int channels_to_open(int channels, const std::vector<int>& map);

}  // namespace tactus
