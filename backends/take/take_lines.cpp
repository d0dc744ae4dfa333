#include "backends/take/take_lines.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>

namespace tactus {
namespace {

using Json = nlohmann::ordered_json;
using Kind = JournalEntry::Kind;

constexpr int kVersion = 2;  // 1: without fades
constexpr std::array kKinds = {"control",   "arm",       "mute",        "system_delay", "lost_frames",
                               "coil_heat", "body_heat", "replacement", "halt",         "fade"};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string line_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// JSON has no infinity, and writes null.
double number_of(const Json& json) { return json.is_null() ? kInfinity : json.get<double>(); }

// ---- what Guarded was made with

Json json_of(const DriveLimits& limits) {
  Json json{{"ceiling", limits.ceiling},
            {"slew_per_second", limits.slew_per_second},
            {"soft_start_s", limits.soft_start.value},
            {"fade_out_s", limits.fade_out.value},
            {"direct", {{"level", limits.dc.level}, {"time_s", limits.dc.time.value}}}};
  if (const auto& heat = limits.heat)
    json["heat"] = {{"watts_at_full_scale", heat->watts_at_full_scale},
                    {"watts_for_ever", heat->watts_for_ever},
                    {"coil_time_s", heat->coil_time.value},
                    {"body_time_s", heat->body_time.value},
                    {"coil_share", heat->coil_share},
                    {"rise_kelvin", heat->rise_kelvin}};
  if (const auto& travel = limits.excursion)
    json["travel"] = {{"metres", travel->metres},
                      {"metres_at_full_scale", travel->metres_at_full_scale},
                      {"resonance_hz", travel->resonance.value},
                      {"q", travel->q}};
  return json;
}

DriveLimits limits_of(const Json& json) {
  DriveLimits limits;
  limits.ceiling = number_of(json.at("ceiling"));
  limits.slew_per_second = number_of(json.at("slew_per_second"));
  limits.soft_start = Seconds{number_of(json.at("soft_start_s"))};
  limits.fade_out = Seconds{number_of(json.at("fade_out_s"))};
  const auto& direct = json.at("direct");
  limits.dc = {number_of(direct.at("level")), Seconds{number_of(direct.at("time_s"))}};
  if (const auto heat = json.find("heat"); heat != json.end())
    limits.heat = {number_of(heat->at("watts_at_full_scale")),  number_of(heat->at("watts_for_ever")),
                   Seconds{number_of(heat->at("coil_time_s"))}, Seconds{number_of(heat->at("body_time_s"))},
                   number_of(heat->at("coil_share")),           number_of(heat->at("rise_kelvin"))};
  if (const auto travel = json.find("travel"); travel != json.end())
    limits.excursion = {number_of(travel->at("metres")), number_of(travel->at("metres_at_full_scale")),
                        Hertz{number_of(travel->at("resonance_hz"))}, number_of(travel->at("q"))};
  return limits;
}

Json json_of(const std::vector<GuardedChannel>& channels) {
  auto json = Json::array();
  for (const auto& channel : channels) {
    auto one = json_of(channel.limits);
    one["kind"] = channel.kind == DriveGuard::Kind::Audio ? "audio" : "drive";
    json.push_back(std::move(one));
  }
  return json;
}

std::vector<GuardedChannel> channels_of(const Json& json) {
  std::vector<GuardedChannel> channels;
  for (const auto& one : json)
    channels.push_back(
        {one.at("kind") == "audio" ? DriveGuard::Kind::Audio : DriveGuard::Kind::Drive, limits_of(one)});
  return channels;
}

// ---- entries and files

Json json_of(const JournalEntry& entry) {
  return {{"frame", entry.frame},
          {"kind", kKinds[static_cast<std::size_t>(entry.kind)]},
          {"index", entry.index},
          {"value", entry.value}};
}

bool known_kind(const Json& json) {
  return std::find(kKinds.begin(), kKinds.end(), json.at("kind").get<std::string>()) != kKinds.end();
}

JournalEntry entry_of(const Json& json) {
  const auto kind = std::find(kKinds.begin(), kKinds.end(), json.at("kind").get<std::string>());
  return {json.at("frame"), static_cast<Kind>(kind - kKinds.begin()), json.at("index"),
          number_of(json.at("value"))};
}

Json json_of(const TakeFiles& files) {
  return {{"main", files.main}, {"root", files.root}, {"texts", files.texts}, {"sounds", files.sounds}};
}

TakeFiles files_of(const Json& json) {
  return {json.at("main"), json.at("texts").get<std::map<std::string, std::string>>(),
          json.at("sounds").get<std::map<std::string, std::string>>(), json.at("root")};
}

Json json_of_progress(const Take& take, const char* kind) {
  return {{"frame", take.complete},
          {"kind", kind},
          {"lost_entries", take.lost_entries},
          {"rounded_sensors", take.rounded_sensors}};
}

bool of_the_engine(Kind kind) {
  return kind == Kind::ControlChange || kind == Kind::SystemDelay || kind == Kind::LostFrames;
}

TakeHeader header_of(const Json& json) {
  TakeHeader header;
  header.program = json.at("program");
  header.sample_rate = Hertz{number_of(json.at("sample_rate_hz"))};
  header.inputs = json.at("inputs").get<std::vector<std::string>>();
  header.outputs = json.at("outputs").get<std::vector<std::string>>();
  header.controls = json.at("controls").get<std::vector<std::string>>();
  header.settings = json.at("settings").get<std::map<std::string, double>>();
  header.taps = json.at("taps").get<std::vector<std::string>>();
  header.system_delay = Seconds{number_of(json.at("system_delay_s"))};
  header.armed = json.at("armed");
  header.soft_start = json.at("soft_start");
  header.trusted_sensors = json.at("trusted_sensors");
  for (const auto& entry : json.at("state")) header.state.push_back(entry_of(entry));
  header.guard = channels_of(json.at("guard"));
  header.rig = json.at("rig");
  header.left_out = json.at("left_out").get<std::vector<std::string>>();
  for (const auto& scale : json.at("input_scales")) header.input_scales.push_back(number_of(scale));
  header.padding_frames = json.at("padding_frames");
  header.files = files_of(json.at("files"));
  return header;
}

void add_line(const Json& json, Take& take) {
  const std::string kind = json.at("kind");
  if (kind == "complete" || kind == "end") {
    take.complete = json.at("frame");
    take.lost_entries = json.at("lost_entries");
    take.rounded_sensors = json.at("rounded_sensors");
    take.finished = kind == "end";
    take.ended = take.finished ? json.at("why").get<std::string>() : "";
  } else if (kind == "gap") {
    take.gaps.push_back({json.at("frame"), json.at("frames")});
  } else if (kind == "edit") {
    take.edits.push_back({json.at("frame"), files_of(json.at("files")),
                          json.at("settings").get<std::map<std::string, double>>(),
                          json.at("controls").get<std::vector<std::string>>()});
  } else if (known_kind(json)) {
    const auto entry = entry_of(json);
    (of_the_engine(entry.kind) ? take.engine : take.guard).push_back(entry);
  } else {
    throw std::invalid_argument("a line of a later version");
  }
}

}  // namespace

std::string header_line(const TakeHeader& header) {
  auto state = Json::array();
  for (const auto& entry : header.state) state.push_back(json_of(entry));
  return line_of({{"tactus_take", kVersion},
                  {"program", header.program},
                  {"sample_rate_hz", header.sample_rate.value},
                  {"inputs", header.inputs},
                  {"outputs", header.outputs},
                  {"controls", header.controls},
                  {"settings", header.settings},
                  {"taps", header.taps},
                  {"system_delay_s", header.system_delay.value},
                  {"armed", header.armed},
                  {"soft_start", header.soft_start},
                  {"trusted_sensors", header.trusted_sensors},
                  {"state", std::move(state)},
                  {"guard", json_of(header.guard)},
                  {"rig", header.rig},
                  {"left_out", header.left_out},
                  {"input_scales", header.input_scales},
                  {"padding_frames", header.padding_frames},
                  {"files", json_of(header.files)}});
}

std::string entry_line(const JournalEntry& entry) { return line_of(json_of(entry)); }

std::string gap_line(const TakeGap& gap) {
  return line_of({{"frame", gap.frame}, {"kind", "gap"}, {"frames", gap.frames}});
}

std::string edit_line(const TakeEdit& edit) {
  return line_of({{"frame", edit.frame},
                  {"kind", "edit"},
                  {"settings", edit.settings},
                  {"controls", edit.controls},
                  {"files", json_of(edit.files)}});
}

std::string complete_line(const Take& take) { return line_of(json_of_progress(take, "complete")); }

std::string end_line(const Take& take) {
  auto json = json_of_progress(take, "end");
  json["why"] = take.ended;
  return line_of(json);
}

Result<TakeHeader> parse_header(const std::string& line) {
  const auto no_take = [](const std::string& what) {
    return fail(Errc::BadFile, "", what, "give the .jsonl that was recorded with the WAV file");
  };
  try {
    const auto json = Json::parse(line);
    if (const int version = json.at("tactus_take"); version < 1 || version > kVersion)
      return fail(Errc::BadFile, "", "a later version of the program recorded this take",
                  "replay it with that version");
    return header_of(json);
  } catch (const Json::parse_error&) {
    return no_take("its first line is no JSON");
  } catch (const Json::exception&) {
    return no_take("its first line is not that of a take");
  }
}

bool parse_line(const std::string& line, Take& take) {
  try {
    add_line(Json::parse(line), take);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace tactus
