#pragma once

#include <filesystem>
#include <memory>

#include "tests/realtime/subjects.h"

namespace tactus::realtime {

/// The pool of bodies and links below `instruments`, as clients use it: bodies come and go, links are made
/// and removed, and another thread watches all of them. nullptr: this build has no worlds.
std::unique_ptr<Subject> world_subject(const std::filesystem::path& instruments, int frames);

}  // namespace tactus::realtime
