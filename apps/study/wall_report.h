#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/plot/plot.h"
#include "engine/study/walls/wall_map.h"

namespace tactus::app {

/// A map of walls for people, for machines, and to look at: one plot over the delay, one over the rate.
std::string text_of(const WallMap& map);
nlohmann::ordered_json json_of(const WallMap& map);
std::vector<Plot> picture_of(const WallMap& map);

}  // namespace tactus::app
