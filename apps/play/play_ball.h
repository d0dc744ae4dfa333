#pragma once

// Thread: [control]

#include "apps/play/play_report.h"

namespace tactus::app {

/// What a ball does on its table at the end of a scene. Nothing without a table.
void report_ball(nlohmann::ordered_json& json, const PlayedScene& played, const PlayedScene* compared);
/// The same for people; nothing where there is no ball.
void print_ball(const nlohmann::ordered_json& json);

}  // namespace tactus::app
