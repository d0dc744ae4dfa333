#include "backends/take/take.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <fstream>
#include <system_error>
#include <tuple>

#include "backends/json_fields.h"

namespace tactus {

namespace fs = std::filesystem;
namespace {
using Kind = JournalEntry::Kind;
}

// 1: without fades; 2: without control_set, dead_man, dc_time, sensor_noise and feedback_path;
// 3: without displacement
constexpr int kTakeVersion = 4, kLastWithoutPaths = 2;
constexpr std::array kKinds = {"control",     "arm",          "mute",          "system_delay",
                               "lost_frames", "coil_heat",    "body_heat",     "replacement",
                               "halt",        "fade",         "control_set",   "dead_man",
                               "dc_time",     "sensor_noise", "feedback_path", "displacement"};
constexpr std::array kDriveKinds = {"drive", "audio"};

// The keys of each line, for both directions; docs/takes.md describes them.

template <class Io, Of<DcLimits> T>
void fields(Io& io, T& dc) {
  io("level", dc.level);
  io("time_s", dc.time);
}

template <class Io, Of<HeatLimits> T>
void fields(Io& io, T& heat) {
  io("watts_at_full_scale", heat.watts_at_full_scale);
  io("watts_for_ever", heat.watts_for_ever);
  io("coil_time_s", heat.coil_time);
  io("body_time_s", heat.body_time);
  io("coil_share", heat.coil_share);
  io("rise_kelvin", heat.rise_kelvin);
}

template <class Io, Of<ExcursionLimits> T>
void fields(Io& io, T& excursion) {
  io("metres", excursion.metres);
  io("metres_at_full_scale", excursion.metres_at_full_scale);
  io("resonance_hz", excursion.resonance);
  io("q", excursion.q);
}

template <class Io, Of<LimitOrigin> T>
void fields(Io& io, T& origin) {
  io("limit", origin.limit);
  io("value", origin.value);
  io("source", origin.source);
  io("raised_from", origin.raised_from);
}

template <class Io, Of<FeedbackPath> T>
void fields(Io& io, T& path) {
  io("from_input", path.from_input);
  io("internal_loop", path.internal_loop);
}

template <class Io, Of<GuardedChannel> T>
void fields(Io& io, T& channel) {
  auto& limits = channel.limits;
  io("ceiling", limits.ceiling);
  io("slew_per_second", limits.slew_per_second);
  io("soft_start_s", limits.soft_start);
  io("fade_out_s", limits.fade_out);
  io("direct", limits.dc);
  io("heat", limits.heat);
  io("travel", limits.excursion);
  io.name("kind", channel.kind, kDriveKinds);
  io.later("origins", channel.origins);
  if constexpr (!std::is_const_v<T>) channel.feedback = {false, false};  // where the key is missing
  io.later("feedback", channel.feedback);
}

template <class Io, Of<JournalEntry> T>
void fields(Io& io, T& entry) {
  io("frame", entry.frame);
  io.name("kind", entry.kind, kKinds);
  io("index", entry.index);
  io("value", entry.value);
}

template <class Io, Of<TakeFiles> T>
void fields(Io& io, T& files) {
  io("main", files.main);
  io("root", files.root);
  io("texts", files.texts);
  io("sounds", files.sounds);
}

template <class Io, Of<TakeHeader> T>
void fields(Io& io, T& header) {
  io.constant("tactus_take", kTakeVersion);
  io("program", header.program);
  io("sample_rate_hz", header.sample_rate);
  io("inputs", header.inputs);
  io("outputs", header.outputs);
  io("controls", header.controls);
  io("settings", header.settings);
  io("taps", header.taps);
  io("system_delay_s", header.system_delay);
  io("armed", header.armed);
  io("soft_start", header.soft_start);
  io("trusted_sensors", header.trusted_sensors);
  io("state", header.state);
  io("guard", header.guard);
  io("rig", header.rig);
  io("left_out", header.left_out);
  io("input_scales", header.input_scales);
  io("padding_frames", header.padding_frames);
  io("files", header.files);
}

template <class Io, Of<TakeGap> T>
void fields(Io& io, T& gap) {
  io("frame", gap.frame);
  io.constant("kind", "gap");
  io("frames", gap.frames);
}

template <class Io, Of<TakeEdit> T>
void fields(Io& io, T& edit) {
  io("frame", edit.frame);
  io.constant("kind", "edit");
  io("settings", edit.settings);
  io("controls", edit.controls);
  io("files", edit.files);
}

template <class Io, Of<Take> T>
void fields(Io& io, T& take) {
  io("frame", take.complete);
  io.constant("kind", take.finished ? "end" : "complete");
  io("lost_entries", take.lost_entries);
  io("rounded_sensors", take.rounded_sensors);
  if (take.finished) io("why", take.ended);
}

namespace {

/// Errors: BadFile, with the key, for a number that no recording has.
Status check_numbers(const TakeHeader& header, const fs::path& path) {
  constexpr double kLongest_s = 10;  // of a delay
  const double rate = header.sample_rate.value;
  const auto longest_padding = std::floor(kLongest_s * rate);
  for (const auto& [key, value, least, most] :
       {std::tuple{"sample_rate_hz", rate, 1e3, 768e3},
        {"system_delay_s", header.system_delay.value, 0.0, 2 * kLongest_s},
        {"padding_frames", static_cast<double>(header.padding_frames), 0.0, longest_padding}})
    if (!(value >= least && value <= most))
      return fail(Errc::BadFile, path.string() + ":1",
                  fmt::format("'{}' cannot be {}: it runs from {} to {}", key, value, least, most),
                  "restore the file from a copy");
  return {};
}

Result<TakeHeader> parse_header(const std::string& line, const fs::path& path) {
  const auto no_take = [&](const std::string& what) {
    return fail(Errc::BadFile, path.string(), what, "give the .jsonl that was recorded with the WAV file");
  };
  try {
    const auto json = nlohmann::ordered_json::parse(line);
    const int version = json.at("tactus_take");
    if (version < 1 || version > kTakeVersion)
      return fail(Errc::BadFile, path.string(), "a later version of the program recorded this take",
                  "replay it with that version");
    TakeHeader header;
    JsonReader::read(json, header);
    if (version <= kLastWithoutPaths)
      for (auto& channel : header.guard)
        channel.feedback.limiting_counts = channel.kind == DriveGuard::Kind::Drive;
    return header;
  } catch (const nlohmann::ordered_json::parse_error&) {
    return no_take("its first line is not JSON");
  } catch (const JsonKeyError& error) {
    return no_take(std::string{"its first line is not the header of a take: "} + error.what());
  } catch (const std::exception&) {
    return no_take("its first line is not the header of a take");
  }
}

bool is_of_engine(Kind kind) {
  return kind == Kind::ControlChange || kind == Kind::ControlSet || kind == Kind::SystemDelay ||
         kind == Kind::LostFrames;
}

/// Adds the content of a line. False: it is no line of a journal.
bool add_line(const std::string& line, Take& take) {
  try {
    const auto json = nlohmann::ordered_json::parse(line);
    const std::string kind = json.at("kind");
    if (kind == "complete" || kind == "end") {
      take.finished = kind == "end";
      JsonReader::read(json, take);
    } else if (kind == "gap") {
      JsonReader::read(json, take.gaps.emplace_back());
    } else if (kind == "edit") {
      JsonReader::read(json, take.edits.emplace_back());
    } else {
      JournalEntry entry;
      JsonReader::read(json, entry);
      (is_of_engine(entry.kind) ? take.engine : take.guard).push_back(entry);
    }
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

template <class T>
std::string journal_line(const T& value) {
  const auto json = JsonWriter::written(value);
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}
template std::string journal_line(const TakeHeader&);
template std::string journal_line(const JournalEntry&);
template std::string journal_line(const TakeGap&);
template std::string journal_line(const TakeEdit&);
template std::string journal_line(const Take&);

fs::path journal_path(const fs::path& wav) { return fs::path{wav}.replace_extension(".jsonl"); }

Result<Take> read_take(const fs::path& wav) {
  const auto path = journal_path(wav);
  std::error_code ignored;
  if (!fs::is_regular_file(wav, ignored))
    return fail(Errc::BadFile, wav.string(), "there is no such file", "check the path");
  if (!fs::is_regular_file(path, ignored))
    return fail(Errc::BadFile, wav.string(),
                fmt::format("'{}' is missing in the same folder, so the recorded graph is unknown",
                            path.filename().string()),
                "use --in for a WAV file with only sensor signals");
  std::ifstream file{path, std::ios::binary};
  std::string line;
  if (!std::getline(file, line))
    return fail(Errc::BadFile, path.string(), "it is empty", "the take was cut off before its first frame");
  auto header = parse_header(line, path);
  if (!header) return tl::unexpected(header.error());
  if (const auto status = check_numbers(*header, path); !status) return tl::unexpected(status.error());
  Take take;
  take.header = std::move(*header);
  for (int number = 2; std::getline(file, line); ++number) {
    const bool whole = !file.eof();
    if (add_line(line, take)) continue;
    if (!whole || file.peek() == std::ifstream::traits_type::eof()) break;  // cut off here
    return fail(Errc::BadFile, fmt::format("{}:{}", path.string(), number),
                "this line is not valid in a take", "restore the file from a copy");
  }
  return take;
}

std::string why_not_exact(const Take& take) {
  if (take.lost_entries > 0)
    return fmt::format("{} control changes or guard events could not be recorded", take.lost_entries);
  if (!take.gaps.empty()) {
    const auto first_s = static_cast<double>(take.gaps.front().frame) / take.header.sample_rate.value;
    if (take.gaps.size() == 1) return fmt::format("frames are missing at {:.3f} s", first_s);
    return fmt::format("frames are missing at {} places, first at {:.3f} s", take.gaps.size(), first_s);
  }
  if (take.rounded_sensors > 0)
    return fmt::format("{} sensor samples have more digits than a float WAV file can store",
                       take.rounded_sensors);
  return {};
}

}  // namespace tactus
