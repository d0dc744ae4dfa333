#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/study/playability/playability.h"

namespace tactus::app {

// All of a complete study.

/// One line a delay: score, kind, readings; where something is swept, a map of letters too; the verdict.
std::string text_of(const PlayabilityStudy& study);
/// "playable from 0 to 40 ms; weakest at 23 ms: irregular, score 0.61"
std::string describe_verdict(const PlayabilityStudy& study);
nlohmann::ordered_json json_of(const PlayabilityStudy& study);

}  // namespace tactus::app
