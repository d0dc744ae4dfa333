#include <catch2/catch.hpp>
#include <random>

#include "engine/physics/solvers/link_operator.h"

using namespace tactus;

TEST_CASE("mass_row: vector registers and masses one by one give the same bits", "[physics]") {
  const int count = GENERATE(1, 8, 9, 17, 100);
  const bool alike = GENERATE(false, true);
  const auto n = static_cast<std::size_t>(count);
  std::mt19937 bits(1);
  const auto random = [&bits] { return static_cast<double>(bits()) / 4294967296.0; };
  const auto numbers = [&] {
    AlignedNumbers list(n);
    for (auto& x : list) x = random();
    return list;
  };
  const auto constants = [&] { return alike ? AlignedNumbers(n, random()) : numbers(); };
  const auto k = constants(), b = constants(), scale = constants(), u = numbers();
  auto q = numbers();
  AlignedNumbers push(n);
  std::vector<bool> pushed(n);
  for (std::size_t i = 0; i < n; i += alike ? 50 : 11) pushed[i] = true, push[i] = random();
  std::vector<LinkOperator::Entry> links, left;
  for (int i = 0; i < count; ++i) {
    const auto here = static_cast<std::size_t>(i);
    if (i > 0) links.push_back({i, i - 1, -k[here - 1], -b[here - 1]});
    links.push_back({i, i, 3.0, 0.5});
    if (i + 1 < count) links.push_back({i, i + 1, -k[here], -b[here]});
  }
  MassRow row(links, scale, left);
  row.let_push(pushed);
  CHECK(left.empty());

  AlignedNumbers expected_q(n), expected_u(n), next(n);
  double below = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const bool top = i + 1 == n;
    double own_k = i > 0 ? 3.0 - k[i - 1] : 3.0, own_b = i > 0 ? 0.5 - b[i - 1] : 0.5;
    if (!top) own_k -= k[i], own_b -= b[i];
    const double above = top ? 0.0 : fused_multiply_add(b[i], u[i] - u[i + 1], k[i] * (q[i] - q[i + 1]));
    const double force = fused_multiply_add(-own_b, u[i], fused_multiply_add(-own_k, q[i], below - above));
    expected_u[i] = fused_multiply_add(scale[i], force + push[i], u[i]);
    expected_q[i] = q[i] + expected_u[i];
    below = above;
  }
  row.step(q.data(), u.data(), next.data(), push.data());
  CHECK(next == expected_u);
  CHECK(q == expected_q);
}

TEST_CASE("mass_row: leaves links that jump or reach beyond the masses", "[physics]") {
  const std::vector<LinkOperator::Entry> links = {{0, 0, 2, 0},  {0, 2, -1, 0}, {1, 1, 1, 0},
                                                  {2, 0, -1, 0}, {2, 2, 2, 0},  {2, 3, -1, 0}};
  std::vector<LinkOperator::Entry> left;
  const MassRow row(links, std::vector<double>(3, 1.0), left);
  REQUIRE(left.size() == 3);
  for (const auto& e : left) CHECK(e.k == -1);
}
