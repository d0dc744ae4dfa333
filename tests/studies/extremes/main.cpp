#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <new>
#include <string>
#include <vector>

#include "tests/conformance/extremes/expression_case.h"
#include "tests/conformance/extremes/extreme_case.h"
#include "tests/conformance/extremes/field_case.h"

// Extreme values of every parameter: `extremes_study [FILTER]`. Prints a table of families, and every case
// that is wrong on standard error. Each case runs in a process that may take 5 s of processor time and 256
// MB. Exit code 1: something is wrong.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kMostSeconds = 5;
constexpr rlim_t kMostBytes = rlim_t{256} << 20;

struct Job {
  std::string family;
  std::function<std::string()> name;
  std::function<Judgement()> judge;
};

/// Of `subjects`, which must outlive the result.
void add_jobs(const std::vector<ExtremeSubject>& subjects, std::vector<Job>& jobs) {
  for (const auto& subject : subjects)
    for (const auto& one : extreme_cases(subject, {8e3, 48e3, 192e3, 768e3}))
      jobs.push_back({subject.family == "element" ? "networks: " + subject.type : subject.family,
                      [one] { return one.name(); }, [one] { return judge(one); }});
}

std::vector<Job> all_jobs() {
  static const auto nodes = node_subjects(), elements = element_subjects();
  std::vector<Job> jobs;
  add_jobs(nodes, jobs);
  add_jobs(elements, jobs);
  for (const auto& one : expression_cases())
    jobs.push_back({"expressions", [one] { return one.name(); }, [one] { return judge(one); }});
  for (const auto& one : field_cases())
    jobs.push_back({one.family() + " files", [one] { return one.name(); }, [one] { return judge(one); }});
  return jobs;
}

rlim_t address_space() {
  rlim_t pages = 0;
  std::ifstream{"/proc/self/statm"} >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
}

Judgement judged_or_caught(const Job& job) {
  try {
    return job.judge();
  } catch (const std::bad_alloc&) {
    return {Verdict::Wrong, "more than 256 MB"};
  } catch (const std::exception& error) {
    return {Verdict::Wrong, std::string{"an exception: "} + error.what()};
  }
}

/// In a child: one line for each case from `from` on.
[[noreturn]] void run_jobs(const std::vector<Job>& jobs, std::size_t from, std::size_t to, int out) {
  const rlim_t most = address_space() + kMostBytes;
  const rlimit limit{most, most};
  setrlimit(RLIMIT_AS, &limit);
  for (auto i = from; i < to; ++i) {
    const itimerval timer{{0, 0}, {kMostSeconds, 0}};
    setitimer(ITIMER_PROF, &timer, nullptr);
    auto [verdict, reason] = judged_or_caught(jobs[i]);
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    const auto line = fmt::format("{} {} {}\n", i, static_cast<int>(verdict), reason);
    if (write(out, line.data(), line.size()) < 0) std::_Exit(1);
  }
  std::_Exit(0);
}

class Study {
 public:
  explicit Study(std::vector<Job> jobs) : jobs_(std::move(jobs)) {}

  void run() {
    for (std::size_t next = 0; next < jobs_.size();) next = run_from(next);
    std::fprintf(stderr, "\r");
  }

  int print() const {
    int total[5] = {};
    fmt::print(
        "| family | cases | refused | right by expectation | finite only | wrong "
        "|\n|---|---|---|---|---|---|\n");
    const auto row = [](const std::string& name, const int* n) {
      fmt::print("| {} | {} | {} | {} | {} | {} |\n", name, n[0] + n[1] + n[2] + n[3], n[0], n[1], n[2],
                 n[3]);
    };
    for (const auto& name : order_) {
      row(name, counts_.at(name).data());
      for (int v = 0; v < 4; ++v) total[v] += counts_.at(name)[static_cast<std::size_t>(v)];
    }
    row("all", total);
    return total[3] == 0 ? 0 : 1;
  }

 private:
  void note(std::size_t i, Verdict verdict, const std::string& reason) {
    const auto& family = jobs_[i].family;
    if (!counts_.contains(family)) order_.push_back(family);
    ++counts_[family][static_cast<std::size_t>(verdict)];
    if (verdict == Verdict::Wrong || std::getenv("EXTREMES_ALL") != nullptr)
      fmt::print(stderr, "{} | {} | {}\n", kVerdicts[static_cast<int>(verdict)], jobs_[i].name(), reason);
  }

  /// Runs a child from `next` on; returns where the next one begins.
  std::size_t run_from(std::size_t next) {
    constexpr std::size_t kCasesOfChild = 2000;
    const auto end = std::min(jobs_.size(), next + kCasesOfChild);
    int ends[2];
    if (pipe(ends) != 0) std::exit(2);
    const auto child = fork();
    if (child == 0) run_jobs(jobs_, next, end, ends[1]);
    close(ends[1]);
    auto* lines = fdopen(ends[0], "r");
    char* line = nullptr;
    std::size_t size = 0;
    while (getline(&line, &size, lines) > 0) {
      int verdict = 0, reason = 0;
      if (std::sscanf(line, "%zu %d %n", &next, &verdict, &reason) < 2) break;
      std::string text = line + reason;
      while (!text.empty() && text.back() == '\n') text.pop_back();
      note(next++, static_cast<Verdict>(verdict), text);
    }
    std::free(line);
    fclose(lines);
    int status = 0;
    waitpid(child, &status, 0);
    if (next < end)
      note(next++, Verdict::Wrong,
           WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF ? "more than 5 s" : "the program ended");
    std::fprintf(stderr, "\r%3.0f %%", 100.0 * static_cast<double>(next) / static_cast<double>(jobs_.size()));
    return next;
  }

  std::vector<Job> jobs_;
  std::vector<std::string> order_;
  std::map<std::string, std::array<int, 4>> counts_;
};

}  // namespace

int main(int count, char** arguments) {
  for (const auto& section : missing_sections())
    std::fprintf(stderr, "wrong | no text for the section %s in field_case.cpp\n", section.c_str());
  auto jobs = all_jobs();
  if (count > 1)
    std::erase_if(jobs, [&](const Job& job) { return job.name().find(arguments[1]) == std::string::npos; });
  Study study{std::move(jobs)};
  study.run();
  return std::max(study.print(), missing_sections().empty() ? 0 : 1);
}
