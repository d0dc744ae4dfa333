#include "engine/scene/network_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "engine/nodes/networks/network.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus {
namespace {

/// The same bounds that `auto` chooses by.
std::optional<SolverBounds> bounds_of(const NetworkView& view) {
  const auto is_used = [&](const SolverBounds& bounds) {
    return bounds.solver == view.recipe.solver && bounds.oversample == view.recipe.oversample;
  };
  auto candidates = view.network.choice().candidates;
  if (candidates.empty())
    candidates = choose_solver(view.recipe.elements, view.recipe.rate, view.recipe.oversample).candidates;
  const auto used = std::ranges::find_if(candidates, is_used);
  return used == candidates.end() ? std::nullopt : std::optional{*used};
}

/// A network on a loop runs in two steps.
std::optional<double> time_of(const Plan& plan, int node, const std::vector<double>& step_ns) {
  if (step_ns.size() != plan.steps.size()) return std::nullopt;
  double sum = 0;
  for (std::size_t s = 0; s < step_ns.size(); ++s)
    if (plan.steps[s].node == node) sum += step_ns[s];
  return sum;
}

}  // namespace

std::optional<double> NetworkReport::error_bound() const {
  if (!bounds || !bounds->stable || !bounds->bounded() || bounds->error >= 1) return std::nullopt;
  return std::max(bounds->error, bounds->slip_error);
}

std::vector<NetworkReport> report_networks(const Plan& plan, const std::vector<double>& step_ns) {
  std::vector<NetworkReport> reports;
  for (const auto& step : plan.steps) {
    if (step.node < 0 || step.kind == Step::Kind::Absorb) continue;
    const auto* view = dynamic_cast<const NetworkView*>(plan.nodes[index(step.node)].get());
    if (view == nullptr) continue;
    const auto& vertex = plan.vertices[index(step.vertex)];
    reports.push_back({vertex.path, vertex.at.file ? *vertex.at.file : std::string{}, view->recipe.solver,
                       view->recipe.oversample, bounds_of(*view), time_of(plan, step.node, step_ns)});
  }
  return reports;
}

int timed_every(double frames) {
  constexpr double kTimedFrames = 200 * kMaxSubBlock, kSeldom = 64;
  return static_cast<int>(std::clamp(frames / kTimedFrames, 1.0, kSeldom));
}

SceneTimes::SceneTimes(BuiltScene& built, double frames)
    : built_(built),
      plant_(*built.plant, timed_every(frames)),
      instrument_(*built.instrument, timed_every(frames)) {}

void SceneTimes::add(int frames) {
  plant_.add(frames);
  instrument_.add(frames);
}

std::vector<NetworkReport> SceneTimes::networks() const {
  auto all = report_networks(built_.plant->plan(), plant_.ns_per_frame());
  for (auto& network : report_networks(built_.instrument->plan(), instrument_.ns_per_frame()))
    all.push_back(std::move(network));
  return all;
}

std::string describe_bound(const NetworkReport& network) {
  return network.bounds ? describe_bound(*network.bounds) : "the reference solution";
}

std::string describe_solver(const NetworkReport& network) {
  return name_of(network.solver) + (network.oversample > 1 ? fmt::format(" x{}", network.oversample) : "");
}

std::string describe(const NetworkReport& network) {
  auto text = fmt::format("network '{}' in {}: {}, {}", network.name,
                          std::filesystem::path{network.file}.filename().string(), describe_solver(network),
                          describe_bound(network));
  if (network.ns_per_frame) text += fmt::format(", {:.0f} ns per frame", *network.ns_per_frame);
  return text;
}

}  // namespace tactus
