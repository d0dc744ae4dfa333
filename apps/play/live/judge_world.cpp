#include "apps/play/live/judge_world.h"

#include <algorithm>
#include <new>

#include "apps/cli/console.h"
#include "apps/play/world.h"
#include "engine/nodes/table.h"
#include "engine/study/stability/stability_check.h"

namespace tactus::app {
namespace {

constexpr std::size_t kMostSentences = 3;

struct Ended {};

std::string text_of(const StabilityReport& report) {
  std::string text = name_of(report.stability());
  const auto sentences = describe(report.verdict);
  for (std::size_t s = 1; s < std::min(sentences.size(), kMostSentences); ++s) text += "; " + sentences[s];
  return text;
}

WorldVerdict judge(const Target& target, const std::string& inputs, const SceneOptions& options,
                   const StabilityProgress& progress) {
  const auto world = load_world(target, inputs, /*by_hand=*/true);
  if (!world.loaded.scene) return {false, to_string(world.loaded.errors)};
  StabilityOptions how;
  static_cast<SceneOptions&>(how.world) = options;
  const StabilitySubject subject{.scene = &world.loaded, .table = &standard_nodes()};
  const auto report = check_stability(subject, how, /*quick=*/false, progress, /*workers=*/1);
  if (!report) return {false, to_string(report.error())};
  return {report->stability() == Stability::Stable, text_of(*report)};
}

}  // namespace

WorldVerdict judge_world(const Target& target, const std::string& inputs, const SceneOptions& options,
                         const std::function<bool()>& go_on) {
  try {
    return judge(target, inputs, options, [&](const std::string&, double) {
      if (!go_on()) throw Ended{};
    });
  } catch (const Ended&) {
    return {};
  } catch (const CommandError& error) {
    return {false, to_string(error.errors)};
  } catch (const std::bad_alloc&) {
    return {false, to_string(out_of_memory("the verdict"))};
  }
}

}  // namespace tactus::app
