#include "export/merge_loops.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

using namespace tactus;

namespace {

constexpr int kLanes = 8;

/// Two loops over the same lanes, the second behind the declaration of `y`.
CProgram two_loops(const std::string& first, const std::string& second) {
  CProgram program;
  program.frame = {{"tactus_real x[8];"},
                   {first, 1, kLanes},
                   {"tactus_real y[8];"},
                   {second, 1, kLanes},
                   {"out[8] = y[0];"}};
  return program;
}

std::vector<std::string> loops_of(const CProgram& program) {
  std::vector<std::string> loops;
  for (const auto& statement : program.frame)
    if (statement.lanes == kLanes) loops.push_back(statement.text);
  return loops;
}

std::vector<std::string> merged(const std::string& first, const std::string& second) {
  auto program = two_loops(first, second);
  merge_loops(program);
  return loops_of(program);
}

}  // namespace

TEST_CASE("merge loops: lanes that do not need each other become one loop, without arrays in between",
          "[export]") {
  auto program = two_loops("x[lane] = 2.0 * in[lane];", "y[lane] = 3.0 + x[lane];");
  merge_loops(program);
  CHECK(loops_of(program) ==
        std::vector<std::string>{"const tactus_real x = 2.0 * in[lane];\ny[lane] = 3.0 + x;"});
  // y is read behind the loop, and declared before it.
  CHECK(program.frame.front().text == "tactus_real y[8];");
}

TEST_CASE("merge loops: members of the state keep their places", "[export]") {
  CHECK(merged("x[lane] = tactus_recurrence_pole(0.5, 0.5, in[lane], &s->x[lane]);", "y[lane] = x[lane];") ==
        std::vector<std::string>{
            "const tactus_real x = tactus_recurrence_pole(0.5, 0.5, in[lane], &s->x[lane]);\ny[lane] = x;"});
}

TEST_CASE("merge loops: a lane that needs another one waits for all of them", "[export]") {
  CHECK(merged("x[lane] = in[lane];", "y[lane] = x[7 - lane];").size() == 2);
  CHECK(merged("x[lane] = s->held[lane];", "s->held[7 - lane] = in[lane]; y[lane] = 0.0;").size() == 2);
  CHECK(merged("x[lane] = tactus_next(&noise);", "y[lane] = tactus_next(&noise);").size() == 2);
  CHECK(merged("x[lane] = in[lane]; s->sum += x[lane];", "y[lane] = s->sum;").size() == 2);
}

TEST_CASE("merge loops: outputs may be written over inputs, each in its place", "[export]") {
  CHECK(merged("x[lane] = in[lane];", "y[lane] = x[lane]; out[lane] = y[lane];").size() == 1);
  CHECK(merged("x[lane] = in[lane];", "y[lane] = x[lane]; out[1 + lane] = y[lane];").size() == 2);
  CHECK(merged("x[lane] = in[2 + lane];", "y[lane] = x[lane]; out[lane] = y[lane];").size() == 2);
}

TEST_CASE("merge loops: what several statements of a lane check is checked once", "[export]") {
  auto program = two_loops("x[lane] = in[lane];\nx_fault |= x[lane] - x[lane] != 0;",
                           "y[lane] = x[lane];\ny_fault |= y[lane] - y[lane] != 0;");
  program.frame.insert(program.frame.begin() + 1, {"int x_fault = 0;"});
  program.frame.insert(program.frame.begin() + 4, {"int y_fault = 0;"});
  program.faults = {"x_fault", "y_fault"};
  merge_loops(program);
  CHECK(loops_of(program) == std::vector<std::string>{"const tactus_real x = in[lane];\ny[lane] = x;\n"
                                                      "x_fault |= (x - x) + (y[lane] - y[lane]) != 0;"});
  CHECK(program.faults == std::vector<std::string>{"x_fault"});
}
