#include "engine/study/work_precision/reference_run.h"

#include "engine/study/sweep/scene_variants.h"

namespace tactus {
namespace {

constexpr int kReferenceRunBlock = 64;

SceneSpec with_reference_solver(const SceneSpec& scene, int oversample) {
  return with_network_option(with_network_option(scene, "solver", "reference"), "oversample",
                             static_cast<double>(oversample));
}

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
  auto first = play_at(with_reference_solver(scene, 1), table, rate);
  if (!first) return tl::unexpected(first.error());
  auto second = play_at(with_reference_solver(scene, 2), table, rate);
  if (!second) return tl::unexpected(second.error());
  return ReferenceRun{std::move(*first), std::move(*second)};
}

std::string describe_reference(const SceneSpec& scene) {
  return is_linear(scene) ? "the linear motion: matrix exponential, or integration where that is too large"
                          : "integration from event to event";
}

}  // namespace tactus
