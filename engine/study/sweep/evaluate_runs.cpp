#include "engine/study/sweep/evaluate_runs.h"

#include <fmt/format.h>

#include <fstream>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

namespace tactus {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string name_of(std::uint64_t key) { return fmt::format("{:016x}", key); }

bool ends_incomplete(const fs::path& path) {
  std::ifstream file{path, std::ios::binary | std::ios::ate};
  if (!file || file.tellg() <= 0) return false;
  file.seekg(-1, std::ios::end);
  return file.get() != '\n';
}

/// Results of runs on disk; without a folder it stores nothing.
class RunCache {
 public:
  Status open(const RunPlan& plan) {
    if (plan.cache.empty()) return {};
    std::error_code error;
    fs::create_directories(plan.cache, error);
    for (const auto& entry : fs::directory_iterator{plan.cache, error})
      if (entry.path().extension() == ".jsonl") read(entry.path());
    path_ = plan.cache /
            (plan.parts == 1 ? "runs.jsonl" : fmt::format("part_{}_of_{}.jsonl", plan.part + 1, plan.parts));
    const bool incomplete = ends_incomplete(path_);
    out_.open(path_, std::ios::binary | std::ios::app);
    if (incomplete) out_ << "\n" << std::flush;
    return status();
  }

  std::optional<RunResult> find(std::uint64_t key) const {
    const auto found = runs_.find(name_of(key));
    return found == runs_.end() ? std::nullopt : std::optional{found->second};
  }

  /// From several threads at once.
  Status add(std::uint64_t key, const RunResult& run) {
    if (path_.empty()) return {};
    // Non-finite numbers become null.
    const auto line = Json{{"key", name_of(key)}, {"run", run}}.dump() + "\n";
    const std::lock_guard lock{writing_};
    out_ << line << std::flush;
    return status();
  }

 private:
  void read(const fs::path& file) {
    std::ifstream text{file, std::ios::binary};
    for (std::string line; std::getline(text, line);) try {
        const auto json = Json::parse(line);
        RunResult run;
        for (const auto& value : json.at("run"))
          run.push_back(value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN());
        runs_[json.at("key").get<std::string>()] = std::move(run);
      } catch (const Json::exception&) {  // an incomplete line
      }
  }

  Status status() const {
    if (out_) return {};
    return fail(Errc::BadFile, path_.generic_string(), "the result of the run cannot be written",
                "choose another folder for --keep");
  }

  std::map<std::string, RunResult> runs_;
  fs::path path_;
  std::ofstream out_;
  std::mutex writing_;
};

}  // namespace

Checked<std::vector<std::optional<RunResult>>> evaluate_runs(
    const RunPlan& plan, int count, const std::function<std::uint64_t(int)>& key,
    const std::function<Checked<RunResult>(int)>& evaluate) {
  RunCache cache;
  if (auto opened = cache.open(plan); !opened) return tl::unexpected(std::vector{opened.error()});
  std::vector<std::optional<RunResult>> results(static_cast<std::size_t>(count));
  std::mutex failing;
  std::atomic<bool> failed = false;
  std::vector<Error> errors;
  const auto execute = [&](int i) {
    auto& result = results[static_cast<std::size_t>(i)];
    const auto run_key = plan.cache.empty() ? 0 : key(i);
    if (!plan.cache.empty()) result = cache.find(run_key);
    if (result || i % plan.parts != plan.part || failed || (plan.stop && plan.stop())) return;
    auto run = evaluate(i);
    if (run)
      if (auto status = cache.add(run_key, *run); !status) run = tl::unexpected(std::vector{status.error()});
    if (run) {
      result = std::move(*run);
      return;
    }
    const std::lock_guard lock{failing};
    if (!failed.exchange(true)) errors = std::move(run.error());
  };
  const auto progress = [&](double share) {
    if (plan.progress) plan.progress(share);
  };
  parallel_for(count, execute, progress, plan.workers);
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  return results;
}

}  // namespace tactus
