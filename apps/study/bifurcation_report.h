#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine/plot/plot.h"
#include "engine/study/orbits/bifurcation.h"

namespace tactus::app {

// Reports of an orbit study: JSON, text and plots.

nlohmann::ordered_json json_of(const Bifurcation& study);
std::string text_of(const Bifurcation& study);
std::vector<Plot> picture_of(const Bifurcation& study);

}  // namespace tactus::app
