#include "engine/study/stability/models/nonlinearities.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "engine/graph/plan/plan.h"

using namespace tactus;

namespace {

const Plan kPlan;

PlanSignal signal(int vertex) { return {&kPlan, vertex, 0}; }

const PlanSignal kX = signal(0), kY = signal(1);
const Operator& kMultiply = operator_of(Expression::Op::Multiply);

/// Answers by `slope` beyond `from`, on the side where `from` lies.
Nonlinearity stop(const char* path, const PlanSignal& source, double from, double slope = 1) {
  return {path, source, 1.1 * from,
          [=](double moved) { return from > 0 ? (moved > from ? slope : 0) : (moved < from ? slope : 0); }};
}

}  // namespace

TEST_CASE("nonlinearities: signals are derived through sums and multiples, and nothing else", "[analysis]") {
  AffineMaps derivations;
  const auto scaled = signal(2), sum = signal(3), squared = signal(4), number = signal(5);
  derivations.note(scaled, kMultiply, {kX, number}, {{0, -3}, {true, false}});
  derivations.note(sum, operator_of(Expression::Op::Subtract), {kX, scaled}, {{0, 0}, {true, true}});
  derivations.note(squared, kMultiply, {kX, kX}, {{0.5, 0.5}, {true, true}});

  CHECK((derivations.of(scaled).source == kX));
  CHECK(derivations.of(scaled).slope == -3);
  CHECK(derivations.of(sum).slope == 4);  // x - (-3 x)
  CHECK((derivations.of(squared).source == squared));
  CHECK(derivations.moved(sum, {{kX, 0.25}}).value() == 1);
  CHECK_FALSE(derivations.moved(sum, {{kY, 0.25}}));
}

TEST_CASE("nonlinearities: a corner answers beyond its edge, on the side where it comes through",
          "[analysis]") {
  // max(0, -2 x - 0.1): from x = -0.05 down.
  const auto law = corner("stop", operator_of(Expression::Op::Max), {{0, -0.1}, {false, true}}, 1, {kX, -2});
  REQUIRE(law);
  CHECK(law->to == Approx(-0.05).epsilon(1e-5));
  CHECK(law->to < -0.05);
  CHECK(law->answer(law->to) == 1);
  CHECK(law->answer(0) == 0);
  CHECK_FALSE(corner("sum", operator_of(Expression::Op::Add), {{0, 0}, {false, true}}, 1, {kX, 1}));
}

TEST_CASE("nonlinearities: stops at both ends are two places, on one side they are one", "[analysis]") {
  const auto ends = operating_points({stop("low", kX, -1), stop("high", kX, 1)});
  REQUIRE(ends.size() == 2);
  CHECK(ends[0].name == "'low' at its largest slope");
  CHECK(ends[0].moved.at(kX) == Approx(-1.1));
  CHECK(ends[1].moved.at(kX) == Approx(1.1));

  const auto same_side = operating_points({stop("near", kX, 1), stop("far", kX, 2)});
  REQUIRE(same_side.size() == 1);
  CHECK(same_side[0].moved.at(kX) == Approx(2.2));
}

TEST_CASE("nonlinearities: overlapping laws are analysed at the steepest point of their sum, too",
          "[analysis]") {
  // Two bells nearer than 2 / sqrt 2 widths: their sum has one summit, in the middle.
  const auto bell = [](const char* path, double middle, double height) {
    return Nonlinearity{path, kX, middle,
                        [=](double x) { return height * std::exp(-(x - middle) * (x - middle)); }};
  };
  const auto places = operating_points({bell("low", -0.6, 1), bell("high", 0.6, 1)});
  REQUIRE(places.size() == 3);
  CHECK(places[2].name == "'low' with 'high' at its largest slope");
  CHECK(places[2].moved.at(kX) == Approx(0).margin(1e-3));
}

TEST_CASE("nonlinearities: stops on different signals are met in every combination", "[analysis]") {
  const std::vector<Nonlinearity> both{stop("low", kX, -1), stop("high", kX, 1), stop("floor", kY, -1),
                                       stop("roof", kY, 1)};
  const auto places = operating_points(both);
  REQUIRE(places.size() == 4);
  for (const auto& place : places) CHECK(place.moved.size() == 2);
}

TEST_CASE("nonlinearities: with too many combinations each signal is displaced alone, and all are steepest",
          "[analysis]") {
  std::vector<Nonlinearity> laws;
  for (int source = 0; source < 5; ++source) {
    laws.push_back(stop("low", signal(source), -1));
    laws.push_back(stop("high", signal(source), 1));
  }
  const auto places = operating_points(laws);  // 32 of at most 16
  REQUIRE(places.size() == 11);
  for (int place = 0; place < 10; ++place) {
    const auto& moved = places[static_cast<std::size_t>(place)].moved;
    CHECK(moved.size() == 5);
    CHECK(std::ranges::count_if(moved, [](const auto& signal) { return signal.second != 0.0; }) == 1);
  }
  CHECK(places.back().moved.empty());
}
