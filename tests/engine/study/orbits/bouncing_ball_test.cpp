#include "engine/study/orbits/bouncing_ball.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "engine/core/units.h"

using namespace tactus;

TEST_CASE("bouncing ball: closed forms of the orbit that hits once a period", "[physics]") {
  // Gamma_1 = pi (1-e)/(1+e); Gamma'_1 by trace and determinant of the map.
  CHECK(BouncingBall::orbit_begins(1, 0.5) == Approx(1.047198).epsilon(0).margin(1e-6));
  CHECK(BouncingBall::orbit_doubles(1, 0.2) == Approx(2.544192).epsilon(0).margin(1e-6));
  CHECK(BouncingBall::orbit_doubles(1, 0.5) == Approx(1.526824).epsilon(0).margin(1e-6));
  CHECK(BouncingBall::orbit_doubles(1, 0.85) == Approx(1.038304).epsilon(0).margin(1e-6));
  CHECK(BouncingBall::orbit_doubles(1, 0.9) == Approx(1.016311).epsilon(0).margin(1e-6));
}

TEST_CASE("bouncing ball: the orbit of each mode returns to itself", "[physics]") {
  const int mode = GENERATE(1, 2, 3);
  const BouncingBall ball(1.05 * BouncingBall::orbit_begins(mode, 0.6), 0.6);
  const auto start = ball.orbit(mode), end = ball.next(start);
  CHECK(end.phase - start.phase == Approx(2 * kPi * mode).epsilon(0).margin(1e-12));
  CHECK(end.speed == Approx(start.speed).epsilon(0).margin(1e-12));
}

TEST_CASE("bouncing ball: the derivative of the map is that of small differences", "[physics]") {
  const BouncingBall ball(1.6, 0.5);
  const BouncingBall::Bounce from{0.4, 3.5};
  const auto made = ball.next_linearised(from);
  const double step = 1e-6;
  const auto late = ball.next({from.phase + step, from.speed}),
             early = ball.next({from.phase - step, from.speed});
  const auto fast = ball.next({from.phase, from.speed + step}),
             slow = ball.next({from.phase, from.speed - step});
  CHECK(made.jacobian.a == Approx((late.phase - early.phase) / (2 * step)).epsilon(1e-8));
  CHECK(made.jacobian.c == Approx((late.speed - early.speed) / (2 * step)).epsilon(1e-8));
  CHECK(made.jacobian.b == Approx((fast.phase - slow.phase) / (2 * step)).epsilon(1e-8));
  CHECK(made.jacobian.d == Approx((fast.speed - slow.speed) / (2 * step)).epsilon(1e-8));
}

TEST_CASE("bouncing ball: the period doubles and doubles again where it is known to", "[physics]") {
  struct Known {
    double restitution;
    std::vector<double> drives;
  };
  // The first is the closed form; the others come from an event-driven program of another hand.
  const auto known =
      GENERATE(values<Known>({{0.2, {2.544192, 2.7322355349, 2.7756321230, 2.7850789571, 2.7871097820}},
                              {0.5, {1.526824, 1.6671306608, 1.6967807458, 1.7031805256, 1.7045564692}},
                              {0.85, {1.038304, 1.1997326504, 1.2266612514, 1.2306611688, 1.2314342566}}}));
  const auto found = period_doublings(1, known.restitution, 5);
  REQUIRE(found.size() == 5);
  CHECK(found[0] == Approx(BouncingBall::orbit_doubles(1, known.restitution)).epsilon(1e-9));
  for (std::size_t i = 0; i < 5; ++i) CHECK(found[i] == Approx(known.drives[i]).epsilon(0).margin(1e-6));
}

TEST_CASE("bouncing ball: the intervals between doublings shrink as Feigenbaum's constant says",
          "[physics]") {
  const auto found = period_doublings(1, 0.5, 6);
  REQUIRE(found.size() == 6);
  // From 4 to 8, 8 to 16, 16 to 32 and 32 to 64; in the limit 4.6692.
  CHECK((found[3] - found[2]) / (found[4] - found[3]) == Approx(4.65).epsilon(0).margin(0.05));
  CHECK((found[4] - found[3]) / (found[5] - found[4]) == Approx(4.669).epsilon(0).margin(0.01));
}

TEST_CASE("bouncing ball: e = 0.9 keeps its period at a drive of 1.00 and not at 1.03", "[physics]") {
  const auto after = [](double drive) {
    const BouncingBall ball(drive, 0.9);
    auto bounce = ball.orbit(1);
    const double speed = bounce.speed;
    bounce.speed += 1e-6;
    for (int i = 0; i < 2000; ++i) bounce = ball.next(bounce);
    return std::abs(bounce.speed - speed);
  };
  CHECK(std::acos(BouncingBall::orbit_begins(1, 0.9)) == Approx(std::acos(0.165347)).epsilon(0).margin(1e-6));
  CHECK(after(1.00) < 1e-12);
  CHECK(after(1.03) > 1e-2);
}

TEST_CASE("bouncing ball: a ball at rest lifts off above a drive of 1 only", "[physics]") {
  CHECK(BouncingBall(0.99, 0.5).next({0.0, 0.99}).resting);
  const auto flown = BouncingBall(1.01, 0.5).next({0.0, 1.01});
  CHECK_FALSE(flown.resting);
  // It leaves at sin(theta) = 1/Gamma and lands a little later.
  CHECK(flown.phase > std::asin(1.0 / 1.01));
}

TEST_CASE(
    "bouncing ball: ever smaller bounces end by sticking, and it flies on from where the table falls away",
    "[physics]") {
  // e = 0: after each landing it leaves where Gamma sin(theta) = 1, so that all flights are alike.
  const BouncingBall ball(1.5, 0.0);
  BouncingBall::Bounce bounce{0.0, 1.5};
  std::vector<double> phases;
  for (int i = 0; i < 6; ++i) {
    bounce = ball.next(bounce);
    REQUIRE_FALSE(bounce.resting);
    phases.push_back(std::fmod(bounce.phase, 2 * kPi));
  }
  for (std::size_t i = 1; i < phases.size(); ++i)
    CHECK(phases[i] == Approx(phases[0]).epsilon(0).margin(1e-9));
}
