#include "engine/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "engine/graph/file/field.h"
#include "engine/graph/file/load.h"
#include "engine/graph/file/read_graph.h"
#include "engine/rig/rig_midi.h"

namespace tactus {
namespace {

constexpr int kMostChannels = 1024;

class RigReader {
 public:
  RigReader(const std::filesystem::path& file, const std::filesystem::path& root)
      : places_{file.parent_path(), file.parent_path(), root} {
    rig_.file = {std::make_shared<const std::string>(file.string()), 0, 0};
    mistakes_ = ErrorList{rig_.file};
  }

  LoadedRig read(const Result<Value::Table>& table) {
    if (mistakes_.keep(table) == nullptr) return {std::nullopt, mistakes_.take()};
    read_sections(*table);
    check_channels();
    return {std::move(rig_), mistakes_.take()};
  }

 private:
  void read_sections(const Value::Table& table) {
    check_format(table, rig_.file, mistakes_);
    const auto keys = rig_fields().keys();
    rig_.incomplete = std::any_of(table.begin(), table.end(), [&](const Field& field) {
      return std::find(keys.begin(), keys.end(), field.key) == keys.end();
    });
    FieldReader fields{table, rig_fields(), mistakes_};
    rig_.name = fields.text("name");
    rig_.about = mistakes_.text(table, "about");
    read_device(table);
    for (const auto& entry : read_entries(table, "inputs", "{ channel = 1 }", mistakes_)) read_input(entry);
    for (const auto& entry : read_entries(table, "outputs", "{ channel = 1 }", mistakes_))
      rig_.outputs.push_back(read_output(entry));
    for (const auto& entry :
         read_entries(table, "actuators",
                      "{ channel = 3, profile = \"woofer\", volts_per_full_scale = \"10 V\" }", mistakes_))
      read_actuator(entry);
    read_controls(table);
    rig_.midi = read_midi(table, mistakes_);
    read_delay(table);
  }

  void read_device(const Value::Table& table) {
    auto& device = rig_.device;
    device.at = {rig_.file.file, 1, 1};
    const auto* fields = read_section(table, "device", mistakes_);
    if (fields != nullptr) device.at = find(table, "device")->at;
    if (fields == nullptr || find(*fields, "output") == nullptr)
      mistakes_.add(Errc::Missing, device.at, "the rig names no device",
                    "under [device], write output = \"…\" with an id that `tactus devices` shows");
    if (fields == nullptr) return;
    FieldReader reader{*fields, *rig_fields()["device"].inside, mistakes_};
    device.output = reader.text("output");
    device.input = reader.text("input");
    if (const auto rate = reader.number("rate")) device.rate = Hertz{*rate};
    if (const auto block = reader.number("block")) device.block = static_cast<int>(*block);
    if (const auto periods = reader.number("periods")) device.periods = static_cast<int>(*periods);
  }

  void read_port(const EntrySpec& entry, RigPort& port) {
    port.name = entry.name;
    port.at = entry.at;
    if (const auto* about = find(entry.fields, "about"); about != nullptr && about->text() != nullptr)
      port.about = *about->text();
    const auto* channel = find(entry.fields, "channel");
    if (channel != nullptr && channel->text() != nullptr && *channel->text() == "none") return;
    if (channel == nullptr && !entry.broken)
      mistakes_.add(Errc::Missing, entry.at, "'" + entry.name + "' has no channel",
                    "write channel = 1, or channel = \"none\" to leave it out");
    if (channel == nullptr) return;
    if (const auto* lanes = channel->list())
      for (const auto& lane : *lanes) read_channel(lane, port);
    else
      read_channel(*channel, port);
  }

  void read_channel(const Value& value, RigPort& port) {
    const auto* number = value.number();
    const bool whole = number != nullptr && std::floor(*number) == *number;
    if (whole && *number >= 1 && *number <= kMostChannels)
      return port.channels.push_back(static_cast<int>(*number));
    rig_.incomplete = true;
    mistakes_.add(Errc::OutOfRange, value.at,
                  whole ? "there is no channel " + short_number(*number)
                        : "a channel is a whole number, not " + value.kind(),
                  "channels count from 1, as on the card; \"none\" leaves the port out");
  }

  void read_input(const EntrySpec& entry) {
    FieldReader fields{entry.fields, *rig_fields()["inputs"].inside, mistakes_};
    RigInput input;
    read_port(entry, input);
    input.volts = fields.number("volts_per_full_scale");
    const auto* sensitivity = find(entry.fields, "sensitivity");
    const bool has_volts = find(entry.fields, "volts_per_full_scale") != nullptr;
    if (has_volts != (sensitivity != nullptr))
      mistakes_.add(
          Errc::Missing, entry.at,
          "input '" + entry.name + "' lacks '" + (has_volts ? "sensitivity" : "volts_per_full_scale") + "'",
          "give both, or neither where a sample of 1 means 1");
    if (sensitivity != nullptr) read_sensitivity(*sensitivity, input);
    rig_.inputs.push_back(std::move(input));
  }

  void read_sensitivity(const Value& value, RigInput& input) {
    input.sensitivity_at = value.at;
    const auto quantity = read_quantity(value);
    if (mistakes_.keep(quantity) == nullptr) return;
    if (std::abs(quantity->si) >= 1e-12 && std::abs(quantity->si) <= 1e12)
      input.sensitivity = *quantity;
    else
      mistakes_.add(Errc::OutOfRange, value.at, "'sensitivity' cannot be " + short_number(quantity->si),
                    "give the volts for one unit, such as \"50 mV\" or \"2 V/m\"");
  }

  RigOutput read_output(const EntrySpec& entry) {
    FieldReader{entry.fields, *rig_fields()["outputs"].inside, mistakes_};
    RigOutput output;
    read_port(entry, output);
    output.drive = read_drive(entry, places_, mistakes_);
    return output;
  }

  void read_actuator(const EntrySpec& entry) {
    auto actuator = read_output(entry);
    if (actuator.channels.empty() && find(entry.fields, "channel") != nullptr && !rig_.incomplete)
      mistakes_.add(Errc::Missing, entry.at, "actuator '" + entry.name + "' has no channel",
                    "give its channel, or remove it");
    rig_.actuators.push_back(std::move(actuator));
  }

  void read_controls(const Value::Table& table) {
    const auto* fields = read_section(table, "controls", mistakes_);
    for (const auto& field : fields != nullptr ? *fields : Value::Table{}) {
      const auto value = read_quantity(field.value);
      if (mistakes_.keep(value) != nullptr) rig_.controls.push_back({field.key, field.value.at, *value});
    }
  }

  void read_delay(const Value::Table& table) {
    const auto* section = read_section(table, "delay", mistakes_);
    if (section == nullptr) return;
    FieldReader fields{*section, *rig_fields()["delay"].inside, mistakes_};
    if (const auto measured = fields.number("measured")) rig_.measured_delay = Seconds{*measured};
    if (const auto pad = fields.number("pad")) rig_.pad_delay = Seconds{*pad};
  }

  /// A channel has one output, and one actuator at most.
  void check_channels() {
    const auto once = [this](const std::vector<RigOutput>& ports, const char* what) {
      std::map<int, std::string> users;
      for (const auto& port : ports)
        for (const int channel : port.channels) {
          const auto [user, fresh] = users.emplace(channel, port.name);
          if (!fresh)
            mistakes_.add(Errc::Duplicate, port.at,
                          std::string{what} + " '" + port.name + "' and '" + user->second +
                              "' share channel " + std::to_string(channel),
                          "give each a channel of its own");
        }
    };
    once(rig_.outputs, "outputs");
    once(rig_.actuators, "actuators");
    for (const auto& output : rig_.outputs)
      for (const auto& actuator : rig_.actuators)
        if (output.has_actuator() && share_channel(output, actuator))
          mistakes_.add(
              Errc::Duplicate, output.at,
              "the actuator of '" + output.name + "' is also '" + actuator.name + "' in [actuators]",
              "say it once");
  }

  static bool share_channel(const RigOutput& a, const RigOutput& b) {
    return std::find_first_of(a.channels.begin(), a.channels.end(), b.channels.begin(), b.channels.end()) !=
           a.channels.end();
  }

  ProfilePlaces places_;
  Rig rig_;
  ErrorList mistakes_;
};

Checked<Rig> without_mistakes(LoadedRig loaded) {
  if (!loaded.mistakes.empty()) return tl::unexpected(std::move(loaded.mistakes));
  return std::move(*loaded.rig);
}

}  // namespace

const SectionType& rig_fields() {
  using Kind = FieldType::Kind;
  static const SectionType device{
      "as `tactus devices` shows it",
      {required(text_field("output", "id")), text_field("input", "id", "that of the output"),
       quantity_field("rate", "Hz", 8e3, 192e3, "sample rate"), whole_field("block", 1, 8192, "frames"),
       whole_field("periods", 1, 64, "blocks in the driver's buffer")}};
  static const auto channel = required(field(
      "channel", Kind::Channels, "of the card, from 1; one for each lane; \"none\" leaves the port out"));
  static const SectionType input{
      "a sensor",
      {channel, quantity_field("volts_per_full_scale", "V", 1e-6, 1000, "at the connector"),
       field("sensitivity", Kind::Any, "volts for one unit of the port, as in \"2 V/m\""), about_field()},
      {},
      {"sensitivity", "volts_per_full_scale"}};
  static const SectionType output = [] {
    SectionType wired{"an output and its actuator", {channel}, {}, {"profile", "volts_per_full_scale"}};
    for (auto& field : actuator_fields()) wired.fields.push_back(std::move(field));
    return wired;
  }();
  static const SectionType delay{"system delay",
                                 {quantity_field("measured", "s", 0, 10, "of the card"),
                                  quantity_field("pad", "s", 0, 10, "hold the whole at this")}};
  static const SectionType section = [] {
    SectionType rig{"the hardware that an instrument plays on", heading_fields()};
    std::erase_if(rig.fields, [](const FieldType& field) { return field.key == "source"; });
    for (auto& field : std::vector<FieldType>{
             required(section_field("device", device)),
             entries_field("inputs", input, "where the instrument's inputs come from"),
             entries_field("outputs", output, "where the instrument's outputs go"),
             entries_field("actuators", output, "on channels that sound must never reach"),
             field("controls", Kind::Settings, "initial values of controls"),
             entries_field("midi", midi_fields(), "what moves the controls"), section_field("delay", delay)})
      rig.fields.push_back(std::move(field));
    return rig;
  }();
  return section;
}

const RigOutput* Rig::actuator_on(int channel) const {
  const auto on_channel = [channel](const RigOutput& output) {
    return std::find(output.channels.begin(), output.channels.end(), channel) != output.channels.end();
  };
  for (const auto& actuator : actuators)
    if (on_channel(actuator)) return &actuator;
  for (const auto& output : outputs)
    if (output.has_actuator() && on_channel(output)) return &output;
  return nullptr;
}

LoadedRig load_rig_leniently(const std::filesystem::path& file, const std::filesystem::path& root) {
  return RigReader{file, root}.read(load_toml(file));
}

LoadedRig parse_rig_leniently(std::string_view text, const std::string& file_name,
                              const std::filesystem::path& root) {
  return RigReader{file_name, root}.read(parse_toml(text, file_name));
}

Checked<Rig> load_rig(const std::filesystem::path& file, const std::filesystem::path& root) {
  return without_mistakes(load_rig_leniently(file, root));
}

Checked<Rig> parse_rig(std::string_view text, const std::string& file_name,
                       const std::filesystem::path& root) {
  return without_mistakes(parse_rig_leniently(text, file_name, root));
}

}  // namespace tactus
