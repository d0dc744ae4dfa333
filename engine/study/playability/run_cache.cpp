#include "engine/study/playability/run_cache.h"

#include <fmt/format.h>

#include <system_error>

namespace tactus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string name_of(std::uint64_t key) { return fmt::format("{:016x}", key); }

Error cannot_write(const fs::path& path) {
  return {Errc::BadFile, path.string(), "the run cannot be kept there", "choose another folder for --keep"};
}

bool ends_torn(const fs::path& path) {
  std::ifstream file{path, std::ios::binary | std::ios::ate};
  if (!file || file.tellg() <= 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

}  // namespace

Result<KeptRuns> KeptRuns::open(const fs::path& folder, const std::string& file) {
  KeptRuns kept;
  std::error_code error;
  fs::create_directories(folder, error);
  for (const auto& entry : fs::directory_iterator{folder, error})
    if (entry.path().extension() == ".jsonl") kept.read(entry.path());
  kept.path_ = folder / file;
  const bool torn = ends_torn(kept.path_);
  kept.out_.open(kept.path_, std::ios::binary | std::ios::app);
  if (torn) kept.out_ << "\n" << std::flush;
  if (!kept.out_) return tl::unexpected(cannot_write(kept.path_));
  return kept;
}

void KeptRuns::read(const fs::path& file) {
  std::ifstream text{file, std::ios::binary};
  for (std::string line; std::getline(text, line);) {
    const auto json = Json::parse(line, nullptr, false);
    if (json.is_object() && json.contains("run") && json.contains("key") && json["key"].is_string())
      runs_[json["key"].get<std::string>()] = json["run"];
  }
}

const Json* KeptRuns::find(std::uint64_t key) const {
  const auto found = runs_.find(name_of(key));
  return found == runs_.end() ? nullptr : &found->second;
}

Status KeptRuns::keep(std::uint64_t key, const Json& run) {
  if (path_.empty()) return {};
  const auto line = Json{{"key", name_of(key)}, {"run", run}}.dump() + "\n";
  const std::lock_guard lock{*writing_};
  out_ << line << std::flush;
  return out_ ? Status{} : tl::unexpected(cannot_write(path_));
}

}  // namespace tactus
