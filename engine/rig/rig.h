#pragma once

// Thread: [control]

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/block_io.h"
#include "engine/core/error.h"
#include "engine/core/units.h"
#include "engine/graph/file/field.h"
#include "engine/rig/profile.h"

namespace tactus {

/// The channels that a port is connected to, one for each lane; none: the port is left out. Channels count
/// from 1, those of the second device from kSecondDevice + 1.
struct RigPort {
  std::string name;
  Source at;
  std::vector<int> channels;
  std::string about;

  bool on_second_device() const { return !channels.empty() && channels.front() > kSecondDevice; }
  bool uses(int channel) const { return std::ranges::find(channels, channel) != channels.end(); }
};

/// A sensor:  value = sample * volts_per_full_scale / sensitivity
struct RigInput : RigPort {
  std::optional<double> volts;  ///< at the connector, for a sample of 1
  /// Volts for one SI unit of the port; for a port in full scale, the volts that count as its full scale.
  /// A sensor that is wired with inverted polarity has a negative one.
  std::optional<QuantityValue> sensitivity;
  Source sensitivity_at;

  double scale() const { return volts && sensitivity ? *volts / sensitivity->si : 1.0; }
};

/// An output of an instrument, or an actuator that other instruments use.
struct RigOutput : RigPort {
  DriveEntry drive;
  /// Cut-off frequency of the one-pole high-pass that the card's AC coupling is; nothing: not known.
  std::optional<Hertz> highpass;

  bool has_actuator() const { return !drive.profile.empty(); }
};

/// What moves a control.
struct RigMidi {
  enum class Kind { Controller, Note, PitchBend };
  std::string control;  ///< of the instrument
  Source at;
  std::string device;  ///< a part of the port's name; empty: any
  int channel = 0;     ///< 1 to 16; 0: any
  Kind kind = Kind::Controller;
  int number = 0;     ///< of the controller or note
  bool fine = false;  ///< controllers `number` (0 to 31) and `number` + 32 together have 14 bits
  bool gate = false;  ///< a note moves it to its highest value and back to its lowest when it ends
};

/// The OSC address of another program that moves a control: from 0 to 1 over its range.
struct RigOsc {
  std::string control;
  Source at;
  std::string address;  ///< "/1/fader3"
};

enum class HidPart { Axis, Button };
/// "axis", "button"
inline const char* name_of(HidPart part) { return part == HidPart::Button ? "button" : "axis"; }

/// An axis or a button of a joystick, gamepad or pedal that moves a control over its range.
struct RigHid {
  std::string control;
  Source at;
  std::string device;  ///< a part of its name; empty: any
  HidPart part = HidPart::Axis;
  int number = 0;  ///< from 0 on
  bool invert = false;
};

/// What an event or a control of the instrument sends.
struct RigMidiOut {
  enum class Kind { Note, Controller, Clock };
  std::string name;  ///< of the event (Note) or the control
  Source at;
  int channel = 1;  ///< 1 to 16
  Kind kind = Kind::Note;
  int number = 0;  ///< of the note or controller
  /// Levels of an event with velocity 1 and 127, SI of its level.
  double softest = 0.01, loudest = 1.0;
  Seconds length{0.05};  ///< of a note
  int per_beat = 1;      ///< periods of the control, in Hz, that are a beat of the clock
};

/// A rig file: the hardware that an instrument plays on. docs/rigs.md explains it.
struct Rig {
  struct Device {
    Source at;
    std::string output, input;  ///< ids; no input: where the output is
    std::string second;         ///< id of a joystick, wheel or gamepad beside it; empty: there is none
    std::optional<Hertz> rate;
    std::optional<int> block, periods;
  };
  struct Control {
    std::string name;
    Source at;
    QuantityValue value;
  };
  Source file;
  std::string name, about;
  Device device;
  std::vector<RigInput> inputs;
  std::vector<RigOutput> outputs;
  std::vector<RigOutput> actuators;  ///< on channels that this instrument need not use
  std::vector<Control> controls;     ///< initial values
  std::vector<RigMidi> midi;
  std::vector<RigMidiOut> midi_out;
  std::vector<RigOsc> osc;
  std::vector<RigHid> hid;
  std::optional<Seconds> measured_delay;  ///< from the sensor's volts to the actuator's
  std::optional<Seconds> pad_delay;       ///< hold the whole at this
  bool incomplete = false;                ///< a section could not be read

  /// The actuator on a channel, or nullptr.
  const RigOutput* actuator_on(int channel) const;
  /// What [actuators] and [outputs] say of the limits on a channel.
  std::vector<LimitSource> limit_sources(int channel) const;
};

/// [any] All keys of a rig file.
const SectionType& rig_fields();

/// [control] All errors that a rig has by itself, in file order; `check_rig` finds what does not fit an
/// instrument.
Checked<Rig> load_rig(const std::filesystem::path& file, const ProfilePlaces& profiles);
Checked<Rig> parse_rig(std::string_view text, const std::string& file_name, const ProfilePlaces& profiles);

/// [any] The text of a rig file, which reads back the same. Comments of a former one are not in it.
std::string to_text(const Rig& rig);

/// [any] A string as TOML writes it, in quotes.
std::string in_quotes(std::string_view text);
/// [any] "channel 3", "channel 1 of the second device"
std::string channel_name(int channel);
/// [any] "V/N": the unit of a sensitivity that is no plain voltage.
std::string volts_per(const Dimension& sensitivity);
/// [any] "\"12.4 ms\"" or 0.6: as people write it where that reads back to the last bit, else all digits in
/// SI.
std::string exact_quantity(double si, const Dimension& dimension);
std::string exact_quantity(const QuantityValue& value);

}  // namespace tactus
