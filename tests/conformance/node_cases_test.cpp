#include "tests/conformance/node_cases.h"

#include <catch2/catch.hpp>

namespace tactus::test {

TEST_CASE("node_cases: example values are read from a line of a graph file", "[conformance]") {
  const std::string line =
      "x = { type = \"t\", table = [[1, 2], [\"3 m\", 4]], order = 8, word = \"two words\" }";
  CHECK(from_example(line, "table") == "[[1, 2], [\"3 m\", 4]]");
  CHECK(from_example(line, "order") == "8");
  CHECK(from_example(line, "word") == "two words");
  CHECK_FALSE(from_example(line, "ord"));
}

}  // namespace tactus::test
