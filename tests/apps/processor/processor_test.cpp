// The program itself, on an emulated processor that lacks instructions it was compiled for.
#include <catch2/catch.hpp>
#include <chrono>
#include <string>

#include "tests/support/child_process.h"
#include "tests/support/skip.h"

using namespace tactus;

namespace {

#if defined(__AVX2__)
constexpr bool kNeedsAvx2 = true;
#else
constexpr bool kNeedsAvx2 = false;
#endif

#if defined(__has_feature)
#define TACTUS_HAS_FEATURE(name) __has_feature(name)
#else
#define TACTUS_HAS_FEATURE(name) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) ||                 \
    TACTUS_HAS_FEATURE(address_sanitizer) || TACTUS_HAS_FEATURE(thread_sanitizer) || \
    TACTUS_HAS_FEATURE(realtime_sanitizer)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif

}  // namespace

TEST_CASE("processor: one without instructions that the program uses is refused in words", "[apps]") {
  if (!kNeedsAvx2 || kSanitized) test::skip("this build does not use AVX2, or has sanitizers");
  test::ChildProcess program{{"qemu-x86_64", "-cpu", "Nehalem", TACTUS_PROGRAM, "--version"}};
  const auto exit = program.wait(std::chrono::seconds{60});
  if (exit == test::ChildProcess::kCannotRun) test::skip("needs qemu-x86_64: apt-get install qemu-user");
  const auto log = program.log();
  CAPTURE(log);
  CHECK(exit == 126);
  CHECK(log.find("lacks instructions") != std::string::npos);
  CHECK(log.find("AVX2") != std::string::npos);
  CHECK(log.find("TACTUS_ARCH") != std::string::npos);
}
