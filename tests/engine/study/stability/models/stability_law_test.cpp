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

TEST_CASE("stability law: slopes of operators are the derivatives of their values", "[analysis]") {
  for (const auto& type : kOperators) {
    if (type.slope == nullptr || type.value == nullptr) continue;
    INFO(type.name);
    const OperandValues inside{type.op == Expression::Op::Acos ? -0.25 : 0.4, 0.75, -0.3};
    const double step = 1e-6;
    for (int which = type.small_signal == SmallSignal::Choice ? 1 : 0; which < type.operands; ++which) {
      auto above = inside, below = inside;
      above[index(which)] += step;
      below[index(which)] -= step;
      const double difference =
          type.value(above[0], above[1], above[2]) - type.value(below[0], below[1], below[2]);
      CHECK(slope_of(type, {inside, {true, true, true}}, which, false).value() ==
            Approx(difference / (2 * step)).margin(1e-8));
    }
  }
}

TEST_CASE("stability law: what steps has no slope, and neither has a root at 0", "[analysis]") {
  for (const auto op :
       {Expression::Op::Less, Expression::Op::Floor, Expression::Op::Sign, Expression::Op::Mod})
    CHECK_FALSE(slope_of(operator_of(op), {{0.3, 0.7}, {true, true}}, 0, false));
  CHECK_FALSE(slope_of(operator_of(Expression::Op::Select), {{1, 2, 3}, {true, true, true}}, 0, false));
  CHECK_FALSE(slope_of(operator_of(Expression::Op::Sqrt), {{0}, {true}}, 0, false));
}

TEST_CASE("stability law: a wall made of a maximum is open at rest and closed when touched", "[analysis]") {
  // max(0, depth) with the depth at -5 mm: the 0 wins, but it never moves.
  const Operands operands{{0, -0.005}, {false, true}};
  CHECK(slope_of(operator_of(Expression::Op::Max), operands, 1, false) == 0.0);
  CHECK(slope_of(operator_of(Expression::Op::Max), operands, 1, true) == 1.0);
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
