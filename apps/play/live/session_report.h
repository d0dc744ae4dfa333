#pragma once
// Thread: [control]

#include "apps/play/live/performer.h"
#include "apps/play/live/session.h"

namespace tactus::app {

/// Prints what a session did that has stopped; `view`: its last look. For people, or all of it as one object.
void print_report(Session& session, const SessionView& view, const Performer& performer, bool as_json);

}  // namespace tactus::app
