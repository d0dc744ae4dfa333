#pragma once

#include <chrono>
#include <functional>

namespace tactus {

/// [control] Makes a call into a library that may never return, on a thread of its own, and waits for it.
/// False: it did not return within `patience` and is left to itself for good; `call` must own whatever it
/// touches.
bool call_with_timeout(std::function<void()> call,
                       std::chrono::milliseconds patience = std::chrono::milliseconds{2000});

}  // namespace tactus
