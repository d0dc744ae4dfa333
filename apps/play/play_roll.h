#pragma once

// Thread: [control]

#include "apps/play/play_report.h"

namespace tactus::app {

/// What a drummer asks of a roll, where the plant shows its strikes (role "contact"). `compared` may be
/// nullptr.
void report_roll(nlohmann::ordered_json& json, const PlayedScene& played, const PlayedScene* compared);
/// The same for people; nothing where nothing strikes.
void print_roll(const nlohmann::ordered_json& json);

}  // namespace tactus::app
