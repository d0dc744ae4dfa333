#include "engine/study/playability/playability.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <mutex>

#include "engine/graph/file/entry_fields.h"
#include "engine/study/parallel_for.h"
#include "engine/study/playability/run_cache.h"
#include "engine/study/playability/scene_fingerprint.h"
#include "engine/study/playability/scene_variants.h"

namespace tactus {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kPlayabilityBlock = 256;
constexpr auto kAsWritten = "as written";
// Kept runs of another definition of what is judged are played again.
constexpr std::uint64_t kEdition = 2;

Json json_of(const JudgedRun& run) {
  return {{"kind", run.kind}, {"score", run.score}, {"playable", run.playable}, {"readings", run.readings}};
}

/// Nothing if a line was edited by hand into something else.
std::optional<JudgedRun> judged_of(const Json& json, std::size_t readings) {
  try {
    JudgedRun run{json.at("kind"), json.at("score"), json.at("playable"), json.at("readings")};
    if (run.readings.size() == readings) return run;
  } catch (const Json::exception&) {
  }
  return std::nullopt;
}

/// One actuator and one plant.
struct Variant {
  std::string name;
  double gain = 1;
  int draw = 0;  ///< from 1; 0: as written
};

std::vector<Variant> variants_of(const PlayabilityOptions& options) {
  std::vector<Variant> variants{{kAsWritten}};
  for (const double gain : options.gains) variants.push_back({fmt::format("actuator x {:.3g}", gain), gain});
  for (int draw = 1; draw <= options.draws; ++draw)
    variants.push_back({fmt::format("draw {}", draw), 1, draw});
  return variants;
}

class Study {
 public:
  Study(const SceneSpec& scene, const NodeTable& table, const PlayabilityOptions& options)
      : scene_(scene), table_(table), options_(options), variants_(variants_of(options)) {
    study_.scene = scene.name;
    study_.kind = scene.playability->kind;
    study_.delays_s = options.delays_s;
    study_.over = options.over;
    for (const auto& variant : variants_) study_.variants.push_back(variant.name);
    plan();
  }

  Checked<PlayabilityStudy> run() {
    if (auto status = try_extremes(); !status) return tl::unexpected(status.error());
    if (!options_.keep.empty()) {
      const auto file = options_.parts == 1
                            ? std::string{"runs.jsonl"}
                            : fmt::format("part_{}_of_{}.jsonl", options_.part + 1, options_.parts);
      auto kept = KeptRuns::open(options_.keep, file);
      if (!kept) return tl::unexpected(std::vector{kept.error()});
      kept_ = std::move(*kept);
    }
    on_all_cores(
        static_cast<int>(study_.runs.size()), [&](int i) { take(static_cast<std::size_t>(i)); },
        [&](double share) {
          if (options_.progress) options_.progress(share);
        },
        options_.workers);
    if (!errors_.empty()) return tl::unexpected(std::move(errors_));
    return std::move(study_);
  }

 private:
  void plan() {
    const auto values = [&](std::size_t which) {
      return which < options_.over.size() ? options_.over[which].values.size() : 1;
    };
    for (const double delay : options_.delays_s)
      for (std::size_t a = 0; a < values(0); ++a)
        for (std::size_t b = 0; b < values(1); ++b)
          for (const auto& variant : variants_) {
            PlayedRun run{delay, {}, variant.name, std::nullopt};
            if (!options_.over.empty()) run.at.push_back(options_.over[0].values[a].si);
            if (options_.over.size() > 1) run.at.push_back(options_.over[1].values[b].si);
            study_.runs.push_back(std::move(run));
          }
  }

  /// The scene of a run, and what is set in it.
  struct Setup {
    SceneSpec scene;
    SceneOptions options;
  };
  Setup setup_of(std::size_t number) const {
    const auto& run = study_.runs[number];
    const auto& variant = variants_[number % variants_.size()];
    Setup setup{scene_, {}};
    setup.scene.delay = Seconds{run.delay_s};
    setup.options.set = options_.set;
    for (std::size_t i = 0; i < run.at.size(); ++i) {
      const auto& swept = options_.over[i];
      apply(setup, swept, run.at[i]);
    }
    if (variant.gain != 1) setup.scene = with_actuator_gain(std::move(setup.scene), variant.gain);
    if (variant.draw > 0)
      setup.scene = with_plant_drawn(std::move(setup.scene), options_.within,
                                     options_.seed * 0x9e3779b97f4a7c15u + std::uint64_t(variant.draw));
    return setup;
  }

  static void apply(Setup& setup, const SweptValue& swept, double si) {
    if (swept.what == SweptValue::What::Scaled)
      setup.scene = with_gesture_scaled(std::move(setup.scene), swept.name, si);
    else if (swept.what == SweptValue::What::Held)
      setup.scene = with_gesture_held(std::move(setup.scene), swept.name, si);
    else
      set_swept(setup, swept, si);
  }

  static void set_swept(Setup& setup, const SweptValue& swept, double si) {
    auto value = swept.values.front();
    value.si = si;
    setup.options.set[swept.name] = value;
  }

  static std::uint64_t key_of(const Setup& setup) {
    Fingerprint print;
    add(print.add(kEdition), setup.scene);
    for (const auto& [name, value] : setup.options.set) print.add(name).add(value.si);
    return print.value();
  }

  /// Mistakes are told before the first run: the corners of what is swept must build, and every variant.
  Checked<void> try_extremes() const {
    const auto build = [&](std::size_t number) -> Checked<void> {
      const auto setup = setup_of(number);
      return compile_scene(setup.scene, table_, setup.options).map([](const CompiledScene&) {});
    };
    const auto a_delay = study_.runs_a_delay();
    for (std::size_t i = 0; i < variants_.size(); ++i)
      if (auto status = build(i); !status) return status;
    for (std::size_t i = 0; i < a_delay; i += variants_.size())
      if (auto status = build(i); !status) return status;
    return build(study_.runs.size() - 1);
  }

  void take(std::size_t number) {
    const auto setup = setup_of(number);
    const auto key = key_of(setup);
    if (const auto* kept = kept_.find(key))
      study_.runs[number].judged = judged_of(*kept, measure_columns(study_.kind).size());
    const bool mine = static_cast<int>(number) % options_.parts == options_.part;
    if (study_.runs[number].judged || !mine || failed_ || (options_.stop && options_.stop())) return;
    auto judged = play(setup);
    if (judged)
      if (auto status = kept_.keep(key, json_of(*judged)); !status)
        judged = tl::unexpected(std::vector{status.error()});
    if (!judged) return fail_with(std::move(judged.error()));
    study_.runs[number].judged = std::move(*judged);
  }

  Checked<JudgedRun> play(const Setup& setup) const {
    auto built = build_scene(setup.scene, table_, setup.options);
    if (!built) return tl::unexpected(built.error());
    const auto recording = play_scene(setup.scene, *built, kPlayabilityBlock);
    if (!recording) return tl::unexpected(std::vector{recording.error()});
    return judge(*recording, *setup.scene.playability);
  }

  void fail_with(std::vector<Error> errors) {
    const std::lock_guard lock{failing_};
    if (!failed_.exchange(true)) errors_ = std::move(errors);
  }

  const SceneSpec& scene_;
  const NodeTable& table_;
  const PlayabilityOptions& options_;
  std::vector<Variant> variants_;
  PlayabilityStudy study_;
  KeptRuns kept_;
  std::mutex failing_;
  std::atomic<bool> failed_ = false;
  std::vector<Error> errors_;
};

/// A gesture that is to be held must be like the value.
std::optional<Error> what_is_unlike(const SceneSpec& scene, const SweptValue& swept) {
  const auto* gesture = scene.gesture(swept.name);
  const auto& value = swept.values.front();
  if (swept.what != SweptValue::What::Held || gesture == nullptr || gesture->bare ||
      value.dimension == gesture->unit.dimension)
    return std::nullopt;
  return Error{Errc::UnitMismatch, "--over",
               "gesture '" + swept.name + "' is like " +
                   in_unit(gesture->points.front().value, gesture->unit) + ", not like " +
                   short_quantity(value.si, *value.dimension),
               "give it the unit of the gesture, or none to scale the gesture"};
}

std::optional<Error> what_lacks(const SceneSpec& scene, const PlayabilityOptions& options) {
  if (!scene.playability)
    return Error{Errc::Missing, scene.file.text(), "the scene does not say what playing it well means",
                 "add [playability] with kind = \"roll\" or kind = \"tone\""};
  for (const auto& swept : options.over) {
    if (auto unlike = what_is_unlike(scene, swept)) return unlike;
    const auto* instrument = scene.part("instrument");
    const auto* wire = instrument != nullptr ? find(instrument->wires, swept.name) : nullptr;
    const auto* text = wire != nullptr ? wire->text() : nullptr;
    if (scene.gesture(swept.name) == nullptr && text != nullptr && scene.gesture(*text) != nullptr)
      return Error{
          Errc::BadArgument, "--over", "control '" + swept.name + "' is moved by gesture '" + *text + "'",
          "sweep the gesture: --over " + *text + "=0.5:2:4 scales it, values with a unit hold it there"};
  }
  return std::nullopt;
}

}  // namespace

int PlayabilityStudy::finished() const {
  return static_cast<int>(
      std::count_if(runs.begin(), runs.end(), [](const PlayedRun& run) { return run.judged.has_value(); }));
}

std::vector<DelayVerdict> PlayabilityStudy::verdicts() const {
  std::vector<DelayVerdict> verdicts;
  for (std::size_t d = 0; d < delays_s.size(); ++d) {
    DelayVerdict verdict{.delay_s = delays_s[d], .worst = d * runs_a_delay()};
    for (std::size_t i = verdict.worst; i < (d + 1) * runs_a_delay(); ++i) {
      const auto& judged = *runs[i].judged;
      (runs[i].as_written() ? verdict.runs : verdict.varied) += 1;
      (runs[i].as_written() ? verdict.good : verdict.varied_good) += judged.playable ? 1 : 0;
      if (!runs[i].as_written()) continue;
      verdict.score += judged.score;
      if (judged.score < runs[verdict.worst].judged->score) verdict.worst = i;
    }
    verdict.score /= verdict.runs;
    verdict.playable = verdict.good == verdict.runs && verdict.robust() >= kRobustShare;
    verdicts.push_back(verdict);
  }
  return verdicts;
}

Checked<PlayabilityStudy> study_playability(const SceneSpec& scene, const NodeTable& table,
                                            const PlayabilityOptions& options) {
  if (auto missing = what_lacks(scene, options)) return tl::unexpected(std::vector{*missing});
  return Study{scene, table, options}.run();
}

}  // namespace tactus
