#include "apps/play/live/controls/live_presets.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engine/core/files.h"
#include "engine/graph/file/error_list.h"

namespace tactus::app {
namespace {

template <class T>
bool done(const std::future<T>& future) {
  return future.valid() && future.wait_for(std::chrono::seconds{0}) != std::future_status::timeout;
}

}  // namespace

void LivePresets::list() {
  listing_ = std::async(std::launch::async, [folder = folder_] { return preset_names(folder); });
}

bool LivePresets::busy() {
  if (!working_.valid()) return false;
  messages_.emplace_back("the last preset is still being read or written");
  return true;
}

void LivePresets::recall(const std::string& name, Seconds ramp, std::vector<FlatControl> controls) {
  if (const auto status = check_preset_name(name); !status)
    return messages_.push_back(to_string(status.error()));
  if (busy()) return;
  if (std::error_code none; !std::filesystem::exists(file_of(name), none))
    return messages_.push_back(fmt::format("there is no preset '{}'; {}", name,
                                           names_.empty() ? "there are none" : "there is " + listed(names_)));
  working_ =
      std::async(std::launch::async, [file = file_of(name), name, ramp, controls = std::move(controls)] {
        auto preset = load_preset(file, controls);
        if (!preset) return Outcome{{}, {to_string(preset.error())}};
        Outcome outcome{Recalled{name, std::move(*preset), ramp}, {}};
        const auto& errors = outcome.recalled->preset.errors;
        if (!errors.empty()) outcome.messages = {to_string(errors) + "\nthe rest of the preset is applied"};
        return outcome;
      });
}

void LivePresets::save(const std::string& name, std::vector<FlatControl> controls) {
  if (const auto status = check_preset_name(name); !status)
    return messages_.push_back(to_string(status.error()));
  if (busy()) return;
  working_ = std::async(std::launch::async, [file = file_of(name), controls = std::move(controls)] {
    std::vector<PresetValue> values;
    for (const auto& control : controls) values.push_back({control.name, control.value});
    std::error_code error;
    std::filesystem::create_directories(file.parent_path(), error);
    const bool replaces = std::filesystem::exists(file, error);
    const auto written = replace_file_with_backup(file, to_text(values, controls));
    if (!written) return Outcome{{}, {to_string(written.error())}};
    return Outcome{{},
                   {"preset saved: " + file.string() +
                    (replaces ? "; the previous file is " + file.string() + "~" : "")}};
  });
}

std::string LivePresets::free_name() const {
  for (int number = 1;; ++number)
    if (auto name = fmt::format("preset {}", number); !std::ranges::binary_search(names_, name)) return name;
}

std::optional<LivePresets::Recalled> LivePresets::tick() {
  if (done(listing_)) {
    auto names = listing_.get();
    if (names != names_) ++version_;
    names_ = std::move(names);
  }
  if (!done(working_)) return std::nullopt;
  auto outcome = working_.get();
  for (auto& message : outcome.messages) messages_.push_back(std::move(message));
  list();
  if (outcome.recalled) messages_.push_back("preset " + outcome.recalled->name);
  return std::move(outcome.recalled);
}

}  // namespace tactus::app
