// The program itself, with little memory.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/support/child_process.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kNeedsAddresses = true;
#elif defined(__has_feature)
constexpr bool kNeedsAddresses = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kNeedsAddresses = false;
#endif

/// 900 s of doubles at 48 kHz: 330 MiB.
constexpr const char* kLongDelays = R"(format = 1
name = "long"
[nodes]
hiss  = { type = "noise" }
first = { type = "delay", in = "hiss", time = "300 s" }
next  = { type = "delay", in = "first", time = "300 s" }
last  = { type = "delay", in = "next", time = "300 s" }
[outputs]
out = { from = "last" }
)";

}  // namespace

TEST_CASE("memory: a graph that is too large for it is reported, with its name where it is played",
          "[apps]") {
  if (kNeedsAddresses) test::skip("a sanitizer needs more addresses than the test allows");
  const test::TemporaryFolder folder;
  const auto file = folder.write("long.toml", kLongDelays).string();
  const bool played = GENERATE(true, false);
  const auto wav = (folder.path() / "x.wav").string();
  const std::vector<std::string> play = {"play", file, "--backend", "loop", "--arm", "--duration", "0.1 s"},
                                 render = {"render", file, "--duration", "0.1 s", "--out", wav};
  std::vector<std::string> words = {"sh", "-c", "ulimit -v 250000; exec \"$0\" \"$@\"", TACTUS_PROGRAM};
  for (const auto& word : played ? play : render) words.push_back(word);
  test::ChildProcess program{words, test::ChildProcess::Stdout::Logged};
  CHECK(program.wait(std::chrono::seconds{60}) == 1);
  CHECK_THAT(program.log(),
             Catch::Contains("there is not enough memory for") && Catch::Contains("shorter delays"));
  if (played) CHECK_THAT(program.log(), Catch::Contains("memory for " + file));
}
