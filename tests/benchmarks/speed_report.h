#pragma once

#include <benchmark/benchmark.h>

#include <map>
#include <string>
#include <vector>

namespace tactus::bench {

inline constexpr int kBlocks[] = {1, 16, 64, 256, 1024};

/// Collects the repetitions of every benchmark and prints their medians as one table, or as JSON.
/// Benchmarks are named "work/who/block".
class SpeedReport : public benchmark::BenchmarkReporter {
 public:
  explicit SpeedReport(bool json) : json_(json) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override;
  void Finalize() override;

 private:
  using Row = std::map<int, double>;  ///< by block
  struct Table {
    std::vector<std::string> order;  ///< of `rows`
    std::map<std::string, Row> rows;
  };

  void arrange();
  void print_table(const std::string& work, const Table& table) const;
  void print_json() const;

  bool json_;
  std::vector<std::string> names_;                      ///< in order of appearance
  std::map<std::string, std::vector<double>> seconds_;  ///< of the repetitions, for one iteration
  std::vector<std::string> works_;
  std::map<std::string, Table> tables_;
  std::vector<std::pair<std::string, double>> others_;   ///< what has no blocks, in nanoseconds
  std::map<std::string, std::vector<double>> counters_;  ///< of the repetitions, by "benchmark counter"
};

}  // namespace tactus::bench
