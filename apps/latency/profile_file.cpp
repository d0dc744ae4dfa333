#include "apps/latency/profile_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/play_report.h"

namespace tactus::app {
namespace {

using Json = nlohmann::ordered_json;

PathProfile profile_of(const Json& json) {
  if (json.at("format") != 1) throw std::runtime_error("another format");
  PathProfile profile;
  profile.sample_rate = Hertz{json.at("sample_rate_hz").get<double>()};
  profile.low = Hertz{json.at("low_hz").get<double>()};
  profile.high = Hertz{json.at("high_hz").get<double>()};
  profile.taps = json.at("taps").get<std::vector<double>>();
  const bool sound =
      std::all_of(profile.taps.begin(), profile.taps.end(), [](double tap) { return std::isfinite(tap); });
  if (profile.taps.empty() || !sound || !(profile.sample_rate >= 1_kHz) || !(profile.low < profile.high))
    throw std::runtime_error("figures that cannot be");
  return profile;
}

}  // namespace

Status write_profile(const std::string& file, const PathProfile& profile) {
  return write_json(file, {{"format", 1},
                           {"sample_rate_hz", profile.sample_rate.value},
                           {"low_hz", profile.low.value},
                           {"high_hz", profile.high.value},
                           {"taps", profile.taps}});
}

Result<PathProfile> read_profile(const std::string& file, Hertz sample_rate) {
  std::ifstream text{file};
  if (!text) return fail(Errc::BadFile, file, "there is no such file", "tactus latency calibrate writes one");
  try {
    auto profile = profile_of(Json::parse(text));
    if (profile.sample_rate == sample_rate) return profile;
    return fail(Errc::BadFile, file,
                fmt::format("it is for {:g} Hz, and this is at {:g} Hz", profile.sample_rate.value,
                            sample_rate.value),
                "calibrate again at this rate");
  } catch (const std::exception& exception) {
    return fail(Errc::BadFile, file, std::string{"this is no profile of a path ("} + exception.what() + ")",
                "tactus latency calibrate writes one");
  }
}

}  // namespace tactus::app
