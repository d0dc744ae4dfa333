#include "apps/render/render_error.h"

#include <fmt/format.h>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/study/reports.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

/// Puts what the command line says in the place of what the scene says.
Status change(SceneSpec& scene, const RenderError& run) {
  const auto set = [](const std::string& text, const char* unit, const char* option, double low, double high,
                      auto& to) -> Status {
    if (text.empty()) return {};
    const auto value = parse_option(text, unit, option);
    if (!value) return tl::unexpected(value.error());
    if (!(*value >= low && *value <= high))
      return fail(Errc::OutOfRange, std::string{"--"} + option, text + " is out of its range",
                  fmt::format("choose {:g} to {:g} {}", low, high, unit));
    to.value = *value;
    return {};
  };
  if (auto status = set(run.rate, "Hz", "rate", 1e3, 768e3, scene.rate); !status) return status;
  if (auto status = set(run.delay, "s", "delay", 0, 10, scene.delay); !status) return status;
  return set(run.duration, "s", "duration", 1e-3, 3600, scene.duration);
}

std::string text_of_run(const WorkPrecision& judged) {
  const auto& point = judged.points.front();
  auto text = fmt::format("{}\n\n", judged.scene);
  if (!point.known()) return text + (point.refused ? to_string(*point.refused) : "  unstable") + "\n";
  text += fmt::format("  {:.1f} ns a frame, {:.2g} % of real time at {:g} kHz\n", point.ns_per_frame,
                      100 * point.load(), point.variant.rate.value / 1e3);
  for (std::size_t a = 0; a < point.errors.size(); ++a) {
    const auto& used = judged.references[a];
    text += fmt::format("  {:.2e}  relative error of {}: {} of {}, against {}{}\n", point.errors[a],
                        used.accuracy, used.measure, used.of, used.what,
                        used.own_error > 0 ? fmt::format(", itself within {:.1e}", used.own_error) : "");
  }
  return text;
}

}  // namespace

int render_error(const RenderError& run) {
  auto scene = load_scene(run.scene, root_of(run.scene));
  if (!scene) return report(scene.error());
  if (const auto status = change(*scene, run); !status) return report(status.error());
  const auto judged = judge_as_written(*scene, standard_nodes());
  if (!judged) return report(judged.error());
  if (run.json)
    fmt::print("{}\n", json_of(*judged).dump(2));
  else
    fmt::print("{}", text_of_run(*judged));
  return judged->points.front().known() ? kDone : kNo;
}

}  // namespace tactus::app
