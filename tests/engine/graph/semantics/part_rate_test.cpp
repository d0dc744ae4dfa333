#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/part_graph.h"

using namespace tactus;
using test::PartGraphs;

namespace {

const std::string kPlain = "[inputs]\nx = {}\n[outputs]\ny = { from = \"x\" }\n";

/// Errors of a part with these keys.
std::string rate_errors(const std::string& keys, Hertz rate = 48_kHz) {
  const PartGraphs graphs{kPlain};
  CompileOptions options;
  options.sample_rate = rate;
  return graphs.errors_of("[inputs]\nx = {}\n[nodes]\n" + ("p = { use = \"part.toml\", x = \"x\", " + keys) +
                              " }\n[outputs]\ny = { from = \"p\" }\n",
                          options);
}

}  // namespace

TEST_CASE("part rate: a fraction, or a rate that divides the one around it", "[graph]") {
  for (const auto* keys : {"rate = \"1/16\"", "rate = \"1 / 3\"", "rate = \"3 kHz\"", "rate = \"48 kHz\"",
                           "rate = \"1/1024\", take = \"mean\", between = \"line\""})
    CHECK(rate_errors(keys) == "");
  CHECK(rate_errors("rate = \"14.7 kHz\"", 44100_Hz) == "");
}

TEST_CASE("part rate: what is no such rate is an error that names those nearby", "[graph]") {
  CHECK(rate_errors("rate = \"5 kHz\"") ==
        R"(test.toml:5:42 OutOfRange 'rate' 'p' 48 "1/9" 5.33333 "1/10" 4.8)");
  CHECK(rate_errors("rate = \"1/2.5\"") == R"(test.toml:5:42 OutOfRange 'rate' 'p' 48 "1/2" 24 "1/3" 16)");
  CHECK(rate_errors("rate = \"3 kHz\"", 44100_Hz) ==
        R"(test.toml:5:42 OutOfRange 'rate' 'p' 44.1 "1/14" 3.15 "1/15" 2.94)");
  CHECK(rate_errors("rate = \"96 kHz\"") == "test.toml:5:42 OutOfRange 'rate' 'p' 96 48");
  CHECK(rate_errors("rate = \"1/5000\"") == R"(test.toml:5:42 OutOfRange 'rate' 'p' "1/1024")");
  for (const auto* wrong : {"16", "\"16\"", "\"2/3\"", "\"12 ms\"", "\"x\"", "true", "[1]", "\"1/\""})
    CHECK(rate_errors("rate = " + std::string{wrong}) ==
          R"(test.toml:5:42 WrongType 'rate' 'p' "1/16" "3 kHz")");
}

TEST_CASE("part rate: keys about a rate stand beside one, and are known", "[graph]") {
  CHECK(rate_errors("between = \"line\"") == "test.toml:5:45 Missing 'between' 'p' 'rate' 'between'");
  CHECK(rate_errors("rate = \"1/2\", take = \"first\"") ==
        "test.toml:5:56 UnknownName 'take' 'p' 'first' 'last' 'mean'");
}

TEST_CASE("part rate: a part in a part divides the rate that is around it", "[graph]") {
  PartGraphs graphs{kPlain};
  const auto middle = [](const std::string& rate) {
    return "[inputs]\nx = {}\n[nodes]\nq = { use = \"part.toml\", x = \"x\", rate = \"" + rate +
           "\" }\n[outputs]\ny = { from = \"q\" }\n";
  };
  const std::string top =
      "[inputs]\nx = {}\n[nodes]\np = { use = \"middle.toml\", x = \"x\", rate = \"1/4\" }\n[outputs]\ny = { "
      "from = "
      "\"p\" }\n";
  graphs.write("middle.toml", middle("1/4"));
  CHECK(graphs.right(top)->divisors == std::vector<int>{1, 4, 16});
  graphs.write("middle.toml", middle("16 kHz"));
  CHECK(graphs.errors_of(top) == "middle.toml:5:42 OutOfRange 'rate' 'q' 16 12");
  graphs.write("middle.toml", middle("8 kHz"));
  CHECK(graphs.errors_of(top) == R"(middle.toml:5:42 OutOfRange 'rate' 'q' 12 "1/1" 12 "1/2" 6)");
}

TEST_CASE("part rate: a control that is called so is the part's own", "[graph]") {
  PartGraphs graphs{
      "[controls]\nrate = { value = \"2 Hz\", range = [\"0 Hz\", \"9 Hz\"] }\n"
      "[nodes]\ns = { type = \"sine\", frequency = \"rate\" }\n[outputs]\ny = { from = \"s\" }\n"};
  CHECK(graphs.errors_of(
            "[nodes]\np = { use = \"part.toml\", rate = \"3 Hz\" }\n[outputs]\ny = { from = \"p\" }\n") ==
        "");
}
