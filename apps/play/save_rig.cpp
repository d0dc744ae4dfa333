#include "apps/play/save_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <sstream>

#include "apps/cli/console.h"
#include "engine/core/files.h"
#include "engine/graph/file/error_list.h"
#include "engine/rig/check_rig.h"
#include "engine/rig/profile.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

const std::string kNone = "none";

/// Accepts an answer, or throws a CommandError.
using UseAnswer = std::function<void(const std::string&)>;

[[noreturn]] void refuse(const std::string& what, const std::string& remedy) {
  exit_with({Errc::BadArgument, "", what, remedy}, kUsage);
}

/// "2 5" or "2, 5"
std::optional<std::vector<int>> numbers_in(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream in{text};
  std::vector<int> numbers;
  for (int number = 0; in >> number;) numbers.push_back(number);
  return in.eof() && !numbers.empty() ? std::optional{numbers} : std::nullopt;
}

QuantityValue quantity_in(const std::string& text, const Dimension& wanted, const std::string& example) {
  const auto quantity = read_quantity(Value{text, {}});
  const bool fits = quantity && (quantity->bare || quantity->unit.dimension == wanted);
  if (fits && quantity->si != 0) return {quantity->si, Unit{wanted}, false};
  refuse("'" + text + "' is not a valid answer", "write for instance " + example);
}

Dimension volt() { return parse_unit("V")->dimension; }

/// "'name' (what `about` says)"
std::string title_of(const PortSpec& port) {
  ErrorList reported_elsewhere;
  const auto about = reported_elsewhere.text(port.fields, "about");
  return "'" + port.name + "'" + (about.empty() ? "" : " (" + about + ")");
}

/// Volts from `least` to 1 kV.
UseAnswer take_volts(double least, const char* least_text, const std::string& example,
                     std::optional<double>& to) {
  return [=, &to](const std::string& text) {
    const double volts = quantity_in(text, volt(), example).si;
    if (!(volts >= least && volts <= 1000))
      refuse(fmt::format("must be between {} and 1 kV", least_text), "write for instance " + example);
    to = volts;
  };
}

struct Interview {
  Rig& rig;
  int device_inputs, device_outputs;
  const ProfilePlaces& profiles;
  const Dialog& dialog;

  void ask_input(const PortSpec& port) {
    auto& input = rig.inputs.emplace_back();
    input.name = port.name;
    const auto proposed = static_cast<int>(rig.inputs.size());
    ask(fmt::format("Which input of the card is {}? 1 to {}, or none", title_of(port), device_inputs),
        proposed <= device_inputs ? std::to_string(proposed) : kNone,
        [&](const std::string& text) { return take_channels(text, input, device_inputs, true); });
    if (!input.channels.empty()) ask_sensitivity(port, input);
  }

  void ask_output(const PortSpec& port) {
    auto& output = rig.outputs.emplace_back();
    output.name = port.name;
    const bool audio = port.use == OutputUse::Audio;
    int free = 1;
    while (used_by_output(free)) ++free;
    ask(fmt::format("Which output of the card is {}? {}; 1 to {}, or none", title_of(port),
                    audio ? "It is a monitor output" : "It drives an actuator", device_outputs),
        free <= device_outputs ? std::to_string(free) : kNone,
        [&](const std::string& text) { return take_channels(text, output, device_outputs, false); });
    if (audio || output.channels.empty()) return;
    ask("What does '" + port.name +
            "' drive? woofer, bass_shaker, tactor_lra, …, or a file beside the rig; unknown: conservative "
            "limits",
        "unknown", [&](const std::string& text) { return take_profile(text, output); });
    if (!output.has_actuator()) return add_actuators(output.channels, "what '" + port.name + "' drives");
    // There is no conservative guess: too few volts would allow too much.
    ask("Which voltage at the actuator, after the amplifier, does a sample value of 1 give? Such as 10 V", "",
        take_volts(1e-3, "1 mV", "10 V", output.drive.volts));
  }

  void ask_actuators() {
    if (device_outputs <= static_cast<int>(rig.outputs.size())) return;
    RigPort others;
    ask("Are actuators connected to other outputs (which must never carry sound)? Channel numbers, or none",
        kNone, [&](const std::string& text) { return take_channels(text, others, device_outputs, false); });
    add_actuators(others.channels, "");
  }

  /// Of which no more is known; sound may never go there.
  void add_actuators(const std::vector<int>& channels, const std::string& about) {
    for (const int channel : channels) {
      auto& actuator = rig.actuators.emplace_back();
      actuator.name = fmt::format("on_{}", channel);
      actuator.channels = {channel};
      actuator.about = about;
    }
  }

  /// Asks until `take` accepts the answer. `proposed`: what an empty line stands for; empty: nothing.
  void ask(const std::string& question, const std::string& proposed, const UseAnswer& take) const {
    while (true) {
      std::string answer;
      if (!dialog.take_defaults) {
        dialog.out << question << (proposed.empty() ? "" : " [" + proposed + "]") << ": " << std::flush;
        if (!std::getline(dialog.in, answer))
          exit_with({Errc::Missing, "--save-rig", "the input ended before all questions were answered",
                     "answer on a terminal, or accept all defaults with --yes"});
      }
      answer = CLI::detail::trim_copy(answer);
      if (answer.empty()) answer = proposed;
      try {
        if (answer.empty()) refuse("this question has no default", "give an answer");
        return take(answer);
      } catch (const CommandError& error) {
        if (dialog.take_defaults) throw;
        dialog.out << "  " << to_string(error.errors) << "\n";
      }
    }
  }

  void ask_sensitivity(const PortSpec& port, RigInput& input) {
    const auto &dimension = port.dimension, per_volt = volt() / dimension;
    const auto unit = dimension.plain() ? std::string{"V"} : volts_per(per_volt);
    ask("Which voltage at that input is full scale? Such as 1 V; unknown: a sample value of 1 counts as 1" +
            (dimension.plain() ? "" : " " + to_string(dimension)),
        "unknown", [&](const std::string& text) {
          if (text != "unknown") return take_volts(1e-6, "1 uV", "1 V", input.volts)(text);
          if (dimension.plain()) return;
          input.volts = 1.0;
          input.sensitivity = QuantityValue{1.0, Unit{per_volt}, false};
        });
    if (!input.volts || input.sensitivity) return;
    ask(dimension.plain()
            ? "Which sensor voltage counts as full scale? Such as 50 mV (or determine it with --learn)"
            : "How sensitive is the sensor? In " + unit + ", such as 2 " + unit,
        fmt::format("{} {}", *input.volts, unit),
        [&](const std::string& text) { input.sensitivity = quantity_in(text, per_volt, "2 " + unit); });
  }

  bool used_by_output(int channel) const {
    return std::any_of(rig.outputs.begin(), rig.outputs.end(),
                       [channel](const RigOutput& output) { return output.uses(channel); });
  }

  void take_channels(const std::string& text, RigPort& port, int there, bool shared) {
    if (text == kNone) return;
    const auto numbers = numbers_in(text);
    if (!numbers)
      refuse("'" + text + "' is not a channel", "write a number, several for several lanes, or none");
    for (const int number : *numbers) {
      if (number < 1 || number > there)
        refuse(fmt::format("the card has no channel {}", number),
               there > 0 ? fmt::format("it has channels 1 to {}", there) : "write none");
      if (!shared && used_by_output(number))
        refuse(fmt::format("channel {} is already used", number), "choose another");
    }
    port.channels = *numbers;
  }

  void take_profile(const std::string& text, RigOutput& output) {
    if (text == "unknown" || text == kNone) return;
    or_exit(load_profile(or_exit(find_profile_of_file(text, profiles, {}))));
    output.drive.profile = text;
  }
};

}  // namespace

Rig ask_for_rig(const GraphSpec& instrument, Rig::Device device, int device_inputs, int device_outputs,
                const ProfilePlaces& profiles, const Dialog& dialog) {
  Rig rig;
  rig.name = instrument.name;
  rig.device = std::move(device);
  Interview interview{rig, device_inputs, device_outputs, profiles, dialog};
  for (const auto& port : instrument.inputs) interview.ask_input(port);
  for (const auto& port : instrument.outputs) interview.ask_output(port);
  interview.ask_actuators();
  return rig;
}

Status save_rig(const Rig& rig, const fs::path& file, const Dialog& dialog, bool force) {
  std::error_code ignored;
  if (!force && fs::exists(file, ignored)) {
    dialog.out << "'" << file.string() << "' exists. Overwrite it? [no]: " << std::flush;
    std::string answer;
    if (!dialog.take_defaults) std::getline(dialog.in, answer);
    answer = CLI::detail::trim_copy(answer);
    if (answer != "y" && answer != "yes")
      return fail(Errc::BadFile, "--save-rig", "'" + file.string() + "' was not overwritten",
                  "choose another name, answer yes, or give --force");
  }
  return replace_file(file, to_text(rig));
}

}  // namespace tactus::app
