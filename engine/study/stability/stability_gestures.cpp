#include "engine/study/stability/stability_gestures.h"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "engine/core/index.h"
#include "engine/study/stability/models/stability_roots.h"
#include "engine/study/stability/stability_loops.h"
#include "engine/study/stability/stability_world.h"

namespace tactus {
namespace {

/// Controls at a time, as entries of a journal left them: SI, by their numbers.
struct ControlState {
  double seconds = 0;
  std::map<int, double> values;
};

/// A control at its highest or lowest value.
struct ReachedValue {
  int control = 0;
  ControlState state;
  double value() const { return state.values.at(control); }
};

/// Of each control that the journal moves.
std::vector<ReachedValue> reached_values(const std::vector<JournalEntry>& journal, Hertz rate) {
  std::map<int, std::pair<ReachedValue, ReachedValue>> ends;  // lowest, highest
  ControlState now;
  for (std::size_t i = 0; i < journal.size(); ++i) {
    now.seconds = static_cast<double>(journal[i].frame) / rate.value;
    now.values[journal[i].index] = journal[i].value;
    if (i + 1 < journal.size() && journal[i + 1].frame == journal[i].frame) continue;
    for (const auto& [control, value] : now.values) {
      const auto known = ends.find(control);
      if (known == ends.end() || value < known->second.first.value()) ends[control].first = {control, now};
      if (known == ends.end() || value > known->second.second.value()) ends[control].second = {control, now};
    }
  }
  std::vector<ReachedValue> reached;
  for (auto& [control, both] : ends) {
    if (both.first.value() != both.second.value()) reached.push_back(std::move(both.first));
    reached.push_back(std::move(both.second));
  }
  return reached;
}

/// The states of the controls at each time when two or more of them have moved within 20 ms, in the same
/// frame or not. A control that moves alone needs none: its lowest and highest values are analysed elsewhere.
std::vector<ControlState> moving_states(const std::vector<JournalEntry>& journal, Hertz rate) {
  constexpr double kTogether = 0.02;
  std::vector<ControlState> states;
  ControlState now;
  std::map<int, double> moved;  // when last
  for (std::size_t i = 0; i < journal.size(); ++i) {
    const auto& entry = journal[i];
    now.seconds = static_cast<double>(entry.frame) / rate.value;
    const auto known = now.values.find(entry.index);
    if (known != now.values.end() && known->second != entry.value) moved[entry.index] = now.seconds;
    now.values[entry.index] = entry.value;
    if (i + 1 < journal.size() && journal[i + 1].frame == entry.frame) continue;
    std::erase_if(moved, [&](const auto& m) { return m.second < now.seconds - kTogether; });
    if (moved.size() > 1) states.push_back(now);
  }
  return states;
}

/// Per second, of the root that decays least.
double growth_with(const StabilitySubject& subject, const WorldOptions& options, double push) {
  const auto world = RestingWorld::make(subject, options);
  double most = -std::numeric_limits<double>::infinity();
  if (!world) return most;
  for (const auto& regime : world->regimes(push)) {
    const auto closed = world->closed(regime);
    for (auto& signals : loops_of(closed.graph, false)) {
      const LoopGroup group(closed.graph, std::move(signals), {});
      if (group.too_large() || group.too_long()) continue;
      const LoopScan scan(group, world->rate());
      if (scan.growing() > 0) most = std::max(most, 2 * kSlowestGrowth);  // even if no root is found
      for (const auto& root : scan.roots(1)) most = std::max(most, root.growth_per_s);
    }
  }
  return most;
}

class GestureJudge {
 public:
  GestureJudge(const StabilitySubject& subject, const StabilityOptions& options,
               const std::vector<PlannedControl>& controls, const std::function<void()>& progress)
      : subject_(subject), options_(options), controls_(controls), progress_(progress) {}

  std::vector<GestureVerdict> run(const std::vector<JournalEntry>& journal, Hertz rate) {
    for (const auto& reached : reached_values(journal, rate)) judge_reached(reached);
    const auto way = moving_states(journal, rate);
    const bool stable =
        std::ranges::all_of(verdicts_, [](const auto& g) { return g.stability == Stability::Stable; });
    if (stable && way.size() > 2) search_between(way);
    return std::move(verdicts_);
  }

 private:
  WorldOptions at_state(const ControlState& state) const {
    auto with = options_.world;
    for (const auto& [moved, value] : state.values)
      with.set[controls_[index(moved)].control.name] = ControlValue{value};
    return with;
  }

  void judge_reached(const ReachedValue& reached) {
    const auto [judged, is_new] = judged_.try_emplace(reached.state.values, Stability::Stable);
    if (is_new) judged->second = stability_with(subject_, at_state(reached.state), options_.push);
    progress_();
    const auto& control = controls_[index(reached.control)].control;
    verdicts_.push_back({control.name, control.unit, reached.value(), reached.state.seconds, judged->second});
  }

  /// The growth of what decays least along the way, evenly and then closer around its highest place.
  void search_between(const std::vector<ControlState>& way) {
    constexpr std::size_t kEvenly = 12, kCloser = 5;
    const auto last = way.size() - 1;
    std::map<std::size_t, double> growth;
    const auto look = [&](std::size_t i) {
      if (!growth.contains(i))
        growth[i] = growth_with(subject_, at_state(way[i]), options_.push), progress_();
    };
    for (std::size_t i = 0; i <= kEvenly; ++i) look(i * last / kEvenly);
    std::size_t best = 0;
    for (std::size_t stride = std::max<std::size_t>(1, last / kEvenly); stride > 0; stride /= kCloser) {
      best = std::ranges::max_element(growth, {}, [](const auto& g) { return g.second; })->first;
      for (std::size_t k = 0; k <= 2 * kCloser; ++k) {
        const auto at = best + k * stride / kCloser;
        if (at >= stride && at - stride <= last) look(at - stride);
      }
      best = std::ranges::max_element(growth, {}, [](const auto& g) { return g.second; })->first;
      if (growth[best] > kSlowestGrowth) break;
    }
    if (growth[best] > kSlowestGrowth) judge_reached({way[best].values.begin()->first, way[best]});
  }

  const StabilitySubject& subject_;
  const StabilityOptions& options_;
  const std::vector<PlannedControl>& controls_;
  const std::function<void()>& progress_;
  std::vector<GestureVerdict> verdicts_;
  std::map<std::map<int, double>, Stability> judged_;  ///< by the values of the controls
};

}  // namespace

Checked<std::vector<GestureVerdict>> judge_gestures(const StabilitySubject& subject,
                                                    const StabilityOptions& options, Hertz rate,
                                                    const std::function<void()>& progress) {
  if (subject.scene == nullptr) return {};
  const auto scene = compile_scene(*subject.scene, *subject.table, options.world);
  if (!scene) return tl::unexpected(scene.error());
  return GestureJudge{subject, options, scene->instrument->controls, progress}.run(scene->journal, rate);
}

}  // namespace tactus
