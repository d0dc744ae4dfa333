#include "engine/scene/guard_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engine/core/named.h"
#include "engine/core/port_name.h"

namespace tactus {
namespace {

struct NamedText {
  const char* name;
  const char* text;  ///< of an event; "{}" is its time
};
struct StageText : NamedText {
  const char* limit;   ///< for --raise-limit; empty: there is none
  const char* remedy;  ///< if there is none
};
constexpr std::array<StageText, kGuardStages> kStages = {{
    {{"nonfinite", "non-finite values were replaced"}, "", "find the node that produces them"},
    {{"heat", "the heat limit attenuated it"}, "power", ""},
    {{"direct", "the DC limit attenuated it"}, "direct_level", ""},
    {{"travel", "the excursion limit attenuated it"}, "travel", ""},
    {{"ceiling", "the ceiling clipped it"}, "ceiling", ""},
    {{"slew", "the slew rate limit smoothed it"}, "slew", ""},
    {{"feedback", "the feedback test silenced or lowered it"}, "", "lower its level"},
}};

constexpr std::array<NamedText, 5> kEvents = {{
    {"howl",
     "feedback at {:.3f} s: this output returned to itself, through a sensor or a loop of the instrument, "
     "and grew, so it was faded out; lower the loop gain, and arm it again"},
    {"sensor railed",
     "the sensor was at the limit of its range for 40 ms at {:.3f} s, and all drives were faded out; check "
     "its cable and power supply, and arm the drives again"},
    {"sensor stuck",
     "the sensor repeated the same value for 40 ms at {:.3f} s, and all drives were faded out; check its "
     "converter and driver, and arm the drives again"},
    {"stop inputs blocked",
     "keys and signals were not handled for 500 ms at {:.3f} s, and every output was faded out; it starts "
     "again softly when they are handled; close other programs if the computer is overloaded"},
    {"stop inputs blocked for 5 s",
     "keys and signals were not handled for 5 s at {:.3f} s, and all drives were disarmed; arm them again"},
}};

/// Nothing where the signal grew by feedback: no limit is high enough for that.
std::string remedy_of(const GuardedOutput& output, std::size_t stage, bool fed_back) {
  const std::string limit = kStages[stage].limit;
  if (fed_back) return "";
  if (limit.empty()) return std::string{"; "} + kStages[stage].remedy;
  const auto origin = std::ranges::find(output.limits, limit, &LimitOrigin::limit);
  if (origin == output.limits.end()) return "; lower its level";
  const char* warm = stage == GuardStage::Heat
                         ? "; at the start the actuator is taken to be warm, and is allowed more as it cools"
                         : "";
  return fmt::format("{}; the limit is from {}; --raise-limit {}.{}=… would allow more", warm, origin->source,
                     output.name, limit);
}

bool fed_back(const GuardReport& report, std::size_t output) {
  return std::ranges::any_of(report.events, [=](const GuardEvent& event) {
    return event.kind == GuardEvent::Kind::Feedback && index(event.channel) == output;
  });
}

std::string count_text(const GuardReport& report, std::size_t output, std::size_t stage, Hertz sample_rate) {
  const auto& of = report.outputs[output];
  const auto& count = of.counts[stage];
  return fmt::format("{}: {} for {:.3g} s, by up to {:.2g} full scale{}", of.name, kStages[stage].text,
                     static_cast<double>(count.frames) / sample_rate.value, count.most,
                     remedy_of(of, stage, fed_back(report, output)));
}

/// What an event is about.
std::string subject_of(const GuardReport& report, const GuardEvent& event) {
  using Kind = GuardEvent::Kind;
  const auto channel = static_cast<std::size_t>(event.channel);
  if (event.kind == Kind::DeadMan || event.kind == Kind::DeadManDisarmed) return "dead man's switch";
  if (event.kind == Kind::Feedback) return report.outputs[channel].name;
  return channel < report.input_names.size() ? report.input_names[channel]
                                             : fmt::format("input {}", channel + 1);
}

std::string describe(const GuardReport& report, const GuardEvent& event, Hertz sample_rate) {
  return subject_of(report, event) + ": " +
         fmt::format(fmt::runtime(kEvents[static_cast<std::size_t>(event.kind)].text),
                     static_cast<double>(event.frame) / sample_rate.value);
}

/// "ceiling 0.8 of [outputs] woofer"
std::string limits_of(const std::string& source, const std::vector<LimitOrigin>& origins) {
  std::vector<std::string> limits;
  for (const auto& limit : origins)
    if (limit.source == source)
      limits.push_back(limit.limit + " " + limit_text(limit.limit, limit.value) +
                       (limit.raised_from ? " (raised)" : ""));
  return fmt::format("{} of {}", fmt::join(limits, ", "), source);
}

}  // namespace

bool GuardReport::idle() const {
  return events.empty() && std::ranges::all_of(outputs, [](const GuardedOutput& output) {
           return output.counts == GuardCounts{};
         });
}

bool GuardReport::any_raised() const {
  const auto is_raised = [](const LimitOrigin& limit) { return limit.raised_from.has_value(); };
  return std::ranges::any_of(
      outputs, [&](const GuardedOutput& output) { return std::ranges::any_of(output.limits, is_raised); });
}

const char* name_of(GuardStage::Index stage) { return kStages[stage].name; }

const char* name_of(GuardEvent::Kind kind) { return kEvents[static_cast<std::size_t>(kind)].name; }

std::vector<LimitedOutput> limited_outputs(const Plan& schedule) {
  std::vector<LimitedOutput> outputs;
  for (const auto& channel : schedule.channels)
    if (channel.use != OutputUse::Tap) outputs.push_back({channel.name, channel.use});
  return outputs;
}

std::vector<std::string> output_names(const Plan& schedule) { return names_of(limited_outputs(schedule)); }

std::vector<std::string> sound_names(const Plan& schedule, const std::vector<Role>& roles) {
  constexpr std::string_view kRole = "monitor", kPrefix = "instrument.";
  const auto signal = signal_of(roles, kRole);
  const auto monitor =
      signal.starts_with(kPrefix) ? signal.substr(kPrefix.size()) : find_named(role_types(), kRole)->port;
  std::vector<std::string> names, monitors;
  for (const auto& channel : schedule.channels) {
    if (channel.use != OutputUse::Audio) continue;
    names.push_back(channel.name);
    // Lanes are called name[1], name[2], ...
    if (port_of(channel.name) == monitor) monitors.push_back(channel.name);
  }
  return monitors.empty() ? names : monitors;
}

std::vector<GuardedChannel> guarded_channels(const Plan& schedule, const LimitBook& limits) {
  std::vector<GuardedChannel> channels;
  for (const auto& channel : schedule.channels) {
    if (channel.use == OutputUse::Tap) continue;
    channels.push_back(limits.of({channel.name, channel.use}));
    channels.back().feedback = {channel.from_input, channel.from_loop};
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
    output.limits = channels[c].origins;
    if (const auto& heat = channels[c].limits.heat) output.rise_kelvin = heat->rise_kelvin * output.heat.coil;
    report.outputs.push_back(std::move(output));
  }
  GuardEvent event;
  while (guarded.take_event(event)) report.events.push_back(event);
  return report;
}

GuardReport report_of(Guarded& guarded, const Plan& schedule, const LimitBook& limits) {
  return report_of(guarded, guarded_channels(schedule, limits), schedule.input_names, output_names(schedule));
}

std::vector<std::string> describe_limits(const std::vector<std::string>& outputs,
                                         const std::vector<GuardedChannel>& channels) {
  std::vector<std::string> lines;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    std::vector<std::string> sources, parts;
    for (const auto& limit : channels[c].origins)
      if (std::ranges::find(sources, limit.source) == sources.end()) sources.push_back(limit.source);
    for (const auto& source : sources) parts.push_back(limits_of(source, channels[c].origins));
    lines.push_back(fmt::format("{}: {}", outputs[c], fmt::join(parts, "; ")));
  }
  return lines;
}

std::vector<std::string> describe_raises(const std::string& output, const std::vector<LimitOrigin>& limits) {
  std::vector<std::string> lines;
  for (const auto& limit : limits)
    if (limit.raised_from)
      lines.push_back(fmt::format("{}: the limit '{}' is raised from {} ({}) to {}", output, limit.limit,
                                  limit_text(limit.limit, *limit.raised_from), limit.source,
                                  limit_text(limit.limit, limit.value)));
  return lines;
}

std::vector<std::string> describe(const GuardReport& report, Hertz sample_rate) {
  std::vector<std::string> lines;
  for (const auto& event : report.events) lines.push_back(describe(report, event, sample_rate));
  for (std::size_t c = 0; c < report.outputs.size(); ++c)
    for (std::size_t s = 0; s < kGuardStages; ++s)
      if (report.outputs[c].counts[s].frames > 0) lines.push_back(count_text(report, c, s, sample_rate));
  return lines;
}

}  // namespace tactus
