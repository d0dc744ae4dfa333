#include "engine/rig/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <utility>

#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/read_graph.h"

namespace tactus {
namespace {

constexpr int kMaxChannels = kSecondDevice;

class RigReader {
 public:
  RigReader(const std::filesystem::path& file, ProfilePlaces places) : places_(std::move(places)) {
    rig_.file = {std::make_shared<const std::string>(file.generic_string()), 0, 0};
    errors_ = ErrorList{rig_.file};
  }

  Checked<Rig> read(const Result<Value::Table>& table) {
    if (errors_.keep(table) != nullptr) {
      read_sections(*table);
      check_channels();
    }
    if (errors_.any()) return tl::unexpected(errors_.take());
    return std::move(rig_);
  }

 private:
  void read_sections(const Value::Table& table) {
    const Source start{rig_.file.file, 1, 1};
    check_format(table, rig_.file, errors_);
    FieldReader fields{table, rig_fields(), errors_, "the rig", start};
    const auto keys = rig_fields().keys();
    rig_.incomplete = std::any_of(table.begin(), table.end(), [&](const Field& field) {
      return std::find(keys.begin(), keys.end(), field.key) == keys.end();
    });
    rig_.name = fields.text("name");
    rig_.about = fields.text("about");
    rig_.device.at = fields.at("device", start);
    if (const auto* device = read_section(table, "device", errors_)) read_device(*device);
    for (const auto& entry : read_entries(table, "inputs", "{ channel = 1 }", errors_)) read_input(entry);
    for (const auto& entry : read_entries(table, "outputs", "{ channel = 1 }", errors_))
      rig_.outputs.push_back(read_output(entry, "output", "[outputs]"));
    for (const auto& entry :
         read_entries(table, "actuators",
                      "{ channel = 3, profile = \"woofer\", volts_per_full_scale = \"10 V\" }", errors_))
      read_actuator(entry);
    read_controls(table);
    for (const auto& entry : read_entries(table, "midi", "{ control = 7 }", errors_))
      if (!entry.broken) rig_.midi.push_back(read_midi(entry));
    for (const auto& entry : read_entries(table, "midi_out", "{ note = 38 }", errors_))
      if (!entry.broken) rig_.midi_out.push_back(read_midi_out(entry));
    for (const auto& entry : read_entries(table, "osc", "{ address = \"/1/fader3\" }", errors_))
      if (!entry.broken) rig_.osc.push_back(read_osc(entry));
    for (const auto& entry : read_entries(table, "hid", "{ axis = 0 }", errors_))
      if (!entry.broken) rig_.hid.push_back(read_hid(entry));
    read_delay(table);
  }

  void read_device(const Value::Table& table) {
    auto& device = rig_.device;
    FieldReader fields{table, *rig_fields()["device"].inside, errors_, "[device]", device.at};
    device.output = read_device_id("output", fields);
    device.input = read_device_id("input", fields);
    device.second = read_device_id("second", fields);
    if (const auto rate = fields.number("rate")) device.rate = Hertz{*rate};
    if (const auto block = fields.number("block")) device.block = static_cast<int>(*block);
    if (const auto periods = fields.number("periods")) device.periods = static_cast<int>(*periods);
  }

  /// An empty one would be the default card, whatever is connected to it.
  std::string read_device_id(const char* key, FieldReader& fields) {
    const auto id = fields.text(key);
    if (const auto* value = fields.value(key); value != nullptr && value->text() != nullptr && id.empty())
      errors_.add(Errc::Missing, value->at, fmt::format("'{}' of [device] is empty", key),
                  "give the id of a device as `tactus devices` lists it");
    return id;
  }

  void read_port(const EntrySpec& entry, FieldReader& fields, RigPort& port) {
    port.name = entry.name;
    port.at = entry.at;
    port.about = fields.text("about");
    const auto* channel = fields.value("channel");
    if (channel == nullptr || (channel->text() != nullptr && *channel->text() == "none")) return;
    for (const auto& lane : channel->list() != nullptr ? *channel->list() : Value::List{*channel})
      read_channel(lane, port);
    if (!fields.flag("second")) return;
    for (auto& number : port.channels) number += kSecondDevice;
    if (rig_.device.second.empty())
      errors_.add(Errc::Missing, fields.value("second")->at, "there is no second device",
                  "give its id under [device], as in second = \"sdl:Xbox Wireless Controller\"");
  }

  void read_channel(const Value& value, RigPort& port) {
    const auto* number = value.number();
    const bool whole = number != nullptr && std::floor(*number) == *number;
    if (whole && *number >= 1 && *number <= kMaxChannels)
      return port.channels.push_back(static_cast<int>(*number));
    rig_.incomplete = true;
    errors_.add(Errc::OutOfRange, value.at,
                whole ? "there is no channel " + short_number(*number)
                      : "a channel must be a whole number, not " + value.kind(),
                "channels are counted from 1; \"none\" leaves the port unconnected");
  }

  void read_input(const EntrySpec& entry) {
    FieldReader fields{entry, *rig_fields()["inputs"].inside, errors_, "input"};
    RigInput input;
    read_port(entry, fields, input);
    input.volts = fields.number("volts_per_full_scale");
    input.sensitivity = fields.any("sensitivity");
    input.sensitivity_at = fields.at("sensitivity", {});
    const double size = input.sensitivity ? std::abs(input.sensitivity->si) : 1;
    if (!(size >= 1e-12 && size <= 1e12)) {
      errors_.add(Errc::OutOfRange, input.sensitivity_at,
                  "'sensitivity' cannot be " + short_number(input.sensitivity->si),
                  "give the voltage for one unit, such as \"50 mV\" or \"2 V/m\"");
      input.sensitivity.reset();
    }
    rig_.inputs.push_back(std::move(input));
  }

  RigOutput read_output(const EntrySpec& entry, const char* what, const char* section) {
    FieldReader fields{entry, *rig_fields()["outputs"].inside, errors_, what};
    RigOutput output;
    read_port(entry, fields, output);
    output.drive = read_drive(entry, section, fields, places_, errors_);
    if (const auto highpass = fields.number("output_highpass")) output.highpass = Hertz{*highpass};
    return output;
  }

  void read_actuator(const EntrySpec& entry) {
    auto actuator = read_output(entry, "actuator", "[actuators]");
    check_ceiling(actuator.drive, errors_);
    if (actuator.channels.empty() && find(entry.fields, "channel") != nullptr && !rig_.incomplete)
      errors_.add(Errc::Missing, entry.at, "actuator '" + entry.name + "' has no channel",
                  "give its channel, or remove it");
    rig_.actuators.push_back(std::move(actuator));
  }

  void read_controls(const Value::Table& table) {
    const auto* fields = read_section(table, "controls", errors_);
    for (const auto& field : fields != nullptr ? *fields : Value::Table{}) {
      const auto value = read_quantity(field.value);
      if (errors_.keep(value) != nullptr) rig_.controls.push_back({field.key, field.value.at, *value});
    }
  }

  RigMidi read_midi(const EntrySpec& entry) {
    const auto& section = *rig_fields()["midi"].inside;
    FieldReader fields{entry, section, errors_, "control"};
    const auto number = [&](const char* key, double most = kUnlimited) {
      return static_cast<int>(fields.number(key, most).value_or(section[key].low));
    };
    RigMidi midi{entry.name, entry.at, fields.text("device")};
    if (fields.has("channel")) midi.channel = number("channel");
    midi.fine = fields.flag("fine");
    midi.gate = fields.flag("gate");
    const bool note = fields.has("note"), bend = fields.flag("pitch_bend"), control = fields.has("control");
    if (control + note + bend != 1)
      errors_.add(Errc::Missing, entry.at,
                  "control '" + entry.name + "' needs exactly one of 'control', 'note' and 'pitch_bend'",
                  "give one of control = 7, note = 36 and pitch_bend = true");
    if (note) midi.kind = RigMidi::Kind::Note;
    if (bend) midi.kind = RigMidi::Kind::PitchBend;
    if (control) midi.number = number("control", midi.fine ? 31 : 127);
    if (note) midi.number = number("note");
    if (midi.fine && !control)
      errors_.add(Errc::BadArgument, fields.value("fine")->at,
                  "'fine' is only allowed with a controller below 32", "remove 'fine'");
    if (midi.gate && !note)
      errors_.add(Errc::BadArgument, fields.value("gate")->at, "'gate' is only allowed with 'note'",
                  "remove 'gate'");
    return midi;
  }

  RigMidiOut read_midi_out(const EntrySpec& entry) {
    const auto& section = *rig_fields()["midi_out"].inside;
    FieldReader fields{entry, section, errors_, "MIDI output"};
    RigMidiOut out{entry.name, entry.at};
    const auto number = [&](const char* key, int otherwise) {
      return static_cast<int>(fields.number(key).value_or(otherwise));
    };
    const bool note = fields.has("note"), control = fields.has("control"), clock = fields.flag("clock");
    if (note + control + clock != 1)
      errors_.add(Errc::Missing, entry.at,
                  "'" + entry.name + "' needs exactly one of 'note', 'control' and 'clock'",
                  "give one of note = 38, control = 7 and clock = true");
    if (control) out.kind = RigMidiOut::Kind::Controller;
    if (clock) out.kind = RigMidiOut::Kind::Clock;
    out.number = number(control ? "control" : "note", 0);
    out.channel = number("channel", out.channel);
    out.per_beat = number("per_beat", out.per_beat);
    out.length = Seconds{fields.number("length").value_or(out.length.value)};
    for (auto [key, level] : {std::pair{"softest", &out.softest}, {"loudest", &out.loudest}})
      if (const auto* value = fields.value(key); value != nullptr) {
        const auto quantity = read_quantity(*value);
        if (errors_.keep(quantity) != nullptr) *level = quantity->si;
      }
    if (!(out.softest > 0 && out.softest < out.loudest))
      errors_.add(Errc::OutOfRange, entry.at,
                  "the softest level of '" + entry.name + "' is not below the loudest",
                  "give levels above 0, as in softest = \"-40 dB\", loudest = \"0 dB\"");
    only_with(note, fields, {"softest", "loudest", "length"}, "note");
    only_with(clock, fields, {"per_beat"}, "clock");
    return out;
  }
  void only_with(bool there, FieldReader& fields, std::initializer_list<const char*> keys, const char* what) {
    for (const auto* key : keys)
      if (!there && fields.has(key))
        errors_.add(Errc::BadArgument, fields.value(key)->at,
                    fmt::format("'{}' is only allowed with '{}'", key, what),
                    fmt::format("remove '{}'", key));
  }

  RigOsc read_osc(const EntrySpec& entry) {
    FieldReader fields{entry, *rig_fields()["osc"].inside, errors_, "control"};
    RigOsc osc{entry.name, entry.at, fields.text("address")};
    if (!fields.has("address")) return osc;
    const auto& at = fields.value("address")->at;
    if (!osc.address.starts_with('/') || osc.address.find_first_of(" #*,?[]{}") != std::string::npos)
      errors_.add(Errc::Syntax, at, "'" + osc.address + "' is no OSC address",
                  "it begins with / and has no spaces and none of #*,?[]{}, as in \"/1/fader3\"");
    for (const auto* own : {"/control/", "/trigger/", "/gesture/", "/preset/", "/arm", "/disarm", "/alive",
                            "/mute", "/subscribe", "/unsubscribe", "/list"})
      if (osc.address.starts_with(own))
        errors_.add(Errc::Duplicate, at, "'" + osc.address + "' has a meaning of its own",
                    "learn an address of another program, such as \"/1/fader3\"");
    if (std::ranges::find(rig_.osc, osc.address, &RigOsc::address) != rig_.osc.end())
      errors_.add(Errc::Duplicate, at, "'" + osc.address + "' moves another control already",
                  "give each address once");
    return osc;
  }

  RigHid read_hid(const EntrySpec& entry) {
    FieldReader fields{entry, *rig_fields()["hid"].inside, errors_, "control"};
    RigHid hid{entry.name, entry.at, fields.text("device")};
    const auto axis = fields.number("axis"), button = fields.number("button");
    if (fields.has("axis") == fields.has("button"))
      errors_.add(Errc::Missing, entry.at, "control '" + entry.name + "' needs an axis or a button",
                  "give one of axis = 0 and button = 0");
    if (fields.has("button")) hid.part = HidPart::Button;
    hid.number = static_cast<int>(button.value_or(axis.value_or(0)));
    hid.invert = fields.flag("invert");
    return hid;
  }

  void read_delay(const Value::Table& table) {
    const auto* section = read_section(table, "delay", errors_);
    if (section == nullptr) return;
    FieldReader fields{*section, *rig_fields()["delay"].inside, errors_};
    if (const auto measured = fields.number("measured")) rig_.measured_delay = Seconds{*measured};
    if (const auto pad = fields.number("pad")) rig_.pad_delay = Seconds{*pad};
  }

  /// A channel has one output, and one actuator at most.
  void check_channels() {
    check_users(rig_.outputs, "outputs");
    check_users(rig_.actuators, "actuators");
    for (const auto& output : rig_.outputs)
      for (const auto& actuator : rig_.actuators)
        if (output.has_actuator() &&
            std::ranges::find_first_of(output.channels, actuator.channels) != output.channels.end())
          errors_.add(Errc::Duplicate, output.at,
                      "the actuator of '" + output.name + "' is also '" + actuator.name + "' in [actuators]",
                      "declare it once");
  }

  void check_users(const std::vector<RigOutput>& ports, const char* what) {
    std::map<int, std::string> users;
    for (const auto& port : ports)
      for (const int channel : port.channels)
        if (const auto [user, first] = users.emplace(channel, port.name); !first)
          errors_.add(
              Errc::Duplicate, port.at,
              fmt::format("{} '{}' and '{}' share {}", what, port.name, user->second, channel_name(channel)),
              "give each its own channel");
  }

  ProfilePlaces places_;
  Rig rig_;
  ErrorList errors_;
};

/// format, name and about.
std::vector<FieldType> rig_heading() {
  auto fields = heading_fields();
  std::erase_if(fields, [](const FieldType& field) { return field.name == "source"; });
  return fields;
}

}  // namespace

const SectionType& rig_fields() {
  using Kind = FieldType::Kind;
  static const SectionType device{"the sound device, as listed by `tactus devices`",
                                  {required(text_field("output", "id of the device")),
                                   text_field("input", "id of the device", "that of the output"),
                                   text_field("second", "id of a joystick, wheel or gamepad beside it"),
                                   quantity_field("rate", "Hz", 1e3, 192e3, "sample rate"),
                                   whole_field("block", 1, 8192, "block size in frames"),
                                   whole_field("periods", 1, 64, "blocks in the driver's buffer")}};
  static const auto channel = required(
      field("channel", Kind::Channels,
            "channel of the card, counted from 1, one per lane; \"none\" leaves the port unconnected"));
  static const auto second = field("second", Kind::Flag, "the channels are those of the second device");
  static const SectionType input{
      "a sensor",
      {channel, second,
       quantity_field("volts_per_full_scale", "V", 1e-6, 1000, "voltage at the connector for full scale"),
       field("sensitivity", Kind::Any, "voltage for one unit of the port, as in \"2 V/m\""), about_field()},
      {},
      {"sensitivity", "volts_per_full_scale"}};
  static const SectionType output{"an output and its actuator",
                                  joined(joined({channel, second}, actuator_fields()),
                                         {quantity_field("output_highpass", "Hz", 0.001, 1000,
                                                         "cut-off frequency of the card's AC coupling")}),
                                  {},
                                  {"profile", "volts_per_full_scale"}};
  static const SectionType midi{
      "a MIDI source of a control",
      {text_field("device", "part of the port's name", "any"),
       whole_field("channel", 1, 16, "MIDI channel", "any"),
       whole_field("control", 0, 127, "number of the controller"),
       whole_field("note", 0, 127, "note number; its velocity sets the control"),
       field("pitch_bend", Kind::Flag, "the pitch wheel sets the control"),
       field("fine", Kind::Flag, "14-bit value, with controller + 32 as its low bits"),
       field("gate", Kind::Flag, "the control is 1 while the note is held")}};
  static const SectionType midi_out{
      "a MIDI message that an event or a control sends",
      {whole_field("channel", 1, 16, "MIDI channel", "1"),
       whole_field("note", 0, 127, "the event plays this note; its level is the velocity"),
       field("softest", Kind::Any, "level of the event with velocity 1", "-40 dB"),
       field("loudest", Kind::Any, "level of the event with velocity 127", "0 dB"),
       quantity_field("length", "s", 0.001, 10, "length of the note", "50 ms"),
       whole_field("control", 0, 127, "the control sends this controller, as a share of its range"),
       field("clock", Kind::Flag, "the control, in Hz, gives the beats of a MIDI clock"),
       whole_field("per_beat", 1, 96, "periods of the control in a beat of the clock", "1")}};
  static const SectionType osc{
      "an OSC address of another program that moves a control",
      {required(text_field("address", "such as \"/1/fader3\"; 0 to 1 over the range"))}};
  static const SectionType hid{
      "an axis or a button of a joystick, gamepad or pedal that moves a control",
      {text_field("device", "part of its name", "any"), whole_field("axis", 0, 63, "number of the axis"),
       whole_field("button", 0, 63, "the control is at its highest value while it is pressed"),
       field("invert", Kind::Flag, "the other way round")}};
  static const SectionType delay{"system delay",
                                 {quantity_field("measured", "s", 0, 10, "measured delay of the card"),
                                  quantity_field("pad", "s", 0, 10, "total delay, reached by adding delay")}};
  static const SectionType section{
      "a rig file: the hardware of an instrument",
      joined(
          rig_heading(),
          {required(section_field("device", device)),
           entries_field("inputs", input, "channels of the instrument's inputs"),
           entries_field("outputs", output, "channels of the instrument's outputs"),
           entries_field("actuators", output, "actuators on channels that must never carry sound"),
           field("controls", Kind::Settings, "initial values of controls"),
           entries_field("midi", midi, "MIDI sources of the controls"),
           entries_field("midi_out", midi_out, "MIDI messages of events and controls"),
           entries_field("osc", osc, "OSC addresses of other programs that move controls"),
           entries_field("hid", hid, "axes and buttons of joysticks, gamepads and pedals that move controls"),
           section_field("delay", delay)})};
  return section;
}

const RigOutput* Rig::actuator_on(int channel) const {
  for (const auto& actuator : actuators)
    if (actuator.uses(channel)) return &actuator;
  for (const auto& output : outputs)
    if (output.has_actuator() && output.uses(channel)) return &output;
  return nullptr;
}

std::vector<LimitSource> Rig::limit_sources(int channel) const {
  std::vector<LimitSource> sources;
  for (const auto* ports : {&actuators, &outputs})
    for (const auto& port : *ports)
      if (port.uses(channel)) std::ranges::copy(port.drive.sources(), std::back_inserter(sources));
  return sources;
}

Checked<Rig> load_rig(const std::filesystem::path& file, const ProfilePlaces& profiles) {
  return RigReader{file, profiles}.read(load_toml(file));
}

Checked<Rig> parse_rig(std::string_view text, const std::string& file_name, const ProfilePlaces& profiles) {
  return RigReader{file_name, profiles}.read(parse_toml(text, file_name));
}

namespace {

const Dimension kVolt = parse_unit("V")->dimension;
const Dimension kSecond = parse_unit("s")->dimension;
const Dimension kHertz = parse_unit("Hz")->dimension;

bool reads_back(const std::string& text, double si) {
  const auto parsed = parse_quantity(text);
  return parsed && parsed->si == si;
}

/// Volts over the unit of a port; all digits in SI where the usual name reads back as something else.
std::string sensitivity_text(const QuantityValue& sensitivity) {
  if (sensitivity.bare || sensitivity.unit.dimension == kVolt) return exact_quantity(sensitivity);
  return in_quotes(fmt::format("{} {}", sensitivity.si, volts_per(sensitivity.unit.dimension)));
}

std::string channel_text(const RigPort& port) {
  if (port.channels.empty()) return "channel = \"none\"";
  auto channels = port.channels;
  for (auto& channel : channels) channel -= port.on_second_device() ? kSecondDevice : 0;
  auto text = channels.size() == 1 ? fmt::format("channel = {}", channels.front())
                                   : fmt::format("channel = [{}]", fmt::join(channels, ", "));
  return text + (port.on_second_device() ? ", second = true" : "");
}

std::string about_text(const RigPort& port) {
  return port.about.empty() ? "" : ", about = " + in_quotes(port.about);
}

/// A key, in quotes unless TOML takes it as it is.
std::string key_text(const std::string& name) {
  const auto is_bare = [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-');
  };
  return !name.empty() && std::ranges::all_of(name, is_bare) ? name : in_quotes(name);
}

std::string line(const RigInput& input) {
  auto text = key_text(input.name) + " = { " + channel_text(input);
  if (input.volts) text += ", volts_per_full_scale = " + exact_quantity(*input.volts, kVolt);
  if (input.sensitivity) text += ", sensitivity = " + sensitivity_text(*input.sensitivity);
  return text + about_text(input) + " }\n";
}

std::string line(const RigOutput& output) {
  auto text = key_text(output.name) + " = { " + channel_text(output);
  const auto& drive = output.drive;
  if (!drive.profile.empty()) text += ", profile = " + in_quotes(drive.profile);
  if (drive.volts) text += ", volts_per_full_scale = " + exact_quantity(*drive.volts, kVolt);
  if (drive.ceiling) text += fmt::format(", ceiling = {}", *drive.ceiling);
  if (output.highpass) text += ", output_highpass = " + exact_quantity(output.highpass->value, kHertz);
  return text + about_text(output) + " }\n";
}

std::string line(const Rig::Control& control) {
  return key_text(control.name) + " = " + exact_quantity(control.value) + "\n";
}

std::string line(const RigMidi& midi) {
  std::string text = key_text(midi.control) + " = { ";
  if (!midi.device.empty()) text += "device = " + in_quotes(midi.device) + ", ";
  if (midi.channel > 0) text += fmt::format("channel = {}, ", midi.channel);
  constexpr const char* kKeys[] = {"control = {}", "note = {}", "pitch_bend = true"};  // as Kind
  text += fmt::format(fmt::runtime(kKeys[static_cast<int>(midi.kind)]), midi.number);
  return text + (midi.fine ? ", fine = true" : "") + (midi.gate ? ", gate = true" : "") + " }\n";
}

std::string line(const RigMidiOut& out) {
  using Kind = RigMidiOut::Kind;
  std::string text = key_text(out.name) + " = { ";
  if (out.channel != 1) text += fmt::format("channel = {}, ", out.channel);
  if (out.kind == Kind::Controller) text += fmt::format("control = {}", out.number);
  if (out.kind == Kind::Clock) text += fmt::format("clock = true, per_beat = {}", out.per_beat);
  if (out.kind == Kind::Note)
    text += fmt::format("note = {}, softest = {}, loudest = {}, length = {}", out.number, out.softest,
                        out.loudest, exact_quantity(out.length.value, kSecond));
  return text + " }\n";
}

std::string line(const RigOsc& osc) {
  return key_text(osc.control) + " = { address = " + in_quotes(osc.address) + " }\n";
}

std::string line(const RigHid& hid) {
  std::string text = key_text(hid.control) + " = { ";
  if (!hid.device.empty()) text += "device = " + in_quotes(hid.device) + ", ";
  text += fmt::format("{} = {}", name_of(hid.part), hid.number);
  return text + (hid.invert ? ", invert = true" : "") + " }\n";
}

template <class Items>
std::string section(const char* name, const Items& items) {
  if (items.empty()) return "";
  std::string text = fmt::format("\n[{}]\n", name);
  for (const auto& item : items) text += line(item);
  return text;
}

std::string device_section(const Rig::Device& device) {
  auto text = "\n[device]\noutput = " + in_quotes(device.output) + "\n";
  if (!device.input.empty()) text += "input = " + in_quotes(device.input) + "\n";
  if (!device.second.empty()) text += "second = " + in_quotes(device.second) + "\n";
  if (device.rate) text += "rate = " + exact_quantity(device.rate->value, kHertz) + "\n";
  if (device.block) text += fmt::format("block = {}\n", *device.block);
  if (device.periods) text += fmt::format("periods = {}\n", *device.periods);
  return text;
}

std::string delay_section(const Rig& rig) {
  if (!rig.measured_delay && !rig.pad_delay) return "";
  std::string text = "\n[delay]\n";
  if (rig.measured_delay) text += "measured = " + exact_quantity(rig.measured_delay->value, kSecond) + "\n";
  if (rig.pad_delay) text += "pad = " + exact_quantity(rig.pad_delay->value, kSecond) + "\n";
  return text;
}

}  // namespace

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\')
      out += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      out += fmt::format("\\u{:04X}", static_cast<unsigned char>(c));
    else
      out += c;
  }
  return out + '"';
}

std::string channel_name(int channel) {
  return channel > kSecondDevice ? fmt::format("channel {} of the second device", channel - kSecondDevice)
                                 : fmt::format("channel {}", channel);
}

std::string volts_per(const Dimension& sensitivity) {
  const auto name = "V/" + to_string(kVolt / sensitivity);
  const auto unit = parse_unit(name);
  return unit && unit->dimension == sensitivity ? name : to_string(sensitivity);
}

std::string exact_quantity(double si, const Dimension& dimension) {
  if (dimension.plain()) return fmt::format("{}", si);
  const auto readable = short_quantity(si, dimension);
  return in_quotes(reads_back(readable, si) ? readable : fmt::format("{} {}", si, to_string(dimension)));
}

std::string exact_quantity(const QuantityValue& value) {
  if (value.unit.decibel) {
    const double decibels = value.unit.from_si(value.si);
    for (const auto& text : {fmt::format("{:.10g} dB", decibels), fmt::format("{} dB", decibels)})
      if (reads_back(text, value.si)) return in_quotes(text);
  }
  return exact_quantity(value.si, value.unit.dimension);
}

std::string to_text(const Rig& rig) {
  std::string text = "format = 1\n";
  if (!rig.name.empty()) text += "name = " + in_quotes(rig.name) + "\n";
  if (!rig.about.empty()) text += "about = " + in_quotes(rig.about) + "\n";
  return text + device_section(rig.device) + section("inputs", rig.inputs) + section("outputs", rig.outputs) +
         section("actuators", rig.actuators) + section("controls", rig.controls) + section("midi", rig.midi) +
         section("midi_out", rig.midi_out) + section("osc", rig.osc) + section("hid", rig.hid) +
         delay_section(rig);
}

}  // namespace tactus
