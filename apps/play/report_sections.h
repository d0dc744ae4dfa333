#pragma once
// Thread: [control]

#include <string>
#include <vector>

#include "apps/play/play_report.h"

namespace tactus::app {

/// A section of the report of a played scene: what the signal with one role did, for machines and for people.
struct ReportSection {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();  ///< part of the report
  std::string text{};
};

/// The sections of the roles that [roles] gives, in its order; without it, of those that ports play by name.
/// `contact`: a roll; `ball`: its orbit; `monitor`: notes (see melody_of). `compared`: the other run of a
/// scene with [compare], or nullptr.
std::vector<ReportSection> sections_of(const PlayedScene& played, const PlayedScene* compared);

}  // namespace tactus::app
