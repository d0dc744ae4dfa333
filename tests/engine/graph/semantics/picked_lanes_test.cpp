#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

std::string with_output(const std::string& from) {
  return "format = 1\n[inputs]\nx = { lanes = 4 }\ny = {}\n[nodes]\ntwice = \"2 * x\"\n[outputs]\nout = { "
         "from = \"" +
         from + "\" }\n";
}

/// One frame, in which lane k of x is 10 + k.
std::vector<double> out(const std::string& from) {
  std::vector<double> values;
  for (const auto& channel :
       test::run(*test::engine_of(with_output(from)), {{10}, {11}, {12}, {13}, {5}}, 1, {1}))
    values.push_back(channel[0]);
  return values;
}

}  // namespace

TEST_CASE("lanes: one is taken, several, and in any order", "[graph]") {
  CHECK(out("x[2]") == std::vector<double>{12});
  CHECK(out("x[1..3]") == std::vector<double>{11, 12, 13});
  CHECK(out("x[3..0]") == std::vector<double>{13, 12, 11, 10});
  CHECK(out("x[0, 3..2, 0]") == std::vector<double>{10, 13, 12, 10});
  CHECK(out("twice[1] + y") == std::vector<double>{27});
  CHECK(out("x + x[0]") == std::vector<double>{20, 21, 22, 23});
  CHECK(out("x[0..1] * x[2..3]") == std::vector<double>{120, 143});
  CHECK(out("y[0]") == std::vector<double>{5});
  CHECK(out("x [ 1 .. 2 ]") == std::vector<double>{11, 12});
}

TEST_CASE("lanes: those of nodes that run side by side are taken one by one", "[graph]") {
  const std::string nodes =
      "format = 1\n[inputs]\nx = {}\n[nodes]\n"
      "f = { type = \"one_pole\", in = \"x\", cutoff = { from = \"100 Hz\", to = \"1 kHz\" }, voices = 8 }\n"
      "g = { type = \"one_pole\", in = \"x\", cutoff = \"1 kHz\" }\n";
  const std::vector<double> step(200, 1.0);
  const auto outs = test::run(
      *test::engine_of(nodes +
                       "[outputs]\na = { from = \"f[7]\" }\nb = { from = \"g\" }\nc = { from = \"f[0]\" }\n"),
      {step}, 200, {64, 3});
  for (std::size_t n = 0; n < step.size(); ++n) CHECK(outs[0][n] == Approx(outs[1][n]).epsilon(1e-12));
  CHECK(outs[2][100] < 0.9 * outs[1][100]);
}

TEST_CASE("lanes: a lane that is not there is reported with those that are", "[graph]") {
  const auto error = [](const std::string& from) { return test::full_errors_of(with_output(from)); };
  CHECK(error("x[4]") == "test.toml:8:18: 'x' has no lane 4; its lanes are 0 to 3");
  CHECK(error("1 + y[1]") == "test.toml:8:22: 'y' has no lane 1; it has one lane; remove the brackets");
  CHECK(error("x[0..1] + x[0..2]").find("lanes are combined with") != std::string::npos);
  CHECK(error("x[-1]") ==
        "test.toml:8:19: a lane is a whole number from 0 to 1023; write x[2], x[0..3] or x[3, 1]");
  CHECK(error("x[1").find("'[' is not closed") != std::string::npos);
  CHECK(error("x[]").find("a lane is a whole number") != std::string::npos);
  CHECK(error("x[0..99999]").find("a lane is a whole number") != std::string::npos);
  CHECK(error("nix[0]").find("there is no 'nix'") != std::string::npos);
}
