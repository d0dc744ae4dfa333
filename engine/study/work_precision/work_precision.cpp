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
#include "engine/scene/closed_loop.h"
#include "engine/scene/measures/measure.h"
#include "engine/study/sweep/scene_variants.h"
#include "engine/study/sweep/sweep.h"

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
  /// `recording` of the same scene, built in the same way; it may go.
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

/// Rates, solvers and oversampling to try.
std::vector<SweptValue> swept_by(const WorkPrecisionOptions& options, Hertz rate) {
  std::vector<SweptValue> over{
      {"rate", {}, SweptValue::What::Rate},
      {"solver",
       {},
       SweptValue::What::Solver,
       options.solvers.empty() ? stepping_solvers() : options.solvers},
      {"oversample", {options.oversamples.begin(), options.oversamples.end()}, SweptValue::What::Oversample}};
  for (const auto tried : options.rates) over[0].values.emplace_back(tried.value);
  if (options.rates.empty()) over[0].values = {0.5 * rate.value, rate.value, 2 * rate.value};
  for (std::size_t i = 0; i < over[1].names.size(); ++i) over[1].values.emplace_back(static_cast<double>(i));
  if (options.oversamples.empty()) over[2].values = {1, 2, 4, 8, 16};
  return over;
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

/// Finds the errors of all variants, then takes their times. A run is its outcome, how far the reference may
/// be off at its rate, and its errors.
class Study {
 public:
  /// Nothing in `over`: the scene as it is written.
  Study(const SceneSpec& scene, const NodeTable& table, const RunPlan& runs, std::vector<SweptValue> over,
        int repeats)
      : scene_(scene), table_(table), repeats_(repeats), key_("work precision") {
    static_cast<RunPlan&>(plan_) = runs;
    plan_.over = std::move(over);
    for (const auto& accuracy : scene.accuracy)
      key_ += measure_key(accuracy) + fmt::format(" {} {}", accuracy.exact.value_or(QuantityValue{}).si,
                                                  accuracy.scale.value_or(QuantityValue{}).si);
  }

  Checked<WorkPrecision> run() {
    result_.scene = scene_.name;
    for (const auto& accuracy : scene_.accuracy)
      result_.references.push_back({accuracy.name, accuracy.measure, accuracy.of,
                                    accuracy.exact ? "closed form" : describe_reference(scene_)});
    const auto progress = std::exchange(plan_.progress, {});
    if (progress) plan_.progress = [&](double share) { progress(0.5 * share); };
    auto evaluated = sweep().evaluate([this](const Sweep::Run& run) { return find_errors(run); }, key_);
    if (!evaluated) return tl::unexpected(evaluated.error());
    result_.runs = std::ssize(*evaluated) + repeats_;
    result_.finished = finished(*evaluated);
    if (plan_.parts > 1 || result_.finished < std::ssize(*evaluated)) return std::move(result_);
    for (std::size_t i = 0; i < evaluated->size(); ++i) add_point(i, (*evaluated)[i]);
    if (progress) plan_.progress = [&](double share) { progress(0.5 + 0.5 * share); };
    if (auto status = take_times(); !status) return tl::unexpected(status.error());
    for (std::size_t a = 0; a < scene_.accuracy.size(); ++a) find_front(a);
    return std::move(result_);
  }

 private:
  struct Reference {
    SceneRecording recording;
    std::vector<double> floors;  ///< how far two references are apart; 0 where theory gives the number
  };

  Sweep sweep() const { return {scene_, table_, plan_}; }

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
    std::vector<double> floors;
    for (const auto& accuracy : scene_.accuracy)
      floors.push_back(accuracy.exact ? 0 : accuracy_error(accuracy, *second, *first).value_or(1));
    reference = {std::move(*first), std::move(floors)};
    return &*reference;
  }

  /// Plays a variant and keeps its timer. Errors: its network cannot be stepped so.
  Checked<SceneRecording> play(const Sweep::Run& run) {
    auto built = build_scene(run.scene, table_);
    if (!built) return tl::unexpected(built.error());
    auto recording = play_run(run, table_);
    if (!recording) return recording;
    auto timer = std::make_unique<PlantTimer>(std::move(*built), run.scene, *recording);
    const std::lock_guard lock{keeping_};
    timers_[run.number] = std::move(timer);
    return recording;
  }

  Checked<RunResult> find_errors(const Sweep::Run& run) {
    const auto reference = refer(run.scene);
    if (!reference) return tl::unexpected(reference.error());
    const auto& [expected, floors] = **reference;
    RunResult numbers{kRefused};
    numbers.insert(numbers.end(), floors.begin(), floors.end());
    const auto recording = play(run);
    if (!recording) return numbers;
    const bool unstable = std::ranges::any_of(
        scene_.accuracy, [&](const auto& accuracy) { return exploded(accuracy, *recording, expected); });
    numbers[0] = unstable ? kUnstable : kStable;
    for (const auto& accuracy : scene_.accuracy)
      if (!unstable) numbers.push_back(accuracy_error(accuracy, *recording, expected).value_or(1));
    return numbers;
  }

  void add_point(std::size_t number, const SweepPoint& swept) {
    auto& point = result_.points.emplace_back();
    point.variant = {"as written", 0, scene_.rate};
    if (!swept.at.empty())
      point.variant = {plan_.over[1].names[static_cast<std::size_t>(swept.at[1])],
                       static_cast<int>(swept.at[2]), Hertz{swept.at[0]}};
    const auto& numbers = *swept.result;
    const auto count = scene_.accuracy.size();
    for (std::size_t a = 0; a < count && a + 1 < numbers.size(); ++a)
      result_.references[a].own_error = std::max(result_.references[a].own_error, numbers[a + 1]);
    const double outcome = numbers.empty() ? kRefused : numbers.front();
    point.unstable = outcome == kUnstable;
    if (outcome == kRefused)
      if (const auto again = play(sweep().run_of(number)); !again) point.refused = again.error().front();
    if (outcome != kStable || numbers.size() != 1 + 2 * count) return;
    const auto errors = numbers.end() - static_cast<std::ptrdiff_t>(count);
    point.floors.assign(numbers.begin() + 1, errors);
    point.errors.assign(errors, numbers.end());
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
        if (!timers_.contains(i))  // its errors were cached
          if (const auto played = play(sweep().run_of(i)); !played) return tl::unexpected(played.error());
        times_ns.push_back(timers_[i]->ns_per_frame());
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
    for (std::size_t i = 0; i < result_.points.size(); ++i) print.add(run_key(key_, sweep().run_of(i)));
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

  const SceneSpec& scene_;
  const NodeTable& table_;
  SweepPlan plan_;
  int repeats_;
  std::string key_;
  std::mutex referring_, keeping_;
  std::map<double, std::optional<Reference>> references_;  ///< by rate
  std::map<std::size_t, std::unique_ptr<PlantTimer>> timers_;
  WorkPrecision result_;
};

/// Without a network there is no solver, and without [accuracy] no error.
std::optional<Error> missing_section(const SceneSpec& scene) {
  if (scene.accuracy.empty())
    return Error{
        Errc::Missing, scene.file.text(), "the scene does not list the measures to compare",
        "add [accuracy] with an entry such as path = { measure = \"position\", of = \"plant.stick\" }"};
  if (!has_network(scene))
    return Error{Errc::Missing, scene.file.text(),
                 "no part of the scene has a network, so there is no solver to choose",
                 "study another scene"};
  return std::nullopt;
}

}  // namespace

std::string to_string(const SolverVariant& variant) {
  const auto steps = variant.oversample == 0 ? "" : fmt::format(" x {}", variant.oversample);
  return fmt::format("{}{} at {:g} kHz", variant.solver, steps, variant.rate.value / 1e3);
}

const WorkPoint* WorkPrecision::cheapest(double error) const {
  const WorkPoint* best = nullptr;
  for (const auto& point : points) {
    if (!point.known() || point.load() >= 1) continue;
    if (*std::ranges::max_element(point.errors) > error) continue;
    if (best == nullptr || point.load() < best->load()) best = &point;
  }
  return best;
}

Checked<WorkPrecision> study_work_precision(const SceneSpec& scene, const NodeTable& table,
                                            const WorkPrecisionOptions& options) {
  if (auto missing = missing_section(scene)) return tl::unexpected(std::vector{*missing});
  return Study{scene, table, options, swept_by(options, scene.rate), options.repeats}.run();
}

Checked<WorkPrecision> evaluate_as_written(const SceneSpec& scene, const NodeTable& table) {
  if (auto missing = missing_section(scene)) return tl::unexpected(std::vector{*missing});
  return Study{scene, table, {}, {}, WorkPrecisionOptions{}.repeats}.run();
}

}  // namespace tactus
