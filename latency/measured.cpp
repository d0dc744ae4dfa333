#include "latency/measured.h"

#include <cstdlib>
#include <fstream>
#include <system_error>
#include <utility>

#include "backends/json_fields.h"
#include "engine/core/files.h"

namespace tactus {

template <class Io, Of<MeasuredDelay> T>
void fields(Io& io, T& delay) {
  io("input", delay.key.input);
  io("output", delay.key.output);
  io("sample_rate_hz", delay.key.sample_rate);
  io("block_frames", delay.key.block_frames);
  io("periods", delay.key.periods);
  io("delay_s", delay.delay);
  io("spread_s", delay.spread);
  io("when", delay.when);
}

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::vector<MeasuredDelay> parse(std::istream& text) {
  const auto json = Json::parse(text);
  if (json.at("format") != 1) throw std::runtime_error("another format");
  std::vector<MeasuredDelay> delays;
  JsonReader{json}("delays", delays);
  for (const auto& each : delays)
    if (!(each.delay.value >= 0 && each.delay.value < 60)) throw std::runtime_error("an impossible delay");
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
  return {Errc::BadFile, file.string(),
          "the delays measured on this computer cannot be read (" + reason + ")",
          error ? "move the file, and measure again"
                : "it was renamed to '" + aside.string() + "'; measure again, or repair that file"};
}

}  // namespace

DelayKey key_of(const StreamGranted& granted) {
  return {granted.input_device.empty() ? granted.device : granted.input_device, granted.device,
          granted.format.sample_rate, granted.block_frames, granted.periods};
}

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
  store.load_error_ = set_aside(file, reason);
  return store;
}

const MeasuredDelay* MeasuredDelays::newest(const std::function<bool(const DelayKey&)>& fits) const {
  const MeasuredDelay* newest = nullptr;
  for (const auto& delay : delays_)
    if (fits(delay.key) && (newest == nullptr || delay.when >= newest->when)) newest = &delay;
  return newest;
}

Status MeasuredDelays::save(MeasuredDelay delay) {
  if (file_.empty())
    return fail(Errc::BadFile, "", "there is no folder for measured delays", "set XDG_STATE_HOME");
  auto now = load(file_);  // another program may have written
  if (now.load_error_) load_error_ = now.load_error_;
  std::erase_if(now.delays_, [&](const MeasuredDelay& old) { return old.key == delay.key; });
  now.delays_.push_back(std::move(delay));
  delays_ = std::move(now.delays_);

  const Json json{{"format", 1}, {"delays", JsonWriter::written(delays_)}};
  std::error_code ignored;
  fs::create_directories(file_.parent_path(), ignored);
  auto status = replace_file(file_, json.dump(1) + "\n");
  if (!status) status.error().remedy = "make its folder writable, or choose another by XDG_STATE_HOME";
  return status;
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
