#pragma once

#include "apps/play/play_report.h"

namespace tactus::app {

/// What a ball does on its table at the end of a scene. False: the plant has no ball on a table.
bool report_ball(nlohmann::ordered_json& json, const PlayedScene& played);
/// The same for people; nothing where there is no ball.
void print_ball(const nlohmann::ordered_json& json);

}  // namespace tactus::app
