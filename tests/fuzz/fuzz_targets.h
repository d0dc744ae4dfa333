#pragma once

#include <string>
#include <string_view>

// What the fuzzers call with any bytes, and the tests with those of tests/fuzz/corpus. Crashes and hangs show
// by themselves; what else went wrong comes back in words, "" if nothing did.

namespace tactus::fuzz {

/// Reads `text` as a graph and as a scene, in a folder where there are files to use, and checks all that can
/// be checked without running it. Whatever is refused must be refused with a place, or a file, and a remedy.
std::string load_anything(std::string_view text);

/// Compiles `text` if it is a graph and runs it on all that a converter or a broken plug-in might deliver,
/// with every control thrown from end to end: the guard must never see a number that is not finite, nor let
/// one through above its ceiling.
std::string run_anything(std::string_view text);

}  // namespace tactus::fuzz
