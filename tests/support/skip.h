#pragma once

#include <string>

namespace tactus::test {

/// Exit code of a test program whose test cases were all skipped; ctest then reports a skipped test.
constexpr int kSkipExitCode = 77;

/// Ends the test case, which cannot run on this machine, and prints why.
[[noreturn]] void skip(const std::string& reason);

/// Prints why a part of the test case cannot run on this machine; the rest of it runs.
void skip_part(const std::string& reason);

/// ThreadSanitizer keeps signals back from a thread that waits in a system call until that returns.
#if defined(__SANITIZE_THREAD__)
inline constexpr bool kSignalsAreKeptBack = true;
#elif defined(__has_feature)
inline constexpr bool kSignalsAreKeptBack = __has_feature(thread_sanitizer);
#else
inline constexpr bool kSignalsAreKeptBack = false;
#endif

}  // namespace tactus::test
