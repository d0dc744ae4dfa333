#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "engine/study/work_precision/work_precision.h"

namespace tactus::app {

/// One line a variant, by computing time; what the errors are measured against; what to take for 1 % and for
/// 0.01 %.
std::string text_of(const WorkPrecision& study);
/// The same as a table of Markdown.
std::string markdown_of(const WorkPrecision& study);
nlohmann::ordered_json json_of(const WorkPrecision& study);

}  // namespace tactus::app
