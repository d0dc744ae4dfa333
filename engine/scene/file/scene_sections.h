#pragma once

// Thread: [control]

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/graph/file/field.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

// The readers of the sections of a scene: scene_fields.h has their keys.

std::vector<Gesture> read_gestures(const Value::Table& scene, ErrorList& mistakes);
Converters read_converters(const Value::Table& scene, ErrorList& mistakes);

/// `folder` is the scene's, `root` the one with the profiles.
///   woofer = { profile = "woofer", volts_per_full_scale = "10 V", ceiling = 0.8 }
/// A ceiling may be lower than it is anyway, never higher.
void read_drives(const Value::Table& scene, const std::filesystem::path& folder,
                 const std::filesystem::path& root, SceneSpec& spec, ErrorList& mistakes);

///   arm = { force = "plant.motor", position = "plant.arm", active_up_to = "20 mJ" }
std::vector<Port> read_ports(const Value::Table& scene, ErrorList& mistakes);

std::vector<Expectation> read_expectations(const Value::Table& scene, Seconds duration, ErrorList& mistakes);

///   rebound = { measure = "speed", of = "plant.stick", from = "2 ms", to = "3 ms", exact = "1 m/s" }
std::vector<Accuracy> read_accuracy(const Value::Table& scene, Seconds duration, ErrorList& mistakes);

///   kind = "roll", fewest = 12
///   kind = "tone", pitch = "110 Hz", begin = "0.1 s"
///   kind = "tone", pitch = "wanted.pitch": as many notes as that signal has
std::optional<Playability> read_playability(const Value::Table& scene, Seconds duration,
                                            const std::vector<Role>& roles, ErrorList& mistakes);

std::optional<Comparison> read_comparison(const Value::Table& scene, ErrorList& mistakes);

}  // namespace tactus
