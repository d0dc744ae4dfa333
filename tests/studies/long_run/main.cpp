#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "engine/core/median.h"
#include "tests/studies/long_run/subjects.h"

// Hours of simulated time: `long_run_study HOURS [SUBJECT ...]`. Prints rows of a Markdown table for each
// subject. Exit code 1: a quantity has left its bound.

using namespace tactus;
using namespace tactus::study;
using Clock = std::chrono::steady_clock;

namespace {

double nanoseconds(Subject& subject, std::int64_t frames) {
  const auto begin = Clock::now();
  subject.advance(frames);
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / static_cast<double>(frames);
}

/// Time of a frame of the old subject as a share of that of a new one, run in turns: medians.
double slower(Subject& old, Subject& fresh) {
  constexpr int kTurns = 41;
  const auto frames = static_cast<std::int64_t>(fresh.rate());
  std::vector<double> shares;
  for (int turn = 0; turn < kTurns; ++turn) {
    const double first = nanoseconds(old, frames), second = nanoseconds(fresh, frames);
    shares.push_back(first / second);
  }
  return median(std::move(shares));
}

bool run(const Entry& entry, double hours) {
  constexpr double kSettled_s = 60;
  const auto subject = entry.make();
  const auto settled = static_cast<std::int64_t>(kSettled_s * subject->rate());
  subject->advance(settled);
  subject->look();
  const auto total = static_cast<std::int64_t>(hours * 3600 * subject->rate());
  const auto begin = Clock::now();
  for (int part = 0; part < 100; ++part) {
    subject->advance(total / 100);
    std::fprintf(stderr, "\r%s %d %%", entry.name.c_str(), part + 1);
  }
  const double ns =
      std::chrono::duration<double, std::nano>(Clock::now() - begin).count() / static_cast<double>(total);
  subject->look();
  auto rows = subject->rows();
  const auto fresh = entry.make();
  fresh->advance(settled);
  const double share = slower(*subject, *fresh);
  rows.push_back({"time of a frame", "1", fmt::format("{:.2f}", share), "at most 1.2", share <= 1.2});
  bool right = true;
  for (const auto& row : rows) {
    fmt::print("| {} | {:g} h at {:g} kHz | {} | {} | {} | {} | {} |\n", entry.about, hours,
               subject->rate() / 1000, row.quantity, row.at_start, row.at_end, row.bound,
               row.right ? "yes" : "**no**");
    right = right && row.right;
  }
  std::fflush(stdout);
  std::fprintf(stderr, "\r%s: %.1f ns per frame\n", entry.name.c_str(), ns);
  return right;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) return std::fprintf(stderr, "usage: long_run_study HOURS [SUBJECT ...]\n"), 2;
  const double hours = std::strtod(arguments[1], nullptr);
  bool right = true;
  for (const auto& entry : subjects()) {
    bool chosen = count == 2;
    for (int i = 2; i < count; ++i) chosen = chosen || entry.name == arguments[i];
    if (chosen) right = run(entry, hours) && right;
  }
  return right ? 0 : 1;
}
