#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/fuzz/fuzz_targets.h"

using namespace tactus;

namespace {

/// Calls `check(text)` for every file below tests/fuzz/corpus.
template <class Check>
void for_the_corpus(Check check) {
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(TACTUS_SOURCE_DIR "/tests/fuzz/corpus")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    INFO(entry.path());
    std::ifstream stream(entry.path(), std::ios::binary);
    CHECK(check(std::string{std::istreambuf_iterator<char>{stream}, {}}) == "");
  }
  CHECK(files > 0);
}

}  // namespace

TEST_CASE("fuzz: whatever the fuzzers found is read or refused in words", "[fuzz]") {
  for_the_corpus([](const std::string& text) { return fuzz::load_anything(text); });
}

TEST_CASE("fuzz: whatever loads of it runs, finite and below the ceiling", "[fuzz]") {
  for_the_corpus([](const std::string& text) { return fuzz::run_anything(text); });
}
