#include "apps/play/save_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <istream>
#include <ostream>
#include <sstream>
#include <system_error>
#include <utility>

#include "engine/graph/file/read_graph.h"
#include "engine/rig/profile.h"
#include "engine/rig/rig_text.h"

namespace tactus::app {
namespace {

namespace fs = std::filesystem;

const std::string kNone = "none";

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

Status nonsense(const std::string& what, const std::string& remedy) {
  return fail(Errc::BadArgument, "", what, remedy);
}

/// "2 5" or "2, 5"
std::optional<std::vector<int>> numbers_in(const std::string& text) {
  std::vector<int> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (at != end) {
    if (*at == ' ' || *at == ',') {
      ++at;
      continue;
    }
    int number = 0;
    const auto parsed = std::from_chars(at, end, number);
    if (parsed.ec != std::errc{}) return std::nullopt;
    numbers.push_back(number);
    at = parsed.ptr;
  }
  return numbers;
}

Result<QuantityValue> quantity_in(const std::string& text, const Dimension& wanted,
                                  const std::string& example) {
  const auto quantity = read_quantity(Value{text, {}});
  const bool fits = quantity && (quantity->bare || quantity->unit.dimension == wanted);
  if (fits && quantity->si != 0) return QuantityValue{quantity->si, Unit{wanted}, false};
  return fail(Errc::BadArgument, "", "'" + text + "' makes no sense here", "write for instance " + example);
}

Dimension dimension_of(const EntrySpec& port) {
  ErrorList told_elsewhere;
  return read_unit(port, told_elsewhere).value_or(Unit{}).dimension;
}

std::string about(const EntrySpec& port) {
  ErrorList told_elsewhere;
  const auto text = told_elsewhere.text(port.fields, "about");
  return text.empty() ? "" : " (" + text + ")";
}

Dimension volt() { return parse_unit("V")->dimension; }

std::optional<RigQuestion> asked_if(bool needed, const RigQuestion& question) {
  return needed ? std::optional{question} : std::nullopt;
}

RigQuestion full_scale_question(const std::string& per) {
  return {
      "How many volts at that input are full scale? Such as 1 V; unknown: a sample of 1 counts as 1" + per,
      "unknown"};
}

RigQuestion sensitivity_question(const Dimension& dimension, const std::string& unit, double volts) {
  return {dimension.plain() ? "How many volts of the sensor count as full scale? Such as 50 mV (or find out "
                              "with --learn)"
                            : "How sensitive is the sensor? In " + unit + ", such as 2 " + unit,
          fmt::format("{} {}", volts, unit)};
}

RigQuestion profile_question(const std::string& name) {
  return {
      "What does '" + name +
          "' move? woofer, bass_shaker, tactor_lra, …, or a file; unknown: the guard's limits are cautious",
      "unknown"};
}

/// Volts from `least` to 1 kV.
Status take_volts(const std::string& text, double least, const char* least_text, const char* example,
                  std::optional<double>& to) {
  const auto volts = quantity_in(text, volt(), example);
  if (!volts) return tl::unexpected(volts.error());
  if (!(volts->si >= least && volts->si <= 1000))
    return nonsense(fmt::format("it is between {} and 1 kV", least_text),
                    fmt::format("write for instance {}", example));
  to = volts->si;
  return {};
}

Status take_full_scale(const std::string& text, const Dimension& dimension, RigInput& input) {
  if (text != "unknown") return take_volts(text, 1e-6, "1 uV", "1 V", input.volts);
  if (dimension.plain()) return {};
  input.volts = 1.0;
  input.sensitivity = QuantityValue{1.0, Unit{volt() / dimension}, false};
  return {};
}

}  // namespace

RigInterview::RigInterview(const GraphSpec& instrument, Rig::Device device, int device_inputs,
                           int device_outputs, fs::path root)
    : device_inputs_(device_inputs), device_outputs_(device_outputs), root_(std::move(root)) {
  rig_.name = instrument.name;
  rig_.device = std::move(device);
  for (const auto& port : instrument.inputs) rig_.inputs.emplace_back().name = port.name;
  for (const auto& port : instrument.outputs) rig_.outputs.emplace_back().name = port.name;
  for (std::size_t i = 0; i < instrument.inputs.size(); ++i) ask_input(instrument.inputs[i], i);
  for (std::size_t o = 0; o < instrument.outputs.size(); ++o) ask_output(instrument.outputs[o], o);
  ask_actuators();
  skip_needless();
}

std::optional<RigQuestion> RigInterview::question() const {
  if (next_ >= steps_.size()) return std::nullopt;
  return steps_[next_].ask();
}

Status RigInterview::answer(const std::string& given) {
  const auto asked = question();
  if (!asked) return {};
  auto text = trimmed(given);
  if (text.empty()) text = asked->on_enter;
  if (text.empty()) return nonsense("this has no default", "give an answer");
  if (auto status = steps_[next_].take(text); !status) return status;
  ++next_;
  skip_needless();
  return {};
}

void RigInterview::skip_needless() {
  while (next_ < steps_.size() && !steps_[next_].ask()) ++next_;
}

void RigInterview::add(std::function<std::optional<RigQuestion>()> ask,
                       std::function<Status(const std::string&)> take) {
  steps_.push_back({std::move(ask), std::move(take)});
}

void RigInterview::ask_input(const EntrySpec& port, std::size_t index) {
  auto* input = &rig_.inputs[index];  // the rig keeps its ports from here on
  const auto dimension = dimension_of(port);
  const auto per = dimension.plain() ? "" : " " + to_string(dimension);
  const auto unit = dimension.plain() ? std::string{"V"} : volts_per(volt() / dimension);
  add(
      [=, text = port.name + "'" + about(port), this] {
        const bool there = static_cast<int>(index) < device_inputs_;
        return RigQuestion{
            fmt::format("Which input of the card is '{}? 1 to {}, or none", text, device_inputs_),
            there ? std::to_string(index + 1) : kNone};
      },
      [=, this](const std::string& text) { return take_channels(text, *input, device_inputs_, true); });
  add([=] { return asked_if(!input->channels.empty(), full_scale_question(per)); },
      [=](const std::string& text) { return take_full_scale(text, dimension, *input); });
  add(
      [=] {
        const bool needed = input->volts && !input->sensitivity;
        return asked_if(needed, sensitivity_question(dimension, unit, input->volts.value_or(0)));
      },
      [=](const std::string& text) -> Status {
        const auto found = quantity_in(text, volt() / dimension, "2 " + unit);
        if (!found) return tl::unexpected(found.error());
        input->sensitivity = *found;
        return {};
      });
}

void RigInterview::ask_output(const EntrySpec& port, std::size_t index) {
  auto* output = &rig_.outputs[index];
  const auto* kind = find(port.fields, "kind");
  const bool audio = kind != nullptr && kind->text() != nullptr && *kind->text() == "audio";
  add(
      [=, text = port.name + "'" + about(port), this] {
        int free = 1;
        while (used_by_output(free)) ++free;
        return RigQuestion{
            fmt::format("Which output of the card is '{}? {}; 1 to {}, or none", text,
                        audio ? "It is a monitor output" : "It drives an actuator", device_outputs_),
            free <= device_outputs_ ? std::to_string(free) : kNone};
      },
      [=, this](const std::string& text) { return take_channels(text, *output, device_outputs_, false); });
  if (audio) return;
  add([=, name = port.name] { return asked_if(!output->channels.empty(), profile_question(name)); },
      [=, this](const std::string& text) { return take_profile(text, *output); });
  // There is no cautious guess: too few volts would allow too much.
  const RigQuestion volts{"How many volts does a sample of 1 put on it, behind the amplifier? Such as 10 V",
                          ""};
  add([=] { return asked_if(output->has_actuator(), volts); },
      [=](const std::string& text) { return take_volts(text, 1e-3, "1 mV", "10 V", output->drive.volts); });
}

void RigInterview::ask_actuators() {
  const RigQuestion question{
      "Are actuators connected to other outputs, which must never carry sound? Their numbers, or none",
      kNone};
  add([=, this] { return asked_if(device_outputs_ > static_cast<int>(rig_.outputs.size()), question); },
      [this](const std::string& text) { return take_actuators(text); });
}

Status RigInterview::take_actuators(const std::string& text) {
  RigPort others;
  if (auto status = take_channels(text, others, device_outputs_, false); !status) return status;
  for (const int channel : others.channels) {
    auto& actuator = rig_.actuators.emplace_back();
    actuator.name = fmt::format("on_{}", channel);
    actuator.channels = {channel};
  }
  return {};
}

bool RigInterview::used_by_output(int channel) const {
  return std::any_of(rig_.outputs.begin(), rig_.outputs.end(), [channel](const RigOutput& output) {
    return std::find(output.channels.begin(), output.channels.end(), channel) != output.channels.end();
  });
}

Status RigInterview::take_channels(const std::string& text, RigPort& port, int there, bool shared) {
  if (text == kNone) return {};
  const auto numbers = numbers_in(text);
  if (!numbers || numbers->empty())
    return nonsense("'" + text + "' is no channel", "write a number, several for several lanes, or none");
  for (const int number : *numbers) {
    if (number < 1 || number > there)
      return nonsense(fmt::format("the card has no channel {}", number),
                      there > 0 ? fmt::format("it has 1 to {}", there) : "write none");
    if (!shared && used_by_output(number))
      return nonsense(fmt::format("channel {} is taken already", number), "choose another");
  }
  port.channels = *numbers;
  return {};
}

Status RigInterview::take_profile(const std::string& text, RigOutput& output) {
  if (text == "unknown" || text == kNone) return {};
  const auto file = find_profile(text, root_, "");
  if (!file) return tl::unexpected(file.error());
  const auto profile = load_profile(*file);
  if (!profile) return tl::unexpected(profile.error().front());
  output.drive.profile = text;
  return {};
}

Result<Rig> hold_interview(RigInterview& interview, std::istream& in, std::ostream& out, bool take_defaults) {
  while (const auto question = interview.question()) {
    std::string line;
    if (!take_defaults) {
      out << question->text << (question->on_enter.empty() ? "" : " [" + question->on_enter + "]") << ": "
          << std::flush;
      if (!std::getline(in, line))
        return fail(Errc::Missing, "--save-rig", "the input ended before all questions were answered",
                    "answer on a terminal, or take all defaults with --yes");
    }
    const auto status = interview.answer(line);
    if (status) continue;
    if (take_defaults) return tl::unexpected(status.error());
    out << "  " << to_string(status.error()) << "\n";
  }
  return interview.rig();
}

Status save_rig(const Rig& rig, const fs::path& file, std::istream& in, std::ostream& out, bool force) {
  std::error_code error;
  if (!force && fs::exists(file, error)) {
    out << "'" << file.string() << "' is there already. Overwrite it? [no]: " << std::flush;
    std::string line;
    std::getline(in, line);
    line = trimmed(line);
    if (line != "y" && line != "yes")
      return fail(Errc::BadFile, "--save-rig", "'" + file.string() + "' was left as it is",
                  "choose another name, answer yes, or say --force");
  }
  auto temporary = file;
  temporary += ".new";
  {
    std::ofstream text{temporary};
    text << to_text(rig);
    text.close();
    if (text) fs::rename(temporary, file, error);
    if (text && !error) return {};
  }
  std::error_code ignored;
  fs::remove(temporary, ignored);
  return fail(Errc::BadFile, file.string(), "cannot be written",
              "choose a folder that exists and can be written");
}

Status replace_rig(const Rig& rig, const fs::path& file) {
  std::error_code ignored;
  auto former = file;
  former += "~";
  fs::copy_file(file, former, fs::copy_options::overwrite_existing, ignored);
  std::istringstream nobody;
  std::ostringstream unheard;
  return save_rig(rig, file, nobody, unheard, true);
}

}  // namespace tactus::app
