#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/table.h"
#include "engine/study/stability/models/nonlinearities.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

std::unique_ptr<Node> made(const NodeType& type) {
  NodeSetup setup{};
  setup.type = &type;
  setup.inputs.resize(type.inputs.size());
  auto node = type.make(setup);
  REQUIRE(node);
  return std::move(*node);
}

}  // namespace

TEST_CASE("stability law: slopes of operations are their derivatives", "[analysis]") {
  const auto op = GENERATE(Expression::Op::Add, Expression::Op::Subtract, Expression::Op::Multiply,
                           Expression::Op::Divide, Expression::Op::Min, Expression::Op::Max,
                           Expression::Op::Negate, Expression::Op::Abs);
  const auto value = [op](double a, double b) {
    switch (op) {
      case Expression::Op::Add:
        return a + b;
      case Expression::Op::Subtract:
        return a - b;
      case Expression::Op::Multiply:
        return a * b;
      case Expression::Op::Divide:
        return a / b;
      case Expression::Op::Min:
        return std::min(a, b);
      case Expression::Op::Max:
        return std::max(a, b);
      case Expression::Op::Negate:
        return -a;
      default:
        return std::abs(a);
    }
  };
  const double a = -1.25, b = 0.75, step = 1e-6;
  const Operands operands{a, b, {true, true}};
  CHECK(slope_of(op, operands, 0, false) ==
        Approx((value(a + step, b) - value(a - step, b)) / (2 * step)).margin(1e-8));
  if (operands_of(op) == 2)
    CHECK(slope_of(op, operands, 1, false) ==
          Approx((value(a, b + step) - value(a, b - step)) / (2 * step)).margin(1e-8));
}

TEST_CASE("stability law: a wall made of a maximum is open at rest and closed when touched", "[analysis]") {
  // max(0, depth) with the depth at -5 mm: the 0 wins, but it never moves.
  const Operands operands{0, -0.005, {false, true}};
  CHECK(slope_of(Expression::Op::Max, operands, 1, false) == 0);
  CHECK(slope_of(Expression::Op::Max, operands, 1, true) == 1);
}

TEST_CASE("stability law: the steepest place of a wall lies behind it", "[analysis]") {
  const auto wall = made(test::node_type("wall"));
  // Position, velocity, stiffness, damping, place of the wall.
  const std::vector<double> rest{0, 0, 800, 3, 0.02};
  const auto steep = steepest(*wall, test::node_type("wall"), rest, {true, true, false, false, false}).at;
  CHECK(steep[0] > 0.02);
  CHECK(wall->response(0, 0, 1.0, rest).value() == 0.0);
  CHECK(wall->response(0, 0, 1.0, steep).value() == -800.0);
  CHECK(wall->response(1, 0, 1.0, steep).value() == -3.0);
}

TEST_CASE("stability law: a clip that is driven far beyond its limits is steepest between them",
          "[analysis]") {
  const auto clip = made(test::node_type("clip"));
  const std::vector<double> saturated{1e9, -6.37, 6.37};
  CHECK(clip->response(0, 0, 1.0, saturated).value() == 0.0);
  const auto steep = steepest(*clip, test::node_type("clip"), saturated, {true, false, false});
  CHECK(steep.answer == 1.0);
  CHECK(std::abs(steep.at[0]) < 6.37);
}
