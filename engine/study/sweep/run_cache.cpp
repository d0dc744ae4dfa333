#include "engine/study/sweep/run_cache.h"

#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <system_error>

namespace tactus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string name_of(std::uint64_t key) { return fmt::format("{:016x}", key); }

Error cannot_write(const fs::path& path) {
  return {Errc::BadFile, path.string(), "the run cannot be written", "choose another folder for --keep"};
}

bool ends_incomplete(const fs::path& path) {
  std::ifstream file{path, std::ios::binary | std::ios::ate};
  if (!file || file.tellg() <= 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

}  // namespace

Result<RunCache> RunCache::open(const fs::path& folder, const std::string& file) {
  RunCache cache;
  std::error_code error;
  fs::create_directories(folder, error);
  for (const auto& entry : fs::directory_iterator{folder, error})
    if (entry.path().extension() == ".jsonl") cache.read(entry.path());
  cache.path_ = folder / file;
  const bool incomplete = ends_incomplete(cache.path_);
  cache.out_.open(cache.path_, std::ios::binary | std::ios::app);
  if (incomplete) cache.out_ << "\n" << std::flush;
  if (!cache.out_) return tl::unexpected(cannot_write(cache.path_));
  return cache;
}

void RunCache::read(const fs::path& file) {
  std::ifstream text{file, std::ios::binary};
  for (std::string line; std::getline(text, line);) {
    const auto json = Json::parse(line, nullptr, false);
    if (!json.is_object() || !json.contains("key") || !json["key"].is_string() || !json.contains("run") ||
        !json["run"].is_array())
      continue;
    auto& run = runs_[json["key"].get<std::string>()];
    run.clear();
    for (const auto& value : json["run"])
      run.push_back(value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN());
  }
}

std::optional<std::vector<double>> RunCache::find(std::uint64_t key) const {
  const auto found = runs_.find(name_of(key));
  return found == runs_.end() ? std::nullopt : std::optional{found->second};
}

Status RunCache::keep(std::uint64_t key, const std::vector<double>& run) {
  if (path_.empty()) return {};
  // Non-finite numbers become null.
  const auto line = Json{{"key", name_of(key)}, {"run", run}}.dump() + "\n";
  const std::lock_guard lock{*writing_};
  out_ << line << std::flush;
  return out_ ? Status{} : tl::unexpected(cannot_write(path_));
}

}  // namespace tactus
