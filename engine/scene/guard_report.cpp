#include "engine/scene/guard_report.h"

#include <fmt/format.h>

#include <array>

namespace tactus {
namespace {

struct StageWords {
  const char* name;
  const char* words;
};
constexpr std::array<StageWords, kGuardStages> kWords = {{
    {"nonfinite", "it was non-finite"},
    {"heat", "it was too warm, and held back"},
    {"direct", "direct current had lasted too long, and it was held back"},
    {"travel", "the travel limit held it back"},
    {"ceiling", "it lay above the ceiling"},
    {"slew", "it was too steep"},
}};

std::string event_in_words(const GuardReport& report, const GuardEvent& event, Hertz sample_rate) {
  const double at_s = static_cast<double>(event.frame) / sample_rate.value;
  const auto channel = static_cast<std::size_t>(event.channel);
  if (event.kind == GuardEvent::Kind::Feedback)
    return fmt::format(
        "{}: howl at {:.3f} s: the guard held it back for more than half of 200 ms and faded it; "
        "look for a loop that is too loud, and arm it again",
        report.outputs[channel].name, at_s);
  const bool railed = event.kind == GuardEvent::Kind::SensorRailed;
  const auto name = channel < report.input_names.size() ? report.input_names[channel]
                                                        : fmt::format("input {}", event.channel + 1);
  return fmt::format(
      "{}: the sensor {} at {:.3f} s, and all drives were faded; {}, and arm them again", name,
      railed ? "lay at the end of its range for 40 ms" : "repeated itself bit for bit for 40 ms", at_s,
      railed ? "look at its cable and its supply" : "look at its converter and its driver");
}

}  // namespace

bool GuardReport::idle() const {
  for (const auto& output : outputs)
    if (!(output.counts == GuardCounts{})) return false;
  return events.empty();
}

const char* name_of(GuardStage stage) { return kWords[static_cast<std::size_t>(stage)].name; }

const char* name_of(GuardEvent::Kind kind) {
  constexpr std::array kNames = {"howl", "sensor railed", "sensor stuck"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::vector<std::string> output_names(const Plan& schedule) {
  std::vector<std::string> names;
  for (const auto& channel : schedule.channels)
    if (channel.use != OutputUse::Tap) names.push_back(channel.name);
  return names;
}

std::vector<std::string> sound_names(const Plan& schedule) {
  std::vector<std::string> names, called_sound;
  for (const auto& channel : schedule.channels) {
    if (channel.use != OutputUse::Audio) continue;
    names.push_back(channel.name);
    // Lanes are called sound[1], sound[2], ...
    if (channel.name.substr(0, channel.name.find('[')) == "sound") called_sound.push_back(channel.name);
  }
  return called_sound.empty() ? names : called_sound;
}

std::vector<GuardedChannel> guarded_channels(const Plan& schedule, const DriveBook& drives) {
  std::vector<GuardedChannel> channels;
  for (const auto& channel : schedule.channels) {
    if (channel.use == OutputUse::Audio) channels.push_back({DriveGuard::Kind::Audio, {}});
    if (channel.use == OutputUse::Drive)
      channels.push_back({DriveGuard::Kind::Drive, drives.of(channel.name)});
  }
  return channels;
}

GuardReport report_of(Guarded& guarded, const std::vector<GuardedChannel>& channels,
                      std::vector<std::string> inputs, const std::vector<std::string>& outputs) {
  GuardReport report;
  report.input_names = std::move(inputs);
  for (std::size_t c = 0; c < outputs.size(); ++c) {
    const int index = static_cast<int>(c);
    GuardedOutput output{outputs[c], guarded.counts(index), guarded.thermal_state(index)};
    if (const auto& heat = channels[c].limits.heat) output.rise_kelvin = heat->rise_kelvin * output.heat.coil;
    report.outputs.push_back(std::move(output));
  }
  GuardEvent event;
  while (guarded.take_event(event)) report.events.push_back(event);
  return report;
}

GuardReport report_of(Guarded& guarded, const Plan& schedule, const DriveBook& drives) {
  return report_of(guarded, guarded_channels(schedule, drives), schedule.input_names, output_names(schedule));
}

std::vector<std::string> in_words(const GuardReport& report, Hertz sample_rate) {
  std::vector<std::string> lines;
  for (const auto& event : report.events) lines.push_back(event_in_words(report, event, sample_rate));
  for (const auto& output : report.outputs)
    for (std::size_t s = 0; s < kGuardStages; ++s) {
      const auto& count = output.counts.stages[s];
      if (count.frames == 0) continue;
      lines.push_back(fmt::format("{}: {} for {:.3g} s, by up to {:.2g} full scale", output.name,
                                  kWords[s].words, static_cast<double>(count.frames) / sample_rate.value,
                                  count.most));
    }
  return lines;
}

}  // namespace tactus
