#include <fmt/format.h>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/render/render.h"
#include "apps/study/work_precision_report.h"
#include "engine/nodes/table.h"

namespace tactus::app {
namespace {

std::string error_text(const WorkPrecision& result) {
  const auto& point = result.points.front();
  auto text = fmt::format("{}\n\n", result.scene);
  if (!point.known()) return text + (point.refused ? to_string(*point.refused) : "  unstable") + "\n";
  text += fmt::format("  {:.1f} ns a frame, {:.2g} % of real time at {:g} kHz\n", point.ns_per_frame,
                      100 * point.load(), point.variant.rate.value / 1e3);
  for (std::size_t a = 0; a < point.errors.size(); ++a) {
    const auto& used = result.references[a];
    text += fmt::format("  {:.2e}  relative error of {}: {} of {}, against {}{}\n", point.errors[a],
                        used.accuracy, used.measure, used.of, used.what,
                        used.own_error > 0 ? fmt::format(", itself within {:.1e}", used.own_error) : "");
  }
  return text;
}

}  // namespace

int render_error(const RenderOptions& options, const std::filesystem::path& file) {
  auto scene = or_exit(load_scene(file, root_of(file)));
  if (!options.rate.empty()) scene.rate = or_exit(parse_rate(options.rate));
  if (!options.delay.empty()) scene.delay = or_exit(parse_delay(options.delay));
  if (!options.duration.empty()) scene.duration = or_exit(parse_duration(options.duration, 3600_s));
  const auto result = or_exit(judge_as_written(scene, standard_nodes()));
  if (options.json)
    fmt::print("{}\n", json_of(result).dump(2));
  else
    fmt::print("{}", error_text(result));
  return result.points.front().known() ? kDone : kNo;
}

}  // namespace tactus::app
