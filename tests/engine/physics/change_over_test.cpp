#include "engine/physics/change_over.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

using namespace tactus;

TEST_CASE("change over: a fast decay rounds nothing of a slow one that it feeds", "[physics]") {
  // x' = -a x, y' = c x - b y:  of y from x  c (e^-b - e^-a) / (a - b), of itself e^-b - 1.
  const double a = GENERATE(1.0, 1e3, 1e6, 1e9, 1e12), b = GENERATE(1e-12, 1e-6, 1e-2), c = 0.5 * a;
  Eigen::Matrix2d rates;
  rates << -a, 0.0, c, -b;
  const Eigen::MatrixXd change = change_over(rates);
  CHECK(change(0, 0) == Approx(std::expm1(-a)).epsilon(1e-13));
  CHECK(change(0, 1) == 0.0);
  CHECK(change(1, 1) == Approx(std::expm1(-b)).epsilon(1e-13));
  CHECK(change(1, 0) == Approx(c * (std::exp(-b) - std::exp(-a)) / (a - b)).epsilon(1e-13));
}

TEST_CASE("change over: a swing turns by its angle", "[physics]") {
  const double angle = GENERATE(1e-9, 0.3, 2.0, 30.0);
  Eigen::Matrix2d rates;
  rates << 0.0, angle, -angle, 0.0;
  const Eigen::MatrixXd change = change_over(rates);
  const double half = std::sin(0.5 * angle), rounding = 1e-14 * (1.0 + angle) * std::min(1.0, angle);
  CHECK(change(0, 0) == Approx(-2.0 * half * half).epsilon(1e-13).margin(rounding));
  CHECK(change(0, 1) == Approx(std::sin(angle)).epsilon(1e-13).margin(rounding));
  CHECK(change(1, 0) == Approx(-std::sin(angle)).epsilon(1e-13).margin(rounding));
}

TEST_CASE("change over: what does not decay keeps its polynomial, what is infinite is not a number",
          "[physics]") {
  Eigen::Matrix3d shift = Eigen::Matrix3d::Zero();
  shift(0, 1) = 3.0, shift(1, 2) = 5.0;
  const Eigen::MatrixXd change = change_over(shift);
  CHECK(change(0, 1) == Approx(3.0).epsilon(1e-15));
  CHECK(change(0, 2) == Approx(7.5).epsilon(1e-15));
  CHECK(change(2, 0) == 0.0);
  shift(1, 0) = std::numeric_limits<double>::infinity();
  CHECK(std::isnan(change_over(shift)(2, 2)));
}
