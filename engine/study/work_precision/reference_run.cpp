#include "engine/study/work_precision/reference_run.h"

#include "engine/study/work_precision/solver_variants.h"

namespace tactus {
namespace {

constexpr int kReferenceRunBlock = 64;

}  // namespace

Checked<SceneRecording> play_at(const SceneSpec& scene, const NodeTable& table, Hertz rate) {
  SceneOptions options;
  options.rate = rate;
  auto built = build_scene(scene, table, options);
  if (!built) return tl::unexpected(built.error());
  return play_scene(scene, *built, kReferenceRunBlock).map_error([](Error error) {
    return std::vector{error};
  });
}

Checked<ReferenceRun> play_reference(const SceneSpec& scene, const NodeTable& table, Hertz rate) {
  auto first = play_at(with_solver(scene, {"reference", 1, rate}), table, rate);
  if (!first) return tl::unexpected(first.error());
  auto second = play_at(with_solver(scene, {"reference", 2, rate}), table, rate);
  if (!second) return tl::unexpected(second.error());
  return ReferenceRun{std::move(*first), std::move(*second)};
}

std::string reference_in_words(const SceneSpec& scene) {
  return is_linear(scene) ? "the linear motion: matrix exponential, or integration where that is too large"
                          : "integration from event to event";
}

}  // namespace tactus
