#include "tests/benchmarks/speed_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tactus::bench {
namespace {

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

void SpeedReport::ReportRuns(const std::vector<Run>& runs) {
  for (const auto& run : runs) {
    if (run.run_type != Run::RT_Iteration || run.error_occurred) continue;
    const auto name = run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args);
    auto& list = seconds_[name];
    if (list.empty()) names_.push_back(name);
    // `items` are frames (or blocks, where a row says so).
    const auto items = run.counters.find("items_per_second");
    list.push_back(items != run.counters.end()
                       ? 1 / items->second.value
                       : run.cpu_accumulated_time / static_cast<double>(run.iterations));
    for (const auto& [what, counter] : run.counters)
      if (what != "items_per_second") counters_[name + " " + what].push_back(counter.value);
  }
}

void SpeedReport::arrange() {
  std::sort(names_.begin(), names_.end());
  for (const auto& name : names_) {
    const double ns = median(seconds_[name]) * 1e9;
    const auto first = name.find('/'), last = name.rfind('/');
    if (first == std::string::npos || first == last ||
        name.find_first_not_of("0123456789", last + 1) != std::string::npos) {
      others_.emplace_back(name, ns);
      continue;
    }
    const auto work = name.substr(0, first), who = name.substr(first + 1, last - first - 1);
    if (!tables_.contains(work)) works_.push_back(work);
    auto& table = tables_[work];
    const int block = std::stoi(name.substr(last + 1));
    if (!table.rows.contains(who)) table.order.push_back(who);
    table.rows[who][block] = ns;
    if (who.starts_with("Faust")) {
      auto& best = table.rows["best Faust"][block];
      best = best == 0 ? ns : std::min(best, ns);
    }
  }
}

void SpeedReport::Finalize() {
  arrange();
  if (json_) return print_json();
  fmt::print("{:<34}", "ns per frame, in blocks of");
  for (const int block : kBlocks) fmt::print("{:>9}", block);
  fmt::print("\n");
  for (const auto& work : works_) print_table(work, tables_[work]);
  if (!others_.empty()) fmt::print("\nOthers, ns\n");
  for (const auto& [name, ns] : others_) fmt::print("  {:<60}{:>14.1f}\n", name, ns);
  if (!counters_.empty()) fmt::print("\nCounters\n");
  for (const auto& [name, values] : counters_) fmt::print("  {:<60}{:>14.6g}\n", name, median(values));
}

void SpeedReport::print_table(const std::string& work, const Table& table) const {
  fmt::print("\n{}\n", work);
  const auto line = [](const std::string& name, auto cell) {
    fmt::print("  {:<32}", name);
    for (const int block : kBlocks) {
      const auto value = cell(block);
      fmt::print("{:>9}", value ? fmt::format("{:.2f}", *value) : "");
    }
    fmt::print("\n");
  };
  const auto value = [&](const std::string& who, int block) -> std::optional<double> {
    const auto row = table.rows.find(who);
    if (row == table.rows.end() || !row->second.contains(block)) return std::nullopt;
    return row->second.at(block);
  };
  for (const auto& who : table.order) line(who, [&](int block) { return value(who, block); });
  for (const auto& [who, other] : {std::pair{"graph", "plain C++ double"}, std::pair{"graph", "best Faust"},
                                   std::pair{"exported C", "best Faust"}})
    if (table.rows.contains(who) && table.rows.contains(other))
      line(fmt::format("{} / {}", who, other), [&](int block) -> std::optional<double> {
        const auto a = value(who, block), b = value(other, block);
        return a && b ? std::optional{*a / *b} : std::nullopt;
      });
}

void SpeedReport::print_json() const {
  nlohmann::ordered_json all;
  for (const auto& work : works_)
    for (const auto& [who, row] : tables_.at(work).rows)
      for (const auto& [block, ns] : row) all["ns_per_frame"][work][who][std::to_string(block)] = ns;
  for (const auto& [name, ns] : others_) all["ns"][name] = ns;
  for (const auto& [name, values] : counters_) all["counters"][name] = median(values);
  fmt::print("{}\n", all.dump(2));
}

}  // namespace tactus::bench
