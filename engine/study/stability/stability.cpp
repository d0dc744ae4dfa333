#include "engine/study/stability/stability.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/core/index.h"
#include "engine/study/stability/models/stability_roots.h"

namespace tactus {
namespace {

constexpr std::size_t kMostRoots = 6;

bool among(const std::vector<int>& signals, int signal) {
  return std::ranges::find(signals, signal) != signals.end();
}

void find_growth(const LoopScan& scan, int cut, LoopVerdict& loop) {
  const double border = loop.margin.border;
  if (!std::isfinite(border) || border <= 0) return;
  const auto growth = [&](double factor) {
    const auto root = scan.root_near(loop.margin.border_hz, cut, factor * border);
    return root ? root->growth_per_s : 0;
  };
  loop.growth_below = growth(0.98);
  loop.growth_above = growth(1.02);
}

/// Only if the whole force goes through one drive, the force on the device is known.
void find_passive_limit(const ClosedGraph& closed, const LoopGroup& group, int cut, Hertz rate,
                        RegimeVerdict& verdict) {
  int drive = -1, drives = 0;
  for (const int signal : closed.drives)
    if (const int at = group.cut(signal); at >= 0) drive = at, ++drives;
  if (drives != 1 || !closed.mobility) return;
  const auto limit = passive_limit(group, drive, cut, closed.mobility, rate);
  verdict.device_damping = limit.device_damping;
  verdict.stiff.back().passive_up_to = verdict.stiff.back().stiffness * limit.factor;
}

void analyse_group(const ClosedGraph& closed, const LoopGroup& group, Hertz rate, RegimeVerdict& verdict) {
  const auto& graph = closed.graph;
  if (group.too_large()) return verdict.too_large.push_back(graph.signals[index(group.signals().front())]);
  const LoopScan scan(group, rate);
  verdict.growing += std::max(0, scan.growing());
  for (const auto& root : scan.roots(kMostRoots)) verdict.roots.push_back(root);
  for (int c = 0; c < std::ssize(group.cuts()); ++c) {
    const auto margin = scan.margin(c);
    const int cut = group.cuts()[index(c)];
    if (const auto place = std::ranges::find(graph.stiff, cut, &StiffPlace::signal);
        place != graph.stiff.end()) {
      verdict.stiff.push_back({*place, place->stiffness * margin.border, margin.border_hz, std::nullopt});
      find_passive_limit(closed, group, c, rate, verdict);
    } else {
      verdict.loops.push_back({graph.signals[index(cut)], group.path_around(c), among(closed.drives, cut),
                               among(graph.wave_ports, cut), margin});
      find_growth(scan, c, verdict.loops.back());
    }
  }
}

RegimeVerdict analyse_regime(const ClosedGraph& closed, const Regime& regime, Hertz rate) {
  RegimeVerdict verdict{.name = regime.name,
                        .held = regime.hand.has_value(),
                        .unstable_equilibria = closed.graph.unstable_equilibria};
  std::vector<int> wanted = closed.drives;
  for (const auto& place : closed.graph.stiff) wanted.push_back(place.signal);
  for (auto& signals : loops_of(closed.graph, false))
    analyse_group(closed, {closed.graph, std::move(signals), wanted}, rate, verdict);
  sort_by_growth(verdict.roots, kMostRoots);
  return verdict;
}

/// Whether a loop is closed by events of a node, or by its unknown gain.
bool event_loop_through(const LinearGraph& graph, const std::string& path) {
  std::vector<bool> looping(graph.signals.size(), false);
  for (const auto& part : loops_of(graph, true))
    for (const int s : part) looping[index(s)] = true;
  return std::ranges::any_of(graph.edges, [&](const auto& e) {
    return e.kind == LinearEdge::Kind::Event && e.path == path && looping[index(e.from)] &&
           looping[index(e.to)];
  });
}

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

class Analysis {
 public:
  Analysis(const StabilitySubject& subject, const StabilityOptions& options,
           const std::function<void(double)>& progress)
      : subject_(subject), options_(options), progress_(progress) {}

  Checked<StabilityVerdict> run() {
    auto world = RestingWorld::make(subject_, options_.world);
    if (!world) return tl::unexpected(world.error());
    verdict_.rate = world->rate();
    verdict_.delay_s = world->delay_frames() / world->rate().value;
    verdict_.outside_known = world->outside_known();
    const auto regimes = world->regimes(options_.push);
    for (const auto& regime : regimes) analyse(*world, regime);
    find_event_loops(*world);
    for (const auto& regime : regimes) find_open_gains(*world, regime);
    for (const auto& control : world->instrument().controls) find_border(control.control);
    if (auto judged = judge_gestures(); !judged) return tl::unexpected(judged.error());
    conclude();
    return std::move(verdict_);
  }

 private:
  void conclude() {
    auto& all = verdict_.stability;
    const auto unless = [&](bool stable) { all = worse(all, stable ? Stability::Stable : Stability::Unstable); };
    for (const auto& regime : verdict_.regimes) unless(regime.held || regime.is_stable());
    for (const auto& network : verdict_.networks) unless(network.stable());
    for (const auto& gesture : verdict_.gestures) all = worse(all, gesture.stability);
    if (!verdict_.doubts.empty()) all = worse(all, Stability::Undecided);
  }

  void report_progress() {
    constexpr double kAll = 24;
    if (progress_) progress_(1 - std::exp(-++done_ / kAll));
  }

  /// Bare, and held where something is driven.
  void analyse(const RestingWorld& world, const Regime& regime) {
    const auto closed = world.closed(regime);
    analyse_networks(closed.graph, regime);
    verdict_.nonlinear |= closed.graph.nonlinear;
    verdict_.regimes.push_back(analyse_regime(closed, regime, verdict_.rate));
    if (verdict_.regimes.size() == 1)
      for (const auto& first : verdict_.regimes.front().too_large)
        verdict_.skipped.push_back("the loops through '" + first + "'");
    report_progress();
    if (!closed.mobility || verdict_.regimes.back().loops.empty()) return;
    auto with_hand = regime;
    with_hand.hand = options_.hand;
    verdict_.regimes.push_back(analyse_regime(world.closed(with_hand), with_hand, verdict_.rate));
    report_progress();
  }

  void analyse_networks(const LinearGraph& graph, const Regime& regime) {
    for (std::size_t n = 0; n < graph.networks.size(); ++n) {
      // Unless one of its contacts is closed it is as at rest.
      if (!verdict_.regimes.empty() && !regime.contacts.contains(graph.network_paths[n])) continue;
      const auto& model = *graph.networks[n];
      const auto& recipe = model.recipe;
      NetworkVerdict verdict{graph.network_paths[n], regime.name};
      verdict.solver = recipe.solver;
      verdict.has_friction = !recipe.elements.frictions.empty();
      verdict.radius = model.radius;
      verdict.rate_hz = recipe.rate.value * recipe.oversample;
      if (const auto needed = model.needed_rate()) verdict.needed_hz = needed->value;
      verdict.weakest = model.weakest();
      check_contacts(recipe, verdict);
      verdict.grows = model.grows();
      verdict_.networks.push_back(std::move(verdict));
    }
    if (verdict_.skipped.empty())
      for (const auto& path : graph.skipped)
        if (event_loop_through(graph, path))
          verdict_.skipped.push_back("the loops through network '" + path + "'");
  }

  /// Of the explicit solver: the others bound the energy of a contact, however short it is.
  static void check_contacts(const NetworkRecipe& recipe, NetworkVerdict& verdict) {
    if (recipe.solver != Solver::Explicit) return;
    const auto demand = contact_demand(recipe.elements);
    for (const auto& strike : demand.strikes) {
      const double steps = strike.time_s * verdict.rate_hz, needed = strike.fewest_steps();
      if (steps / needed >= verdict.contact_steps / verdict.needed_contact_steps) continue;
      verdict.contact_steps = steps;
      verdict.needed_contact_steps = needed;
    }
    verdict.too_deep = demand.stiffness > kStiffestContact * verdict.rate_hz * verdict.rate_hz;
  }

  void find_event_loops(const RestingWorld& world) {
    const auto graph = world.closed({}).graph;
    verdict_.events = graph.events;
    for (auto& event : verdict_.events) event.on_loop = event_loop_through(graph, event.path);
  }

  /// The largest gain of each pair with the inner loops closed.
  void find_open_gains(const RestingWorld& world, const Regime& regime) {
    LinearGraph graph;
    for (auto& pair : world.open_pairs(graph, regime)) {
      // Output to input closed by a wire of its own: what comes back through it is the pair's response.
      auto closed = graph;
      const int wire = closed.add_signal("outside");
      closed.join(pair.to, wire);
      closed.delay(wire, pair.from, 1);
      for (auto& signals : loops_of(closed, false)) {
        const LoopGroup group(closed, std::move(signals), {wire});
        if (group.too_large() || group.cut(wire) < 0) continue;
        const auto margin = LoopScan(group, verdict_.rate).margin(group.cut(wire));
        pair.peak = margin.peak;
        pair.peak_hz = margin.peak_hz;
        add_open_gain(pair);
      }
    }
  }

  /// Of all regimes the largest gain counts.
  void add_open_gain(const OpenPair& found) {
    const auto known = std::ranges::find_if(verdict_.open, [&](const auto& other) {
      return other.input == found.input && other.output == found.output;
    });
    if (known == verdict_.open.end())
      verdict_.open.push_back(found);
    else if (found.peak > known->peak)
      *known = found;
  }

  bool is_stable_at(const FlatControl& control, double value) {
    auto with = options_.world;
    with.set[control.name] = ControlValue{value};
    report_progress();
    return stability_with(subject_, with, options_.push) == Stability::Stable;
  }

  /// If one end is stable and the other is not, the border between them.
  void find_border(const FlatControl& control) {
    ControlVerdict verdict{.control = control};
    double low = control.range.low, high = control.range.high;
    if (!std::isfinite(low) || !std::isfinite(high)) return;
    verdict.stable_low = is_stable_at(control, low);
    verdict.stable_high = is_stable_at(control, high);
    if (verdict.stable_low != verdict.stable_high) {
      for (int i = 0; i < kMostHalvings && !close(low, high); ++i) {
        const double middle = low > 0 && high > 0 ? std::sqrt(low * high) : 0.5 * (low + high);
        (is_stable_at(control, middle) == verdict.stable_low ? low : high) = middle;
      }
      verdict.border = verdict.stable_low ? low : high;
    }
    verdict_.controls.push_back(std::move(verdict));
  }

  Checked<void> judge_gestures() {
    if (subject_.scene == nullptr) return {};
    const auto scene = compile_scene(*subject_.scene, *subject_.table, options_.world);
    if (!scene) return tl::unexpected(scene.error());
    const auto& controls = scene->instrument->controls;
    std::map<std::map<int, double>, Stability> known;
    for (const auto& reached : reached_values(scene->journal, verdict_.rate)) {
      const auto& control = controls[index(reached.control)].control;
      auto with = options_.world;
      for (const auto& [moved, value] : reached.state.values)
        with.set[controls[index(moved)].control.name] = ControlValue{value};
      const auto [judged, is_new] = known.try_emplace(reached.state.values, Stability::Stable);
      if (is_new) judged->second = stability_with(subject_, with, options_.push);
      report_progress();
      verdict_.gestures.push_back(
          {control.name, control.unit, reached.value(), reached.state.seconds, judged->second});
    }
    return {};
  }

  static constexpr int kMostHalvings = 40;
  /// Within a thousandth of the value, however large the range is.
  static bool close(double low, double high) {
    return high - low <= 1e-3 * std::max(std::abs(low), std::abs(high));
  }

  const StabilitySubject& subject_;
  const StabilityOptions& options_;
  const std::function<void(double)>& progress_;
  double done_ = 0;
  StabilityVerdict verdict_;
};

}  // namespace

Stability stability_with(const StabilitySubject& subject, const WorldOptions& options, double push) {
  const auto world = RestingWorld::make(subject, options);
  if (!world) return Stability::Unstable;
  const auto regimes = world->regimes(push);
  const bool stable = std::ranges::all_of(regimes, [&](const auto& regime) {
    const auto closed = world->closed(regime);
    const auto& networks = closed.graph.networks;
    if (std::ranges::any_of(networks, [](const auto& n) { return n->grows(); })) return false;
    int growing = 0;
    for (auto& signals : loops_of(closed.graph, false)) {
      const LoopGroup group(closed.graph, std::move(signals), {});
      if (!group.too_large()) growing += LoopScan(group, world->rate()).growing();
    }
    return growing <= 0;
  });
  return stable ? Stability::Stable : Stability::Unstable;
}

Checked<StabilityVerdict> analyse_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                            const std::function<void(double)>& progress) {
  return Analysis{subject, options, progress}.run();
}

}  // namespace tactus
