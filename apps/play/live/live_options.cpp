#include "apps/play/live/live_options.h"

#include <fmt/format.h>

#include "apps/cli/backends.h"

namespace tactus::app {

void add_live_options(CLI::App& command, LiveOptions& options) {
  auto* group = command.add_option_group("on a sound card");
  group->add_option("--rig", options.rig, "rig file: device, channels, actuators, sensors, measured delay");
  group->add_option("--backend", options.backend,
                    fmt::format("{}; see tactus devices", fmt::join(card_backends(), ", ")));
  group->add_option("--device", options.device, "id of a device, or a part of its name")
      ->check([](const std::string& text) { return text.empty() ? "it is empty" : std::string{}; });
  group->add_option("--input-device", options.input_device, "where the sensors are on another device");
  group->add_option("--inputs", options.in, "channels of the device for the inputs, such as --inputs 2,5")
      ->delimiter(',')
      ->check(CLI::Range(1, 1024));
  group->add_option("--outputs", options.out, "channels of the device for the outputs")
      ->delimiter(',')
      ->check(CLI::Range(1, 1024));
  group->add_option("--periods", options.periods, "blocks in the driver's buffer")->check(CLI::Range(1, 64));
  group->add_option("--pad-delay", options.pad_delay,
                    "extend the system delay to this in every session, such as \"20 ms\"");
  group->add_option("--record", options.record, "record sensors, drives and controls to this WAV file");
  group->add_option("--save-rig", options.save_rig,
                    "ask what is connected where, and write it to this rig file");
  group->add_flag(
      "--learn{*}", options.learn,
      "set the sensitivity of the first sensor, or with --learn=NAME of another, from five soft hits");
  group
      ->add_option("--midi", options.midi,
                   "way to MIDI inputs: alsa, jack, core, winmm; default: the system's")
      ->check(CLI::IsMember({"alsa", "jack", "core", "winmm"}));
  group->add_flag("--listen", options.listen, "play a scene's simulated world to the sound card");
  group->add_flag("--arm", options.arm, "drives move at once, instead of when 'a' is pressed");
  group->add_flag("--yes", options.yes, "answer every question with its default");
  group->add_flag("--force", options.force, "overwrite files");
}

}  // namespace tactus::app
