#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/mostly_idle_graph.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

TEST_CASE("compile: 10000 nodes of which 12 matter become the steps and the memory of the 12", "[graph]") {
  const auto alone = test::engine_of(test::twelve_alone());
  const auto among = test::engine_of(test::twelve_among(10'000));
  const auto &few = alone->plan(), &many = among->plan();
  CHECK(many.steps.size() == few.steps.size());
  CHECK(many.operations.size() == few.operations.size());
  CHECK(many.nodes.size() == few.nodes.size());
  CHECK(many.arena.size() == few.arena.size());
  CHECK(many.sections.size() == few.sections.size());
  const auto x = test::noise(5000, 1);
  CHECK(test::run(*among, {x}, 5000, {64}) == test::run(*alone, {x}, 5000, {64}));
}

TEST_CASE("compile: each of the 9988 nodes that do not run is named, with the reason", "[graph]") {
  const auto engine = test::engine_of(test::twelve_among(10'000));
  std::set<std::string> named;
  std::map<std::string, int> reasons;
  for (const auto& left : engine->plan().left_out) {
    named.insert(left.path);
    ++reasons[left.reason.starts_with("is always") ? "is always" : left.reason];
  }
  const auto idle =
      std::count_if(named.begin(), named.end(), [](const auto& name) { return name.starts_with("idle"); });
  CHECK(idle == 9988);
  CHECK(reasons["is always"] == 1998);
  CHECK(reasons["reaches only signals that are multiplied by zero"] == 400);
  CHECK(reasons["its output is not used"] == 1997);
}

TEST_CASE("compile: a node that an input keeps at 0 does not run, nor what only it sounds through",
          "[graph]") {
  const auto graph = [](const std::string& nodes) {
    return "format = 1\nname = \"t\"\n[inputs]\nx = {}\n[controls]\nloud = { value = 0, range = [0, 1] }\n"
           "[nodes]\n" +
           nodes + "\n[outputs]\ny = { from = \"0.5 * x + silent\" }\n";
  };
  const char* const silent[] = {
      "silent = { type = \"sine\", frequency = \"440 Hz * (1 + x)\", level = 0 }",
      "silent = { type = \"noise\", level = \"2 * 0\" }",
      "silent = { type = \"decay\", trigger = 0, time = \"10 ms\", level = \"x\" }",
      "silent = { type = \"adsr\", gate = 0 }",
      "silent = { type = \"string\", in = 0, pitch = \"100 Hz * (2 + x)\" }",
      "hush = { type = \"sine\", frequency = \"440 Hz\", level = 0 }\n"
      "body = { type = \"modal\", in = \"hush\", modes = 100 }\n"
      "silent = { type = \"delay\", in = \"0.9 * body\", time = \"20 ms\" }",
      "bumps = { type = \"terrain\", position = \"1 mm * x\", weight = \"0 N\", profile = \"sine\" }\n"
      "silent = \"bumps.out / 1 N\"",
      "back = { type = \"delay\", in = \"0\", time = \"5 ms\" }\nsilent = { type = \"one_pole\", in = "
      "\"back\", cutoff = \"1 kHz\" }",
  };
  for (const auto* nodes : silent) {
    INFO(nodes);
    const auto engine = test::engine_of(graph(nodes));
    CHECK(engine->plan().nodes.empty());
    const auto x = test::noise(500, 2);
    const auto y = test::run(*engine, {x}, 500, {64})[0];
    for (std::size_t n = 0; n < 500; ++n) REQUIRE(y[n] == 0.5 * x[n]);
  }
  // A control may still move.
  const auto moving =
      test::engine_of(graph("silent = { type = \"sine\", frequency = \"440 Hz\", level = \"loud\" }"));
  CHECK(moving->plan().nodes.size() == 1);
  // A delay in a loop with its own filter asks the filter for its phase.
  const auto tuned =
      test::engine_of(graph("low = { type = \"one_pole\", in = 0, cutoff = \"1 kHz\" }\n"
                            "silent = { type = \"delay\", in = \"x + low\", time = \"5 ms\", "
                            "compensate = [\"low\"] }"));
  CHECK(tuned->plan().nodes.size() >= 1);
}

TEST_CASE("compile: modes that never sound are left out of a bank", "[graph]") {
  const auto bank = [](const std::string& fields) {
    return "format = 1\nname = \"t\"\n[inputs]\nx = {}\n[controls]\nf = { value = \"100 Hz\", range = [\"50 "
           "Hz\", \"1 kHz\"] }\n[nodes]\nbody = { type = \"modal\", in = \"x\", series = \"harmonic\", " +
           fields + " }\n[outputs]\ny = { from = \"body\" }\n";
  };
  const auto left = [](const Player& player) {
    for (const auto& [path, reason] : player.plan().left_out)
      if (path == "body.modes") return reason;
    return std::string{};
  };
  const auto silent = [](const std::string& how_many) {
    return how_many + " are silent: of gain 0, or at half the sample rate or above";
  };
  const auto x = test::noise(2000, 4);
  // At 48 kHz the partials 24, 25 ... of 1 kHz lie at half the rate and above.
  const auto few = test::engine_of(bank("frequency = \"1 kHz\", modes = 23"));
  const auto many = test::engine_of(bank("frequency = \"1 kHz\", modes = 1000"));
  CHECK(left(*few).empty());
  CHECK(left(*many) == silent("977 of 1000"));
  CHECK(test::run(*many, {x}, 2000, {64}) == test::run(*few, {x}, 2000, {64}));
  // Where the frequency may fall to 50 Hz, 479 modes may sound.
  const auto moving = test::engine_of(bank("frequency = \"f\", modes = 1000"));
  CHECK(left(*moving) == silent("521 of 1000"));
  const auto muted = test::engine_of(bank("frequency = \"1 kHz\", modes = 3, gains = [1, 0, 1]"));
  CHECK(left(*muted) == silent("1 of 3"));
}

TEST_CASE("compile: what is written twice runs once", "[graph]") {
  const auto graph = [](const std::string& nodes, const std::string& out) {
    return "format = 1\nname = \"t\"\n[inputs]\nx = {}\n[nodes]\n" + nodes + "\n[outputs]\ny = { from = \"" +
           out + "\" }\n";
  };
  const std::string pair =
      "a = { type = \"low_pass\", in = \"2 * x\", cutoff = \"1 kHz\" }\n"
      "echo_a = { type = \"delay\", in = \"a\", time = \"5 ms\" }\n"
      "b = { type = \"low_pass\", in = \"2 * x\", cutoff = \"1000 Hz\" }\n"
      "echo_b = { type = \"delay\", in = \"b\", time = \"5 ms\" }\n";
  const auto both = test::engine_of(graph(pair, "echo_a - 0.5 * echo_b"));
  CHECK(both->plan().nodes.size() == 2);
  std::map<std::string, std::string> left;
  for (const auto& [path, reason] : both->plan().left_out) left[path] = reason;
  const std::map<std::string, std::string> expected{{"b", "equals 'a'"}, {"echo_b", "equals 'echo_a'"}};
  CHECK(left == expected);
  const auto one = test::engine_of(graph(pair, "echo_a - 0.5 * echo_a"));
  const auto x = test::noise(1000, 5);
  CHECK(test::run(*both, {x}, 1000, {64}) == test::run(*one, {x}, 1000, {64}));

  struct Case {
    std::string nodes;
    std::size_t run;
  };
  const Case cases[] = {
      // Noise is meant to be two.
      {"a = { type = \"noise\" }\nb = { type = \"noise\" }", 2},
      {"a = { type = \"noise\", seed = 2 }\nb = { type = \"noise\", seed = 3 }", 2},
      {"a = { type = \"low_pass\", in = \"x\", cutoff = \"1 kHz\" }\n"
       "b = { type = \"low_pass\", in = \"x\", cutoff = \"1001 Hz\" }",
       2},
      {"a = { type = \"low_pass\", in = \"x\", cutoff = \"1 kHz\" }\n"
       "b = { type = \"high_pass\", in = \"x\", cutoff = \"1 kHz\" }",
       2},
      {"a = { type = \"modal\", in = \"x\", modes = 3 }\nb = { type = \"modal\", in = \"x\", modes = 4 }", 2},
      {"a = { type = \"modal\", in = \"x\", modes = 3 }\nb = { type = \"modal\", in = \"x\", modes = 3 }", 1},
      // What reads itself is another thing each time.
      {"a = { type = \"delay\", in = \"x + 0.5 * a\", time = \"5 ms\" }\n"
       "b = { type = \"delay\", in = \"x + 0.5 * b\", time = \"5 ms\" }",
       2},
  };
  for (const auto& [nodes, run] : cases) {
    INFO(nodes);
    CHECK(test::engine_of(graph(nodes, "a - 0.5 * b"))->plan().nodes.size() == run);
  }
}
