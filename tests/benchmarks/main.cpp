#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/benchmarks/speed_benchmark.h"
#include "tests/benchmarks/speed_report.h"

// tactus_benchmarks [--json] [arguments of google-benchmark…]. Later arguments win over these.
int main(int argc, char** argv) {
  std::vector<std::string> words = {argv[0], "--benchmark_enable_random_interleaving=true",
                                    "--benchmark_repetitions=9", "--benchmark_min_time=0.01"};
  words.insert(words.end(), argv + 1, argv + argc);
  const auto json = std::find(words.begin(), words.end(), "--json");
  tactus::bench::SpeedReport report(json != words.end());
  if (json != words.end()) words.erase(json);
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  int count = static_cast<int>(arguments.size());
  tactus::bench::add_speed_benchmarks();
  benchmark::Initialize(&count, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(count, arguments.data())) return 2;
  benchmark::RunSpecifiedBenchmarks(&report);
  return 0;
}
