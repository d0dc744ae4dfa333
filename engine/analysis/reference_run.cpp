#include "engine/analysis/reference_run.h"

#include "engine/analysis/solver_variants.h"

namespace tactus {
namespace {

constexpr int kBlock = 64;

struct Way {
  const char* solver;
  int oversample, again;
  double share;
};

Way way() { return has_reference_solver() ? Way{"reference", 1, 2, 1.0} : Way{"passive", 64, 32, 1.0 / 3}; }

}  // namespace

Checked<SceneRecording> play_at(const SceneSpec& scene, const NodeTable& table, Hertz rate) {
  SceneOptions options;
  options.rate = rate;
  auto built = build_scene(scene, table, options);
  if (!built) return tl::unexpected(built.error());
  return play_scene(scene, *built, kBlock).map_error([](Error error) { return std::vector{error}; });
}

Checked<ReferenceRun> play_reference(const SceneSpec& scene, const NodeTable& table, Hertz rate) {
  const auto [solver, oversample, again, share] = way();
  auto first = play_at(with_solver(scene, {solver, oversample, rate}), table, rate);
  if (!first) return tl::unexpected(first.error());
  auto second = play_at(with_solver(scene, {solver, again, rate}), table, rate);
  if (!second) return tl::unexpected(second.error());
  return ReferenceRun{std::move(*first), std::move(*second), share};
}

std::string reference_in_words(const SceneSpec& scene) {
  if (!has_reference_solver()) return "64 passive steps a frame, with 32 to check (Richardson)";
  return is_linear(scene) ? "matrix exponential"
                          : "integration from event to event, with other steps to check";
}

}  // namespace tactus
