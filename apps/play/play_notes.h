#pragma once

// Thread: [control]

#include "apps/play/play_report.h"

namespace tactus::app {

/// What a player asks of a melody, where the scene says which notes are wanted (see melody_of): adds "notes"
/// and "notes_in_words", and those of the compared run. `compared` may be nullptr.
void report_notes(nlohmann::ordered_json& json, const PlayedScene& played, const PlayedScene* compared);
/// The same for people; nothing where there are no notes.
void print_notes(const nlohmann::ordered_json& json);

}  // namespace tactus::app
