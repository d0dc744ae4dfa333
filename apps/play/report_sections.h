#pragma once

// Thread: [control]

#include <memory>
#include <string>
#include <vector>

#include "apps/play/play_report.h"

namespace tactus::app {

/// A section of the report of a played scene: what the signal with one role did. JSON and text are two views
/// of it.
class ReportSection {
 public:
  virtual ~ReportSection() = default;
  virtual void add_to(nlohmann::ordered_json& json) const = 0;
  virtual std::string text() const = 0;
};

/// The sections of the roles that [roles] gives, in its order; without it, of those that ports play by name.
/// `contact`: a roll; `ball`: its orbit; `monitor`: notes (see melody_of). `compared`: the other run of a
/// scene with [compare], or nullptr.
std::vector<std::unique_ptr<ReportSection>> sections_of(const PlayedScene& played,
                                                        const PlayedScene* compared);

}  // namespace tactus::app
