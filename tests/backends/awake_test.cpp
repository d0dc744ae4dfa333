#include "backends/awake.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::test;

TEST_CASE("awake: asks for a latency of 0 µs", "[backends]") {
  const TemporaryFolder folder;
  const auto file = (folder.path() / "cpu_dma_latency").string();
  std::ofstream{file} << "what was there";
  {
    const auto awake = Awake::begin(file.c_str());
    REQUIRE(awake);
    std::ifstream in{file, std::ios::binary};
    const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
    CHECK(bytes.substr(0, 4) == std::string(4, '\0'));  // 0 as a 32-bit number; a device has no further bytes
  }
}

TEST_CASE("awake: where it is not possible the reason and a remedy are given", "[backends]") {
  const TemporaryFolder folder;
  const auto none = Awake::begin((folder.path() / "none").string().c_str());
  REQUIRE_FALSE(none);
  CHECK(none.error().what.find("there is no") != std::string::npos);
  const auto refused = Awake::begin(folder.path().string().c_str());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().what.find("Is a directory") != std::string::npos);
  CHECK(refused.error().remedy.find("udev") != std::string::npos);
}
