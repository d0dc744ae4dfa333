#include "latency/measured.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <system_error>
#include <utility>

namespace tactus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json json_of(const MeasuredDelay& delay) {
  const auto& key = delay.key;
  Json json{{"input", key.input},
            {"output", key.output},
            {"sample_rate_hz", key.sample_rate.value},
            {"block_frames", key.block_frames},
            {"periods", key.periods},
            {"delay_s", delay.delay.value}};
  if (delay.spread) json["spread_s"] = delay.spread->value;
  json["when"] = delay.when;
  return json;
}

MeasuredDelay delay_of(const Json& json) {
  MeasuredDelay delay;
  delay.key = {json.at("input").get<std::string>(), json.at("output").get<std::string>(),
               Hertz{json.at("sample_rate_hz").get<double>()}, json.at("block_frames").get<int>(),
               json.at("periods").get<int>()};
  delay.delay = Seconds{json.at("delay_s").get<double>()};
  if (json.contains("spread_s")) delay.spread = Seconds{json.at("spread_s").get<double>()};
  delay.when = json.at("when").get<std::string>();
  if (!(delay.delay.value >= 0 && delay.delay.value < 60)) throw std::runtime_error("a delay that cannot be");
  return delay;
}

std::vector<MeasuredDelay> parse(std::istream& text) {
  const auto json = Json::parse(text);
  if (json.at("format") != 1) throw std::runtime_error("another format");
  std::vector<MeasuredDelay> delays;
  for (const auto& entry : json.at("delays")) delays.push_back(delay_of(entry));
  return delays;
}

/// An unused name beside `file`.
fs::path free_name(const fs::path& file, const std::string& ending) {
  std::error_code ignored;
  for (int i = 1;; ++i) {
    auto name = file;
    name += ending + (i > 1 ? std::to_string(i) : "");
    if (!fs::exists(name, ignored)) return name;
  }
}

Error set_aside(const fs::path& file, const std::string& reason) {
  const auto aside = free_name(file, ".broken");
  std::error_code error;
  fs::rename(file, aside, error);
  return {Errc::BadFile, file.string(), "the delays measured here cannot be read (" + reason + ")",
          error ? "move the file away, and measure again"
                : "it was kept as '" + aside.string() + "'; measure again, or fix it"};
}

Status cannot_write(const fs::path& file) {
  return fail(Errc::BadFile, file.string(), "cannot be written",
              "make its folder writable, or choose another with XDG_STATE_HOME");
}

/// A name that no other program takes at the same time.
fs::path temporary_beside(const fs::path& file) {
  std::random_device random;
  auto name = file;
  name += ".new" + std::to_string(random());
  return name;
}

}  // namespace

MeasuredDelays MeasuredDelays::load(const fs::path& file) {
  MeasuredDelays store;
  store.file_ = file;
  std::error_code error;
  if (file.empty() || !fs::exists(file, error)) return store;
  std::string reason = "it cannot be opened";
  if (std::ifstream text{file}) {
    try {
      store.delays_ = parse(text);
      return store;
    } catch (const std::exception& exception) {
      reason = exception.what();
    }
  }
  store.complaint_ = set_aside(file, reason);
  return store;
}

const MeasuredDelay* MeasuredDelays::find(const DelayKey& key) const {
  const auto found = std::find_if(delays_.begin(), delays_.end(),
                                  [&](const MeasuredDelay& delay) { return delay.key == key; });
  return found == delays_.end() ? nullptr : &*found;
}

const MeasuredDelay* MeasuredDelays::newest(const std::string& input, const std::string& output) const {
  const MeasuredDelay* newest = nullptr;
  for (const auto& delay : delays_) {
    if (delay.key.input != input || delay.key.output != output) continue;
    if (newest == nullptr || delay.when >= newest->when) newest = &delay;
  }
  return newest;
}

Status MeasuredDelays::keep(MeasuredDelay delay) {
  if (file_.empty())
    return fail(Errc::BadFile, "", "there is no folder to keep what was measured", "set XDG_STATE_HOME");
  auto now = load(file_);  // another program may have written
  if (now.complaint_) complaint_ = now.complaint_;
  std::erase_if(now.delays_, [&](const MeasuredDelay& old) { return old.key == delay.key; });
  now.delays_.push_back(std::move(delay));
  delays_ = std::move(now.delays_);

  Json json{{"format", 1}, {"delays", Json::array()}};
  for (const auto& each : delays_) json["delays"].push_back(json_of(each));
  std::error_code error;
  fs::create_directories(file_.parent_path(), error);
  const auto temporary = temporary_beside(file_);
  {
    std::ofstream text{temporary};
    text << json.dump(1) << "\n";
    text.close();
    if (!text) return fs::remove(temporary, error), cannot_write(file_);
  }
  fs::rename(temporary, file_, error);
  if (!error) return {};
  std::error_code ignored;
  fs::remove(temporary, ignored);
  return cannot_write(file_);
}

fs::path MeasuredDelays::default_file() {
  const auto set = [](const char* name) {
    const char* value = std::getenv(name);
    return value != nullptr && *value != '\0' ? fs::path{value} : fs::path{};
  };
  auto folder = set("XDG_STATE_HOME");
  if (!folder.is_absolute()) folder.clear();  // the XDG specification: ignore it then
  if (folder.empty() && !set("HOME").empty()) folder = set("HOME") / ".local" / "state";
  if (folder.empty()) folder = set("LOCALAPPDATA");
  return folder.empty() ? fs::path{} : folder / "tactus" / "delays.json";
}

}  // namespace tactus
