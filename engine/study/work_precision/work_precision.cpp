#include "engine/study/work_precision/work_precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "engine/core/decibels.h"
#include "engine/core/median.h"
#include "engine/graph/file/quantity.h"
#include "engine/nodes/networks/network.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/measures/measure.h"
#include "engine/study/sweep/scene_variants.h"
#include "engine/study/sweep/sweep.h"
#include "engine/study/work_precision/methods/methods.h"

namespace tactus {
namespace {

double processor_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// An instrument that gives out what was recorded.
class Replay final : public BlockProcessor {
 public:
  explicit Replay(const SceneRecording& recording) {
    for (const auto& name : recording.outputs)
      drives_.push_back(recording.find("instrument." + name)->samples);
  }
  Status prepare(const StreamFormat&) override {
    next_ = 0;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (std::size_t c = 0; c < drives_.size(); ++c)
      std::copy_n(drives_[c].data() + next_, io.frames, io.out[c]);
    next_ += io.frames;
  }
  int outputs() const { return static_cast<int>(drives_.size()); }

 private:
  std::vector<std::vector<double>> drives_;
  std::ptrdiff_t next_ = 0;
};

/// Times a scene's plant alone, its schedule in blocks of 64 frames: what the instrument gave out was
/// recorded and is played back to it, and nothing is recorded, converted or guarded.
class PlantTimer {
 public:
  /// `recording` of the same scene; it may go.
  PlantTimer(BuiltScene built, const SceneSpec& scene, const SceneRecording& recording)
      : built_(std::move(built)),
        replay_(recording),
        loop_(replay_, *built_.plant, replay_.outputs(), built_.delay_frames, Converters{.on = false}),
        rate_(recording.sample_rate),
        frames_(static_cast<int>(frames_in(scene.duration, rate_))) {
    const double share = kMaxTimingDuration_s / std::max(kMaxTimingDuration_s, recording.run_seconds);
    frames_ = std::max(std::min(frames_, kTimedBlock), static_cast<int>(frames_ * share));
  }

  /// What a frame takes [ns]: runs it once more from the start, all of it or as much as takes about 0.3 s, a
  /// short one over and over for 3 ms.
  double ns_per_frame() {
    double taken_s = 0, frames = 0;
    while (taken_s < kShortestTiming_s && frames < 1e9) {
      if (!loop_.prepare(rate_, kTimedBlock)) return std::numeric_limits<double>::quiet_NaN();
      const double started_s = processor_s();
      loop_.run(frames_);
      taken_s += processor_s() - started_s;
      frames += frames_;
    }
    return 1e9 * taken_s / frames;
  }

  const Plan& plan() const { return built_.plant->plan(); }
  /// Its networks, each timed in one more run.
  std::vector<NetworkReport> networks() {
    StepTimes times{*built_.plant};
    if (loop_.prepare(rate_, kTimedBlock))
      loop_.run(frames_, [&](const ClosedLoop::Block& block) { times.add(block.frames); });
    return report_networks(built_.plant->plan(), times.ns_per_frame());
  }

 private:
  static constexpr int kTimedBlock = 64;
  static constexpr double kMaxTimingDuration_s = 0.3;
  static constexpr double kShortestTiming_s = 3e-3;  // the processor's clock counts microseconds

  BuiltScene built_;
  Replay replay_;
  ClosedLoop loop_;
  Hertz rate_;
  int frames_;
};

std::string describe_reference(const SceneSpec& scene) {
  return is_linear(scene) ? "the linear motion: matrix exponential, or integration where that is too large"
                          : "integration from event to event";
}

constexpr auto kAuto = "auto";

/// Rates, solvers and oversampling to try. `auto` decides on its oversampling itself.
std::vector<SolverVariant> variants_of(const WorkPrecisionOptions& options, Hertz rate) {
  auto rates = options.rates;
  if (rates.empty()) rates = {Hertz{0.5 * rate.value}, rate, Hertz{2 * rate.value}};
  const auto solvers = options.solvers.empty() ? studied_solvers() : options.solvers;
  auto oversamples = options.oversamples;
  if (oversamples.empty()) oversamples = {1, 2, 4, 8, 16};
  std::vector<SolverVariant> variants;
  for (const auto tried : rates)
    for (const auto& solver : solvers)
      if (solver == kAuto)
        variants.push_back({solver, 0, tried});
      else
        for (const int oversample : oversamples) variants.push_back({solver, oversample, tried});
  return variants;
}

template <class Plan>
auto views_of(Plan& plan) {
  std::vector<NetworkView*> views;
  for (const auto& node : plan.nodes)
    if (auto* view = dynamic_cast<NetworkView*>(node.get())) views.push_back(view);
  return views;
}

/// Multiplications of a frame, as `SolverBounds` counts them.
double multiplications_of(const Plan& plan) {
  double sum = 0;
  for (const auto* view : views_of(plan)) {
    const auto cost = view->network.network_solver().cost();
    const double contact = view->recipe.elements.contacts.empty() ? 0.0 : cost.contact;
    sum += view->network.oversample() * (cost.step + contact);
  }
  return sum;
}

/// Multiplications of the cheapest solvers whose bounds are at most `error`; nothing: a network has none.
std::optional<double> cheapest_bounded(const Plan& plan, double error) {
  double sum = 0;
  for (const auto* view : views_of(plan)) {
    double least = std::numeric_limits<double>::infinity();
    for (int steps = 1; steps <= kMostOversample; steps *= 2)
      for (const auto& bounds : choose_solver(view->recipe.elements, view->recipe.rate, steps).candidates)
        if (bounds.stable && bounds.bounded() && bounds.error <= error)
          least = std::min(least, bounds.multiplications);
    sum += least;
  }
  return std::isfinite(sum) ? std::optional{sum} : std::nullopt;
}

/// Puts a published method in the place of every solver. Errors: BadArgument, where it does not apply.
Status use_method(const Plan& plan, const PublishedMethod& method, int oversample) {
  for (auto* view : views_of(plan)) {
    const auto& recipe = view->recipe;
    if (auto why = why_not_applicable(recipe.elements); !why.empty())
      return fail(Errc::BadArgument, method.name, "not applicable: " + why, "compare other solvers");
    view->network = Network::make(recipe.elements, recipe.signals, recipe.rate, oversample, method.make);
    view->state = view->network.initial_state();
  }
  return {};
}

/// What is compared where a scene does not say so: the paths of positions, or of everything that its parts
/// with networks give.
std::vector<Accuracy> default_accuracy(const SceneSpec& scene, const std::vector<SceneTap>& taps) {
  static const auto metre = parse_unit("m")->dimension;
  std::vector<Accuracy> positions, all;
  for (const auto& tap : taps) {
    const auto part = tap.name.substr(0, tap.name.find('.'));
    auto alone = scene;
    std::erase_if(alone.parts, [&](const ScenePart& other) { return other.name != part; });
    if (!has_network(alone)) continue;
    Accuracy path;
    path.name = tap.name.substr(part.size() + 1);
    path.measure = "position";
    path.of = tap.name;
    all.push_back(path);
    if (tap.dimension == metre) positions.push_back(path);
  }
  return positions.empty() ? all : positions;
}

/// Non-finite values, or ten times the size that they may have.
bool exploded(const Accuracy& accuracy, const SceneRecording& run, const SceneRecording& reference) {
  constexpr double kExplosion = 10.0;
  if (!run.faults.empty()) return true;
  const auto& samples = run.find(accuracy.of)->samples;
  if (!std::ranges::all_of(samples, [](double x) { return std::isfinite(x); })) return true;
  const double most =
      std::max(peak_of(reference.find(accuracy.of)->samples), accuracy.scale ? accuracy.scale->si : 0);
  return peak_of(samples) > kExplosion * most && most > 0;
}

/// The outcome of a run.
constexpr double kStable = 0, kUnstable = 1, kRefused = 2;

/// Finds the errors of all variants, then takes their times. A run is its outcome, its multiplications, how
/// far the reference may be off at its rate, and its errors.
class Study {
 public:
  Study(SceneSpec scene, const NodeTable& table, const WorkPrecisionOptions& options,
        std::vector<SolverVariant> variants)
      : scene_(std::move(scene)),
        table_(table),
        plan_(options),
        repeats_(options.repeats),
        variants_(std::move(variants)) {
    result_.scene = scene_.name;
    result_.rate = scene_.rate;
    result_.tolerance = options.tolerance;
  }

  Checked<WorkPrecision> run() {
    if (auto begun = begin(); !begun) return tl::unexpected(begun.error());
    const auto progress = std::exchange(plan_.progress, {});
    if (progress) plan_.progress = [&](double share) { progress(0.5 * share); };
    const auto count = static_cast<int>(variants_.size());
    auto evaluated = evaluate_runs(
        plan_, count, [&](int i) { return key_of(index(i)); }, [&](int i) { return find_errors(index(i)); });
    if (!evaluated) return tl::unexpected(evaluated.error());
    result_.runs = count + repeats_;
    result_.finished = std::ranges::count_if(*evaluated, [](const auto& run) { return run.has_value(); });
    if (plan_.parts > 1 || result_.finished < count) return std::move(result_);
    for (std::size_t i = 0; i < evaluated->size(); ++i) add_point(i, *(*evaluated)[i]);
    if (progress) plan_.progress = [&](double share) { progress(0.5 + 0.5 * share); };
    if (auto status = take_times(); !status) return tl::unexpected(status.error());
    for (std::size_t i = 0; i < variants_.size(); ++i) report_networks_of(i);
    for (std::size_t a = 0; a < scene_.accuracy.size(); ++a) find_front(a);
    return std::move(result_);
  }

 private:
  struct Reference {
    SceneRecording recording;
    std::vector<double> floors;  ///< how far two references are apart; 0 where theory gives the number
  };

  /// Finds what is compared. Errors: those of the scene.
  Checked<void> begin() {
    const auto built = build_scene(scene_, table_);
    if (!built) return tl::unexpected(built.error());
    if (scene_.accuracy.empty()) {
      scene_.accuracy = default_accuracy(scene_, built->plant_taps);
      const auto reference = refer(scene_);
      if (!reference) return tl::unexpected(reference.error());
      std::erase_if(scene_.accuracy, [&](const Accuracy& path) {
        return peak_of((*reference)->recording.find(path.of)->samples) == 0.0;
      });
      references_.clear();
    }
    if (scene_.accuracy.empty())
      return tl::unexpected(std::vector{
          Error{Errc::Missing, scene_.file.text(), "no output of a part with a network moves in the scene",
                "add [accuracy] with an entry such as path = { measure = \"position\", of = "
                "\"plant.stick\" }"}});
    key_ = "work precision";
    for (const auto& accuracy : scene_.accuracy) {
      key_ += measure_key(accuracy) + fmt::format(" {} {}", accuracy.exact.value_or(QuantityValue{}).si,
                                                  accuracy.scale.value_or(QuantityValue{}).si);
      result_.references.push_back({accuracy.name, accuracy.measure, accuracy.of,
                                    accuracy.exact ? "closed form" : describe_reference(scene_)});
    }
    return {};
  }

  /// Published methods take the place of explicit steps, which every network can be made with.
  SceneSpec scene_of(const SolverVariant& variant) const {
    auto scene = scene_;
    scene.rate = variant.rate;
    if (variant.solver == kAsWritten) return scene;
    const bool published = find_method(variant.solver) != nullptr;
    scene = with_network_option(std::move(scene), "solver", published ? "explicit" : variant.solver);
    const auto remove = [](NetworkSpec& network, const std::string&) {
      std::erase_if(network.fields, [](const Field& field) { return field.key == "oversample"; });
    };
    if (variant.oversample == 0) return with_networks_changed(std::move(scene), remove, false);
    return with_network_option(std::move(scene), "oversample", static_cast<double>(variant.oversample));
  }

  std::uint64_t key_of(std::size_t number) const {
    const auto& variant = variants_[number];
    return run_key(key_ + variant.solver, {{}, scene_of(variant), {}, number});
  }

  /// The reference solution at the rate of a scene. Its own error is its difference from one of three steps a
  /// frame: with two, the parts into which the exponential of a step is divided would be the same, and so
  /// would their rounding.
  Checked<const Reference*> refer(const SceneSpec& scene) {
    const std::lock_guard lock{referring_};
    auto& reference = references_[scene.rate.value];
    if (reference) return &*reference;
    const auto solved = with_network_option(scene, "solver", "reference");
    auto first = play_run({{}, with_network_option(solved, "oversample", 1.0)}, table_);
    if (!first) return tl::unexpected(first.error());
    const auto second = play_run({{}, with_network_option(solved, "oversample", 3.0)}, table_);
    if (!second) return tl::unexpected(second.error());
    // What was not followed to the end is no reference.
    const bool failed = !first->faults.empty() || !second->faults.empty();
    std::vector<double> floors;
    for (const auto& accuracy : scene_.accuracy)
      floors.push_back(accuracy.exact ? 0
                       : failed       ? 1
                                      : accuracy_error(accuracy, *second, *first).value_or(1));
    reference = {std::move(*first), std::move(floors)};
    return &*reference;
  }

  struct Played {
    SceneRecording recording;
    double multiplications;
  };
  /// Plays a variant and keeps its timer. Errors: its network cannot be stepped so.
  Checked<Played> play(std::size_t number) {
    constexpr int kBlock = 64;
    const auto& variant = variants_[number];
    const auto scene = scene_of(variant);
    auto built = build_scene(scene, table_);
    if (!built) return tl::unexpected(built.error());
    const auto& plan = built->plant->plan();
    if (const auto* method = find_method(variant.solver))
      if (const auto used = use_method(plan, *method, variant.oversample); !used)
        return tl::unexpected(std::vector{used.error()});
    auto recording = play_scene(scene, *built, kBlock);
    if (!recording) return tl::unexpected(std::vector{recording.error()});
    const double multiplications = multiplications_of(plan);
    auto timer = std::make_unique<PlantTimer>(std::move(*built), scene, *recording);
    const std::lock_guard lock{keeping_};
    timers_[number] = std::move(timer);
    return Played{std::move(*recording), multiplications};
  }

  Checked<RunResult> find_errors(std::size_t number) {
    const auto reference = refer(scene_of(variants_[number]));
    if (!reference) return tl::unexpected(reference.error());
    const auto& [expected, floors] = **reference;
    RunResult numbers{kRefused, 0.0};
    numbers.insert(numbers.end(), floors.begin(), floors.end());
    const auto played = play(number);
    if (!played) return numbers;
    const auto& recording = played->recording;
    const bool unstable = std::ranges::any_of(
        scene_.accuracy, [&](const auto& accuracy) { return exploded(accuracy, recording, expected); });
    numbers[0] = unstable ? kUnstable : kStable;
    numbers[1] = played->multiplications;
    for (const auto& accuracy : scene_.accuracy)
      if (!unstable) numbers.push_back(accuracy_error(accuracy, recording, expected).value_or(1));
    return numbers;
  }

  void add_point(std::size_t number, const RunResult& numbers) {
    auto& point = result_.points.emplace_back();
    point.variant = variants_[number];
    point.multiplications = numbers[1];
    const auto count = scene_.accuracy.size();
    for (std::size_t a = 0; a < count; ++a)
      result_.references[a].own_error = std::max(result_.references[a].own_error, numbers[a + 2]);
    point.unstable = numbers[0] == kUnstable;
    if (numbers[0] == kRefused)
      if (const auto again = play(number); !again) point.refused = again.error().front();
    if (numbers[0] != kStable || numbers.size() != 2 + 2 * count) return;
    const auto errors = numbers.end() - static_cast<std::ptrdiff_t>(count);
    point.floors.assign(numbers.begin() + 2, errors);
    point.errors.assign(errors, numbers.end());
  }

  /// The timer of a variant whose errors may have been cached.
  Checked<PlantTimer*> timer_of(std::size_t number) {
    if (!timers_.contains(number))
      if (const auto played = play(number); !played) return tl::unexpected(played.error());
    return timers_[number].get();
  }

  /// Choices and bounds, of those variants that do not name a solver themselves.
  void report_networks_of(std::size_t number) {
    auto& point = result_.points[number];
    if (!point.is_auto() && point.variant.solver != kAsWritten) return;
    if (point.refused) return;
    const auto timer = timer_of(number);
    if (!timer) return;
    point.networks = (*timer)->networks();
    if (point.is_auto()) point.cheapest_bounded = cheapest_bounded((*timer)->plan(), result_.tolerance);
  }

  /// Every repeat takes all variants, so that a disturbance of the machine affects all of them.
  Checked<void> take_times() {
    plan_.workers = 1;
    std::vector<std::size_t> timed;
    for (std::size_t i = 0; i < result_.points.size(); ++i)
      if (result_.points[i].known()) timed.push_back(i);
    const auto time_all = [&](int) -> Checked<RunResult> {
      RunResult times_ns;
      for (const auto i : timed) {
        const auto timer = timer_of(i);
        if (!timer) return tl::unexpected(timer.error());
        times_ns.push_back((*timer)->ns_per_frame());
      }
      return times_ns;
    };
    const auto times_ns = evaluate_runs(
        plan_, repeats_, [&](int r) { return time_key(r); }, time_all);
    if (!times_ns) return tl::unexpected(times_ns.error());
    for (std::size_t t = 0; t < timed.size(); ++t) {
      std::vector<double> of_point;
      for (const auto& repeat : *times_ns)
        if (repeat && t < repeat->size()) of_point.push_back((*repeat)[t]);
      result_.points[timed[t]].ns_per_frame = median(std::move(of_point));
    }
    result_.finished += std::ranges::count_if(*times_ns, [](const auto& repeat) { return !!repeat; });
    return {};
  }

  std::uint64_t time_key(int repeat) const {
    Fingerprint print;
    for (std::size_t i = 0; i < result_.points.size(); ++i) print.add(key_of(i));
    return print.add("times").add(static_cast<std::uint64_t>(repeat)).value();
  }

  void find_front(std::size_t a) {
    for (auto& point : result_.points) {
      const auto beats = [&](const WorkPoint& other) {
        return other.known() && other.load() <= point.load() && other.errors[a] <= point.errors[a] &&
               (other.load() < point.load() || other.errors[a] < point.errors[a]);
      };
      if (point.known()) point.front.push_back(std::ranges::none_of(result_.points, beats));
    }
  }

  SceneSpec scene_;
  const NodeTable& table_;
  RunPlan plan_;
  int repeats_;
  std::vector<SolverVariant> variants_;
  std::string key_;
  std::mutex referring_, keeping_;
  std::map<double, std::optional<Reference>> references_;  ///< by rate
  std::map<std::size_t, std::unique_ptr<PlantTimer>> timers_;
  WorkPrecision result_;
};

/// Without a network there is no solver.
std::optional<Error> missing_network(const SceneSpec& scene) {
  if (has_network(scene)) return std::nullopt;
  return Error{Errc::Missing, scene.file.text(),
               "no part of the scene has a network, so there is no solver to choose", "study another scene"};
}

}  // namespace

std::string to_string(const SolverVariant& variant) {
  const auto steps = variant.oversample == 0 ? "" : fmt::format(" x {}", variant.oversample);
  return fmt::format("{}{} at {:g} kHz", variant.solver, steps, variant.rate.value / 1e3);
}

std::vector<std::string> studied_solvers() {
  auto names = stepping_solvers();
  names.emplace_back(kAuto);
  for (const auto& method : published_methods()) names.emplace_back(method.name);
  return names;
}

double WorkPoint::largest_error() const { return *std::ranges::max_element(errors); }

bool WorkPoint::is_published() const { return find_method(variant.solver) != nullptr; }

std::optional<double> WorkPoint::error_bound() const {
  if (networks.empty()) return std::nullopt;
  double most = 0;
  for (const auto& network : networks) {
    const auto bound = network.error_bound();
    if (!bound) return std::nullopt;
    most = std::max(most, *bound);
  }
  return most;
}

const WorkPoint* WorkPrecision::cheapest(double error) const {
  const WorkPoint* best = nullptr;
  for (const auto& point : points) {
    if (!point.known() || point.is_published() || point.is_auto() || point.load() >= 1) continue;
    if (point.largest_error() > error) continue;
    if (best == nullptr || point.load() < best->load()) best = &point;
  }
  return best;
}

std::vector<AutoCost> WorkPrecision::auto_costs() const {
  std::vector<AutoCost> costs;
  for (const auto& chosen : points) {
    if (!chosen.is_auto() || !chosen.known()) continue;
    auto& cost = costs.emplace_back(AutoCost{&chosen, nullptr, nullptr});
    for (const auto& other : points) {
      if (other.variant.rate != chosen.variant.rate || other.is_auto()) continue;
      if (!other.known() || other.largest_error() > tolerance) continue;
      auto& best = other.is_published() ? cost.published : cost.cheapest;
      if (best == nullptr || other.multiplications < best->multiplications) best = &other;
    }
  }
  return costs;
}

Checked<WorkPrecision> study_work_precision(const SceneSpec& scene, const NodeTable& table,
                                            const WorkPrecisionOptions& options) {
  if (auto missing = missing_network(scene)) return tl::unexpected(std::vector{*missing});
  return Study{scene, table, options, variants_of(options, scene.rate)}.run();
}

Checked<WorkPrecision> evaluate_as_written(const SceneSpec& scene, const NodeTable& table) {
  if (auto missing = missing_network(scene)) return tl::unexpected(std::vector{*missing});
  return Study{scene, table, {}, {{kAsWritten, 0, scene.rate}}}.run();
}

}  // namespace tactus
