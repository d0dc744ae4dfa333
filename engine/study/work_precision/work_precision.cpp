#include "engine/study/work_precision/work_precision.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <memory>

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

  /// Runs it once more from the start, all of it or as much as takes about 0.3 s, a short one over and over
  /// for 3 ms, and keeps what a frame took.
  void run() {
    double taken_s = 0, frames = 0;
    while (taken_s < kShortestTiming_s && frames < 1e9) {
      if (!loop_.prepare(rate_, kTimedBlock)) return;
      const double started_s = processor_s();
      loop_.run(frames_);
      taken_s += processor_s() - started_s;
      frames += frames_;
    }
    runs_ns_.push_back(1e9 * taken_s / frames);
  }
  /// Median of the runs. [ns]
  double ns_per_frame() const { return median(runs_ns_); }

 private:
  static constexpr int kTimedBlock = 64;
  static constexpr double kMaxTimingDuration_s = 0.3;
  static constexpr double kShortestTiming_s = 3e-3;  // the processor's clock counts microseconds

  BuiltScene built_;
  Replay replay_;
  ClosedLoop loop_;
  Hertz rate_;
  int frames_;
  std::vector<double> runs_ns_;
};

std::string describe_reference(const SceneSpec& scene) {
  return is_linear(scene) ? "the linear motion: matrix exponential, or integration where that is too large"
                          : "integration from event to event";
}

WorkPrecisionOptions completed(WorkPrecisionOptions options, Hertz rate) {
  if (options.solvers.empty()) options.solvers = stepping_solvers();
  if (options.rates.empty()) options.rates = {Hertz{0.5 * rate.value}, rate, Hertz{2 * rate.value}};
  if (options.oversamples.empty()) options.oversamples = {1, 2, 4, 8, 16};
  return options;
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

class Study {
 public:
  Study(const SceneSpec& scene, const NodeTable& table, const WorkPrecisionOptions& options)
      : scene_(scene), table_(table), options_(completed(options, scene.rate)) {
    runs_ = options_.rates.size() * options_.solvers.size() * options_.oversamples.size();
  }

  Checked<WorkPrecision> run() {
    name_references();
    SweepPlan plan;
    plan.workers = 1;  // times are measured
    plan.over = {{"rate", {}, SweptValue::What::Rate},
                 {"solver", {}, SweptValue::What::Solver, options_.solvers},
                 {"oversample", {}, SweptValue::What::Oversample}};
    for (const auto rate : options_.rates) plan.over[0].values.emplace_back(rate.value);
    for (std::size_t i = 0; i < options_.solvers.size(); ++i)
      plan.over[1].values.emplace_back(static_cast<double>(i));
    for (const int oversample : options_.oversamples) plan.over[2].values.emplace_back(oversample);
    std::optional<SceneRecording> reference;
    const auto points = Sweep{scene_, table_, plan}.evaluate(
        [&](const Sweep::Run& run) -> Checked<RunResult> {
          if (!reference || reference->sample_rate != run.scene.rate) {
            auto referred = refer(run.scene);
            if (!referred) return tl::unexpected(referred.error());
            reference = std::move(*referred);
          }
          const SolverVariant variant{options_.solvers[static_cast<std::size_t>(run.at[1])],
                                      static_cast<int>(run.at[2]), run.scene.rate};
          report(static_cast<double>(result_.points.size()), to_string(variant));
          return play(run.scene, variant, *reference).errors;
        },
        "work precision");
    if (!points) return tl::unexpected(points.error());
    return finish();
  }

  Checked<WorkPrecision> run_as_written() {
    name_references();
    runs_ = 1;
    const auto reference = refer(scene_);
    if (!reference) return tl::unexpected(reference.error());
    play(scene_, {"as written", 0, scene_.rate}, *reference);
    return finish();
  }

 private:
  void name_references() {
    result_.scene = scene_.name;
    for (const auto& accuracy : scene_.accuracy)
      result_.references.push_back({accuracy.name, accuracy.measure, accuracy.of,
                                    accuracy.exact ? "closed form" : describe_reference(scene_)});
  }

  WorkPrecision finish() {
    take_times();
    for (std::size_t a = 0; a < scene_.accuracy.size(); ++a) find_front(a);
    return std::move(result_);
  }

  void report(double runs, const std::string& what) const {
    if (options_.progress) options_.progress(runs / static_cast<double>(2 * runs_), what);
  }

  /// The reference solution at the rate of a scene. Its own error is its difference from one with half the
  /// step size.
  Checked<SceneRecording> refer(const SceneSpec& scene) {
    report(static_cast<double>(result_.points.size()), "reference");
    const auto solved = with_network_option(scene, "solver", "reference");
    auto first = play_run({{}, with_network_option(solved, "oversample", 1.0)}, table_);
    if (!first) return tl::unexpected(first.error());
    const auto second = play_run({{}, with_network_option(solved, "oversample", 2.0)}, table_);
    if (!second) return tl::unexpected(second.error());
    // How far the two references are apart; 0 where theory gives the number.
    floors_.assign(scene_.accuracy.size(), 0.0);
    for (std::size_t a = 0; a < scene_.accuracy.size(); ++a) {
      if (!scene_.accuracy[a].exact)
        floors_[a] = accuracy_error(scene_.accuracy[a], *second, *first).value_or(1);
      result_.references[a].own_error = std::max(result_.references[a].own_error, floors_[a]);
    }
    return first;
  }

  const WorkPoint& play(const SceneSpec& scene, const SolverVariant& variant,
                        const SceneRecording& reference) {
    auto& point = result_.points.emplace_back();
    point.variant = variant;
    auto built = build_scene(scene, table_);
    const auto recording = built ? play_run({{}, scene}, table_) : tl::unexpected(built.error());
    if (!recording) return point.refused = recording.error().front(), point;
    for (const auto& accuracy : scene_.accuracy)
      point.unstable = point.unstable || exploded(accuracy, *recording, reference);
    if (point.unstable) return point;
    point.floors = floors_;
    for (const auto& accuracy : scene_.accuracy)
      point.errors.push_back(accuracy_error(accuracy, *recording, reference).value_or(1));
    timers_[result_.points.size() - 1] = std::make_unique<PlantTimer>(std::move(*built), scene, *recording);
    return point;
  }

  /// Interleaved, so that a disturbance of the machine affects all of them.
  void take_times() {
    for (int repeat = 0; repeat < options_.repeats; ++repeat) {
      report(static_cast<double>(runs_) * (1.0 + static_cast<double>(repeat) / options_.repeats), "timing");
      for (const auto& [point, timer] : timers_) timer->run();
    }
    for (const auto& [point, timer] : timers_) result_.points[point].ns_per_frame = timer->ns_per_frame();
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
  WorkPrecisionOptions options_;
  std::size_t runs_ = 0;
  std::vector<double> floors_;  // own errors of the reference
  WorkPrecision result_;
  std::map<std::size_t, std::unique_ptr<PlantTimer>> timers_;
};

/// Without a network there is no solver, and without [accuracy] no error.
std::optional<Error> missing_section(const SceneSpec& scene) {
  if (scene.accuracy.empty())
    return Error{
        Errc::Missing, scene.file.text(), "the scene does not list the measures to compare",
        "add [accuracy] with an entry such as\n  path = { measure = \"position\", of = \"plant.stick\" }"};
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
  return Study{scene, table, options}.run();
}

Checked<WorkPrecision> evaluate_as_written(const SceneSpec& scene, const NodeTable& table, int repeats) {
  if (auto missing = missing_section(scene)) return tl::unexpected(std::vector{*missing});
  WorkPrecisionOptions options;
  options.repeats = repeats;
  return Study{scene, table, options}.run_as_written();
}

}  // namespace tactus
