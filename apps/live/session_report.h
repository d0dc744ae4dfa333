#pragma once

#include "apps/live/session.h"

namespace tactus::app {

/// Prints what a session did that has stopped; `view`: its last look. For people, or all of it as one object.
void print_report(Session& session, const SessionView& view, const std::string& instrument, bool as_json);

}  // namespace tactus::app
