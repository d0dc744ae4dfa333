#include "engine/study/stability/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/core/index.h"
#include "engine/physics/network_model.h"
#include "engine/study/stability/models/stability_roots.h"
#include "engine/study/stability/models/thrown_network.h"
#include "engine/study/stability/stability_gestures.h"
#include "engine/study/sweep/evaluate_runs.h"

namespace tactus {
namespace {

constexpr std::size_t kMostRoots = 6;

bool among(const std::vector<int>& signals, int signal) {
  return std::ranges::find(signals, signal) != signals.end();
}

void find_growth(const LoopScan& scan, int cut, LoopVerdict& loop) {
  const double border = loop.margin.border;
  if (!std::isfinite(border) || border <= 0) return;
  const auto root_at = [&](double factor) {
    return scan.root_near(loop.margin.border_hz, cut, factor * border).value_or(LoopRoot{});
  };
  loop.growth_below = root_at(0.98).growth_per_s;
  const auto above = root_at(1.02);
  loop.growth_above = above.growth_per_s;
  loop.growing_hz = above.frequency_hz;
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

/// The loops without what goes from samples to frames.
LinearGraph frames_alone(const LinearGraph& graph) {
  auto alone = graph;
  std::erase_if(alone.edges, [&](const LinearEdge& edge) {
    return graph.divisors[index(edge.from)] > graph.divisors[index(edge.to)];
  });
  return alone;
}

void add_doubt(std::vector<Doubt>& doubts, Doubt doubt) {
  if (std::ranges::find(doubts, doubt) == doubts.end()) doubts.push_back(std::move(doubt));
}

const char* const kSmaller = "make the graph smaller, or judge it by playing";

/// Roots that grow in a group in which something is sampled once in `frames`.
int growing_when_sampled(const LinearGraph& graph, const std::vector<int>& signals, int frames, Hertz rate) {
  int growing = 0;
  const auto alone = frames_alone(graph);
  for (auto& loop : loops_of(alone, false))
    if (std::ranges::binary_search(signals, loop.front()) && graph.divisors[index(loop.front())] == 1)
      growing += std::max(
          0, LoopScan(LoopGroup(alone, std::move(loop), {}), rate, LoopScan::For::Counting).growing());
  const auto group = LoopGroup::sampled(graph, signals, frames);
  return growing + std::max(0, LoopScan(group, rate, LoopScan::For::Counting).growing());
}

/// Roots that grow in a group of loops; `scan`: of the same, where there is one.
int growing_in(const LinearGraph& graph, const std::vector<int>& signals, Hertz rate, const LoopScan* scan,
               std::vector<Doubt>& doubts) {
  // What computes its next value from the last one alone grows or decays at whatever time it is sampled.
  const auto within = [&](const LinearEdge& edge) {
    return edge.kind != LinearEdge::Kind::Gain && edge.kind != LinearEdge::Kind::Event &&
           std::ranges::binary_search(signals, edge.from) && std::ranges::binary_search(signals, edge.to);
  };
  const bool recursion = std::ranges::none_of(graph.edges, within);
  for (const auto& [signal, path] : graph.unclocked)
    if (!recursion && std::ranges::binary_search(signals, signal))
      add_doubt(
          doubts,
          {"'" + path + "' samples a signal of a loop without a regular clock, so its delay is not known",
           "trigger it by a clock of a whole number of frames, hold by select(trigger, x, held) and a 'held' "
           "that is a delay of one frame, or take it out of the loop"});
  const int frames = frames_between_samples(graph, signals);
  if (frames == 0)
    add_doubt(doubts,
              {"a loop through '" + graph.signals[index(signals.front())] + "' is sampled at several rates",
               "give the parts and clocks of this loop one rate"});
  constexpr int kMostFrames = 256;
  if (frames > kMostFrames)
    add_doubt(doubts, {"a loop through '" + graph.signals[index(signals.front())] +
                           "' is sampled less often than once in 256 frames",
                       "sample it more often"});
  if (frames > 1 && frames <= kMostFrames) return growing_when_sampled(graph, signals, frames, rate);
  return std::max(0, scan != nullptr
                         ? scan->growing()
                         : LoopScan(LoopGroup(graph, signals, {}), rate, LoopScan::For::Counting).growing());
}

/// Or too long.
bool too_large(const LoopGroup& group, std::vector<Doubt>& doubts) {
  if (group.too_large())
    add_doubt(doubts, {"the loops through '" + group.graph().signals[index(group.signals().front())] +
                           "' are too many to analyse",
                       kSmaller});
  if (group.too_long())
    add_doubt(doubts, {fmt::format("a loop through '{}' takes {} frames, more than the {} that are analysed",
                                   group.graph().signals[index(group.signals().front())],
                                   group.delay_frames(), LoopGroup::kLongestDelay),
                       "shorten its delays, or check it at a lower --rate"});
  return group.too_large() || group.too_long();
}

void analyse_group(const ClosedGraph& closed, const LoopGroup& group, Hertz rate, StabilityVerdict& all,
                   RegimeVerdict& verdict) {
  const auto& graph = closed.graph;
  std::vector<Doubt> of_held;
  auto& doubts = verdict.held ? of_held : all.doubts;
  if (too_large(group, doubts)) return;
  const LoopScan scan(group, rate);
  if (!scan.complete())
    add_doubt(doubts, {"a loop through '" + graph.signals[index(group.signals().front())] +
                           "' turns too often to be followed",
                       "shorten its delays, or check it at a lower --rate"});
  verdict.growing += growing_in(graph, group.signals(), rate, &scan, doubts);
  all.sampled |= frames_between_samples(graph, group.signals()) != 1;
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

RegimeVerdict analyse_regime(const ClosedGraph& closed, const Regime& regime, Hertz rate,
                             StabilityVerdict& all) {
  RegimeVerdict verdict{.name = regime.name,
                        .certain = regime.certain,
                        .held = regime.hand.has_value(),
                        .unstable_equilibria = closed.graph.unstable_equilibria};
  std::vector<int> wanted = closed.drives;
  for (const auto& place : closed.graph.stiff) wanted.push_back(place.signal);
  for (auto& signals : loops_of(closed.graph, false))
    analyse_group(closed, {closed.graph, std::move(signals), wanted}, rate, all, verdict);
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

/// Networks of which only their growth is known.
void doubt_networks(const LinearGraph& graph, std::vector<Doubt>& doubts) {
  for (const auto& path : graph.skipped)
    if (event_loop_through(graph, path))
      add_doubt(doubts,
                {"network '" + path + "' has more than 300 numbers in its state, and loops go through it",
                 kSmaller});
}

// How many regimes are looked at where an input is held, and where a control is at another value: the rest
// is at the requested settings.
constexpr std::size_t kHeldRegimes = 1, kElsewhereRegimes = 4;

/// Stability of a world in its first regimes and those of these names, bare.
Stability stability_of(const RestingWorld& world, double push, std::size_t most_regimes,
                       std::vector<Doubt>& doubts, const std::vector<std::string>& also = {}) {
  auto all = Stability::Stable;
  const auto regimes = world.regimes(push);
  for (std::size_t r = 0; r < regimes.size(); ++r) {
    const auto& regime = regimes[r];
    if (r >= most_regimes && std::ranges::find(also, regime.name) == also.end()) continue;
    const auto closed = world.closed(regime);
    doubt_networks(closed.graph, doubts);
    for (const auto& network : closed.graph.networks)
      if (network->grows()) all = Stability::Unstable;
    for (const auto& signals : loops_of(closed.graph, false)) {
      if (too_large({closed.graph, signals, {}}, doubts)) continue;
      if (growing_in(closed.graph, signals, world.rate(), nullptr, doubts) == 0) continue;
      all = worse(all, regime.certain ? Stability::Unstable : Stability::Undecided);
    }
    if (all == Stability::Unstable) return all;
  }
  return doubts.empty() ? all : worse(all, Stability::Undecided);
}

/// A regime where an input was taken to a place that is no equilibrium. What only creeps away from there, at
/// 0 Hz, comes to another place.
struct AtPlace {
  bool grows = false;
  double border = std::numeric_limits<double>::infinity();  ///< the least factor on a cut at which it grows
};

AtPlace at_place(const RestingWorld& world, const Regime& regime) {
  constexpr std::size_t kRoots = 6;
  std::vector<Doubt> ignored;
  AtPlace found;
  const auto closed = world.closed(regime);
  std::vector<int> wanted;
  for (const auto& place : closed.graph.stiff) wanted.push_back(place.signal);
  for (auto& signals : loops_of(closed.graph, false)) {
    const LoopGroup group(closed.graph, std::move(signals), wanted);
    if (!regime.certain || too_large(group, ignored)) continue;
    const LoopScan scan(group, world.rate());
    for (int c = 0; c < std::ssize(group.cuts()); ++c)
      if (const auto margin = scan.margin(c); margin.border_hz > 0)
        found.border = std::min(found.border, margin.border);
    if (growing_in(closed.graph, group.signals(), world.rate(), &scan, ignored) == 0) continue;
    for (const auto& root : scan.roots(kRoots))
      found.grows |= root.growth_per_s > kSlowestGrowth && root.frequency_hz > 0;
  }
  return found;
}

/// The gains of what lies in loops, at some z.
std::vector<std::complex<double>> loop_gains(const LinearGraph& graph) {
  std::vector<std::complex<double>> gains;
  for (auto& signals : loops_of(graph, false)) {
    const LoopGroup group(graph, std::move(signals), {});
    for (const double turn : {0.003, 0.05, 0.7}) {
      const auto at = group.gains_at(std::polar(1.0, turn));
      gains.insert(gains.end(), at.begin(), at.end());
    }
  }
  return gains;
}

bool same(const std::vector<std::complex<double>>& a, const std::vector<std::complex<double>>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::abs(a[i] - b[i]) > 1e-6 * std::abs(a[i])) return false;
  return true;
}

class Analysis {
 public:
  Analysis(const StabilitySubject& subject, const StabilityOptions& options,
           const std::function<void(double)>& progress, int workers)
      : subject_(subject), options_(options), progress_(progress), workers_(workers) {}

  Checked<StabilityVerdict> run() {
    auto world = RestingWorld::make(subject_, options_.world);
    if (!world) return tl::unexpected(world.error());
    verdict_.rate = world->rate();
    verdict_.delay_s = world->delay_frames() / world->rate().value;
    verdict_.outside_known = world->outside_known();
    const auto regimes = world->regimes(options_.push);
    for (std::size_t i = 0; i < regimes.size(); ++i)
      if (i < kWithMargins || regimes.size() <= kAllWithMargins)
        analyse(*world, regimes[i]);
      else
        count_roots(*world, regimes[i]);
    find_event_loops(*world);
    for (std::size_t i = 0; i < std::min(regimes.size(), kAllWithMargins); ++i)
      find_open_gains(*world, regimes[i]);
    hold_places(*world);
    hold_near_rest(*world);
    hold_inputs(*world);
    keep_nearest_places();
    for (const auto& regime : verdict_.regimes)
      if (!regime.held && !regime.is_stable()) growing_.push_back(regime.name);
    find_borders(world->instrument().controls);
    auto gestures = judge_gestures(subject_, options_, verdict_.rate, [this] { report_progress(); });
    if (!gestures) return tl::unexpected(gestures.error());
    verdict_.gestures = std::move(*gestures);
    conclude();
    return std::move(verdict_);
  }

 private:
  void conclude() {
    auto& all = verdict_.stability;
    const auto unless = [&](bool stable) {
      all = worse(all, stable ? Stability::Stable : Stability::Unstable);
    };
    for (const auto& regime : verdict_.regimes) unless(regime.held || !regime.certain || regime.is_stable());
    for (const auto& regime : verdict_.regimes)
      if (!regime.certain && !regime.held && !regime.is_stable())
        add_doubt(verdict_.doubts, {"there are more combinations of nonlinearities than are analysed, and "
                                    "all at their steepest at once they grow",
                                    "split the graph, or make the nonlinearities less steep"});
    for (const auto& network : verdict_.networks) all = worse(all, network.stability());
    for (const auto& held : verdict_.held) all = worse(all, held.stability);
    for (const auto& gesture : verdict_.gestures) all = worse(all, gesture.stability);
    if (!verdict_.doubts.empty()) all = worse(all, Stability::Undecided);
  }

  void report_progress() {
    constexpr double kAll = 24;
    if (progress_) progress_(1 - std::exp(-++done_ / kAll));
  }

  /// Of many combinations the margins are not computed, but whether they grow.
  static constexpr std::size_t kAllWithMargins = 8, kWithMargins = 2;
  void count_roots(const RestingWorld& world, const Regime& regime) {
    const auto closed = world.closed(regime);
    analyse_networks(closed.graph, regime);
    RegimeVerdict verdict{.name = regime.name, .certain = regime.certain};
    for (const auto& signals : loops_of(closed.graph, false))
      if (!too_large({closed.graph, signals, {}}, verdict_.doubts))
        verdict.growing += growing_in(closed.graph, signals, verdict_.rate, nullptr, verdict_.doubts);
    verdict_.regimes.push_back(std::move(verdict));
    report_progress();
  }

  /// Bare, and held where something is driven.
  void analyse(const RestingWorld& world, const Regime& regime) {
    const auto closed = world.closed(regime);
    analyse_networks(closed.graph, regime);
    verdict_.nonlinear |= closed.graph.nonlinear;
    doubt_networks(closed.graph, verdict_.doubts);
    verdict_.regimes.push_back(analyse_regime(closed, regime, verdict_.rate, verdict_));
    report_progress();
    if (!closed.mobility || verdict_.regimes.back().loops.empty()) return;
    auto with_hand = regime;
    with_hand.hand = options_.hand;
    verdict_.regimes.push_back(analyse_regime(world.closed(with_hand), with_hand, verdict_.rate, verdict_));
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
      check_contacts(model, verdict);
      verdict.grows = model.grows();
      if (!model.whole() && !verdict.grows && !surely_stable(recipe))
        add_doubt(
            verdict_.doubts,
            {"explicit network '" + verdict.path +
                 "' has more than 300 numbers in its state: it did not grow in 4000 frames, and may later",
             "use solver = \"passive\", or a larger 'oversample'"});
      verdict_.networks.push_back(std::move(verdict));
    }
  }

  /// Other solvers than the explicit one keep the energy, or lose some; that one while k^2 times the largest
  /// eigenvalue of M^-1 (K + 2 C / k) is below 4.
  static bool surely_stable(const NetworkRecipe& recipe) {
    const double k = 1.0 / (recipe.rate.value * recipe.oversample);
    return recipe.solver != Solver::Explicit ||
           k * k * NetworkModel(recipe.elements, recipe.signals, k).stiffest(1.0, 2.0) < 4.0;
  }

  /// Of the explicit solver: the others bound the energy of a contact, however short it is.
  static void check_contacts(const LinearNetwork& model, NetworkVerdict& verdict) {
    if (model.recipe.solver != Solver::Explicit) return;
    const auto demand = contact_demand(model.written);
    for (const auto& strike : demand.strikes) {
      const double steps = strike.time_s * verdict.rate_hz, needed = strike.fewest_steps();
      if (steps / needed >= verdict.contact_steps / verdict.needed_contact_steps) continue;
      verdict.contact_steps = steps;
      verdict.needed_contact_steps = needed;
    }
    verdict.too_deep = demand.stiffness > kStiffestContact * verdict.rate_hz * verdict.rate_hz;
    if (!verdict.within_steps() && std::ranges::all_of(demand.strikes, &ContactDemand::Strike::spring))
      verdict.thrown = thrown(model);
  }

  static Stability thrown(const LinearNetwork& model) {
    constexpr double kFarther = 1.2;
    if (grows_when_thrown(model.recipe, model.written, 1.0)) return Stability::Unstable;
    return grows_when_thrown(model.recipe, model.written, kFarther) ? Stability::Undecided
                                                                    : Stability::Stable;
  }

  void find_event_loops(const RestingWorld& world) {
    const auto graph = world.closed({.all_paths = true}).graph;
    verdict_.events = graph.events;
    for (auto& event : verdict_.events) event.on_loop = event_loop_through(graph, event.path);
    doubt_unlimited_events(world.closed({}).graph);
  }

  /// Loops on which no event has to wait.
  void doubt_unlimited_events(LinearGraph graph) {
    std::erase_if(graph.edges, [](const LinearEdge& edge) { return edge.limited; });
    for (const auto& event : verdict_.events)
      if (event_loop_through(graph, event.path))
        add_doubt(verdict_.doubts, {"the loop through " + event.type + " '" + event.path +
                                        "' is event-driven, and nothing limits its events",
                                    "give it a 'hold' time, or check it with the runs", true});
  }

  /// Gains that depend on a place: with each input that reads one held where the scene takes it.
  void hold_places(const RestingWorld& world) {
    const auto at_rest = world.closed({}).graph;
    if (!at_rest.varies && !at_rest.has_touched) return;
    auto readers = world.moved_inputs();
    std::erase_if(readers, [&](int channel) { return world.unit_of_place(channel).empty(); });
    if (readers.empty()) return;
    const auto ranges = played_ranges(subject_, options_.world);
    std::vector<std::vector<std::complex<double>>> known{loop_gains(at_rest)};
    for (const int channel : readers) {
      if (index(channel) >= ranges.size() || !(ranges[index(channel)].high > ranges[index(channel)].low))
        continue;
      const auto [low, high] = ranges[index(channel)];
      constexpr int kPlaces = 5;
      for (int k = 0; k < kPlaces; ++k) {
        const double place = low + (high - low) * k / (kPlaces - 1);
        const HeldInput held{channel, place - world.resting(channel)};
        const auto then = RestingWorld::make(subject_, options_.world, {held});
        if (!then || !add_gains(*then, known)) continue;
        verdict_.held.push_back({world.instrument().input_names[index(channel)], held.level, false, place,
                                 world.unit_of_place(channel), judge_place(*then, held)});
        report_progress();
      }
    }
  }

  /// Corners that lie one behind the other at rest, as those of a dead band of no width: displaced each by
  /// itself they may cancel where a signal that moves passes them all. So each input is held a little to both
  /// sides, where every signal is where it then is.
  void hold_near_rest(const RestingWorld& world) {
    const auto at_rest = world.closed({}).graph;
    if (!at_rest.has_touched) return;
    constexpr std::size_t kMostInputs = 4;
    std::vector<std::vector<std::complex<double>>> known;
    for (const auto& regime : world.regimes(options_.push))
      known.push_back(loop_gains(world.closed(regime).graph));
    const auto moved = world.moved_inputs();
    for (std::size_t i = 0; i < std::min(moved.size(), kMostInputs); ++i)
      for (const double level : {1e-6, -1e-6, 1e-5, -1e-5, 1e-4, -1e-4, 1e-3, -1e-3}) {
        const HeldInput held{moved[i], level, false};
        const auto then = RestingWorld::make(subject_, options_.world, {held});
        if (!then) continue;
        find_open_gains(*then, {});
        if (!add_gains(*then, known)) continue;
        const auto found = at_place(*then, {});
        places_.push_back({held, 0, found.grows ? 0 : found.border});
        verdict_.held.push_back({world.instrument().input_names[index(moved[i])],
                                 level,
                                 false,
                                 {},
                                 {},
                                 found.grows ? Stability::Unstable : Stability::Stable});
        report_progress();
      }
  }

  /// False: its loops have gains that are known.
  static bool add_gains(const RestingWorld& world, std::vector<std::vector<std::complex<double>>>& known) {
    auto gains = loop_gains(world.closed({}).graph);
    if (std::ranges::any_of(known, [&](const auto& other) { return same(gains, other); })) return false;
    known.push_back(std::move(gains));
    return true;
  }

  /// To where they grow: the others have wider limits.
  void keep_nearest_places() {
    constexpr std::size_t kNearest = 2;
    std::ranges::sort(places_, {}, &HeldPlace::border);
    if (places_.size() > kNearest) places_.resize(kNearest);
  }

  Stability judge_place(const RestingWorld& there, const HeldInput& held) {
    constexpr std::size_t kMostRegimes = 16;
    auto all = Stability::Stable;
    const auto regimes = there.regimes(options_.push);
    for (std::size_t r = 0; r < std::min(regimes.size(), kMostRegimes); ++r) {
      const auto found = at_place(there, regimes[r]);
      if (found.grows) all = Stability::Unstable;
      places_.push_back({held, r, found.grows ? 0 : found.border});
    }
    return all;
  }

  /// Gains that depend on signals: with each input of the instrument held.
  void hold_inputs(const RestingWorld& world) {
    const auto at_rest = world.closed({}).graph;
    if (!at_rest.varies) return;
    const auto moved = world.moved_inputs();
    std::vector<std::vector<std::complex<double>>> known{loop_gains(at_rest)};
    const auto hold = [&](const std::vector<HeldInput>& held) {
      const auto then = RestingWorld::make(subject_, options_.world, held);
      if (!then || !add_gains(*then, known)) return;
      const auto& first = held.front();
      const auto& plan = world.instrument();
      std::vector<Doubt> doubts;
      auto stability = stability_of(*then, options_.push, kHeldRegimes, doubts);
      if (doubts.empty() && stability == Stability::Unstable && only_creeps(*then, held))
        stability = Stability::Stable;
      if (stability == Stability::Undecided || (stability == Stability::Unstable && first.alternates)) {
        stability = Stability::Undecided;
        add_doubt(verdict_.doubts,
                  {"the gains of loops vary with input '" + plan.input_names[index(first.channel)] +
                       "', and with some of them they grow",
                   "play it, or lower the gain of what is multiplied"});
      }
      if (!first.alternates && held.size() == 1 && !world.unit_of_place(first.channel).empty())
        (void)judge_place(*then, first);
      verdict_.held.push_back(
          {plan.input_names[index(first.channel)], first.level, first.alternates, {}, {}, stability});
      report_progress();
    };
    constexpr std::size_t kMostInputs = 8;
    for (std::size_t i = 0; i < moved.size() && i < kMostInputs; ++i)
      for (const bool alternates : {false, true})
        for (const double level : {1.0, -1.0, 0.1, -0.1})
          if (!alternates || level > 0) hold({{moved[i], level, alternates}});
    std::vector<HeldInput> all;
    for (const int channel : moved) all.push_back({channel, 1.0, false});
    if (moved.size() > 1) hold(all);
  }

  /// A place that is held is no equilibrium: what grows there at 0 Hz alone comes to another place, if
  /// somewhere farther it does not grow.
  bool only_creeps(const RestingWorld& there, const std::vector<HeldInput>& held) const {
    for (const auto& input : held)
      if (there.unit_of_place(input.channel).empty()) return false;
    if (at_place(there, {}).grows) return false;
    auto farther = held;
    for (int i = 0; i < kMostDoublings; ++i) {
      for (auto& input : farther) input.level *= 2;
      const auto world = RestingWorld::make(subject_, options_.world, farther);
      std::vector<Doubt> doubts;
      if (world && stability_of(*world, options_.push, kHeldRegimes, doubts) == Stability::Stable)
        return true;
    }
    return false;
  }
  static constexpr int kMostDoublings = 4;

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
        if (group.too_large() || group.too_long() || group.cut(wire) < 0) continue;
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

  bool is_stable_at(const FlatControl& control, double value) const {
    auto with = options_.world;
    with.set[control.name] = ControlValue{value};
    const auto world = RestingWorld::make(subject_, with);
    std::vector<Doubt> doubts;
    if (!world ||
        stability_of(*world, options_.push, kElsewhereRegimes, doubts, growing_) != Stability::Stable)
      return false;
    return std::ranges::all_of(places_, [&](const HeldPlace& place) {
      const auto there = RestingWorld::make(subject_, with, {place.held});
      const auto regimes = there ? there->regimes(options_.push) : std::vector<Regime>{};
      return place.regime >= regimes.size() || !at_place(*there, regimes[place.regime]).grows;
    });
  }

  void find_borders(const std::vector<PlannedControl>& controls) {
    std::vector<std::optional<ControlVerdict>> found(controls.size());
    parallel_for(
        static_cast<int>(controls.size()),
        [&](int i) { found[index(i)] = find_border(controls[index(i)].control); },
        [this](double) { report_progress(); }, workers_);
    for (auto& verdict : found)
      if (verdict) verdict_.controls.push_back(std::move(*verdict));
  }

  /// If one end is stable and the other is not, the border between them. Nothing without both ends.
  std::optional<ControlVerdict> find_border(const FlatControl& control) const {
    ControlVerdict verdict{.control = control};
    double low = control.range.low, high = control.range.high;
    if (!std::isfinite(low) || !std::isfinite(high)) return std::nullopt;
    verdict.stable_low = is_stable_at(control, low);
    verdict.stable_high = is_stable_at(control, high);
    if (verdict.stable_low != verdict.stable_high) {
      for (int i = 0; i < kMostHalvings && !close(low, high); ++i) {
        const double middle = low > 0 && high > 0 ? std::sqrt(low * high) : 0.5 * (low + high);
        (is_stable_at(control, middle) == verdict.stable_low ? low : high) = middle;
      }
      verdict.border = verdict.stable_low ? low : high;
    }
    return verdict;
  }

  static constexpr int kMostHalvings = 40;
  /// Within a thousandth of the value, however large the range is.
  static bool close(double low, double high) {
    return high - low <= 1e-3 * std::max(std::abs(low), std::abs(high));
  }

  const StabilitySubject& subject_;
  const StabilityOptions& options_;
  const std::function<void(double)>& progress_;
  const int workers_;
  double done_ = 0;
  struct HeldPlace {
    HeldInput held;
    std::size_t regime = 0;
    double border = 0;  ///< see AtPlace; 0 if it grows
  };
  std::vector<HeldPlace> places_;     ///< the nearest to growth
  std::vector<std::string> growing_;  ///< the regimes in which it grows
  StabilityVerdict verdict_;
};

}  // namespace

bool StabilityVerdict::has_undecided_part() const {
  const auto undecided = [](Stability part) { return part == Stability::Undecided; };
  return std::ranges::any_of(networks, undecided, &NetworkVerdict::stability) ||
         std::ranges::any_of(gestures, undecided, &GestureVerdict::stability) ||
         std::ranges::any_of(held, undecided, &HeldVerdict::stability);
}

Stability NetworkVerdict::stability() const {
  if (grows) return Stability::Unstable;
  if (within_steps()) return Stability::Stable;
  return thrown.value_or(Stability::Unstable);
}

Stability stability_with(const StabilitySubject& subject, const WorldOptions& options, double push) {
  const auto world = RestingWorld::make(subject, options);
  std::vector<Doubt> doubts;
  return world ? stability_of(*world, push, kElsewhereRegimes, doubts) : Stability::Unstable;
}

Checked<StabilityVerdict> analyse_stability(const StabilitySubject& subject, const StabilityOptions& options,
                                            const std::function<void(double)>& progress, int workers) {
  return Analysis{subject, options, progress, workers}.run();
}

}  // namespace tactus
