#include "engine/physics/solvers/link_operator.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;

TEST_CASE("link_operator: a chain gives the same bits in vector registers and one by one", "[physics]") {
  const int count = GENERATE(1, 2, 8, 9, 10, 15, 16, 17, 24, 100);
  const auto n = static_cast<std::size_t>(count);
  std::mt19937 bits(1);
  const auto random = [&bits] { return static_cast<double>(bits()) / 4294967296.0; };
  const auto numbers = [&] {
    std::vector<double> list(n);
    for (auto& x : list) x = random();
    return list;
  };
  const auto k = numbers(), b = numbers(), q = numbers(), u = numbers(), constant = numbers();
  std::vector<LinkOperator::Entry> links;
  for (int i = 0; i < count; ++i) {
    const auto here = static_cast<std::size_t>(i);
    if (i > 0) links.push_back({i, i - 1, -k[here - 1], -b[here - 1]});
    links.push_back({i, i, 3.0, 0.5});
    if (i + 1 < count) links.push_back({i, i + 1, -k[here], -b[here]});
  }
  const LinkOperator link(links, constant);
  std::vector<double> y(n);
  link.apply(q.data(), u.data(), y.data());
  for (std::size_t i = 0; i < n; ++i) {
    const double own = 3.0 * q[i] + 0.5 * u[i];
    const double above = i + 1 < n ? -k[i] * q[i + 1] + -b[i] * u[i + 1] : 0.0;
    const double below = i > 0 ? -k[i - 1] * q[i - 1] + -b[i - 1] * u[i - 1] : 0.0;
    const double by_column = ((constant[i] - below) - own) - above;
    const double own_first =
        ((constant[i] - own) - (count > 16 ? above : below)) - (count > 16 ? below : above);
    CHECK(y[i] == (count < 16 ? by_column : own_first));
  }
}

TEST_CASE("link_operator: links from anywhere to anywhere add up", "[physics]") {
  const std::vector<LinkOperator::Entry> links = {{0, 0, 2, 1}, {0, 2, -1, 0}, {2, 0, -1, 0},
                                                  {2, 2, 2, 0}, {2, 2, 1, 0},  {2, 3, -4, 0}};
  const LinkOperator link(links, {1, 2, 3});
  const double q[] = {1, 10, 100, 1000}, u[] = {5, 6, 7, 8};
  double y[3];
  link.apply(q, u, y);
  CHECK(y[0] == 1 - 2 * 1 - 1 * 5 + 100);
  CHECK(y[1] == 2);
  CHECK(y[2] == 3 + 1 - 3 * 100 + 4 * 1000);
}

TEST_CASE("link_operator: what lies along diagonals is what its entries add up to", "[physics]") {
  // Grids of so many columns, with a diagonal that ends in their middle, and two more than one pass takes.
  const int columns = GENERATE(3, 8, 20), more = GENERATE(0, 1, 2), masses = 20 * columns;
  std::mt19937 bits(1);
  const auto random = [&bits] { return static_cast<double>(bits()) / 4294967296.0; };
  std::vector<LinkOperator::Entry> links;
  for (int row = 0; row < masses; ++row) {
    links.push_back({row, row, random(), random()});
    for (const int offset : {1, columns, columns + 3, columns + 5})
      if (row + offset < (offset > columns ? more * masses / 2 : masses)) {
        const double k = random(), b = random();
        links.push_back({row, row + offset, k, b}), links.push_back({row + offset, row, k, b});
      }
  }
  links.push_back({2, masses - 1, 1.0, 2.0});
  std::vector<double> constant(static_cast<std::size_t>(masses)), y(constant.size()), q(constant.size()),
      u(constant.size());
  for (auto* list : {&constant, &q, &u})
    for (auto& x : *list) x = random();
  auto expected = constant;
  for (const auto& e : links)
    expected[static_cast<std::size_t>(e.row)] -=
        e.k * q[static_cast<std::size_t>(e.column)] + e.b * u[static_cast<std::size_t>(e.column)];
  LinkOperator(links, constant).apply(q.data(), u.data(), y.data());
  // Some twenty sums of numbers below 1.
  for (std::size_t i = 0; i < y.size(); ++i) CHECK(y[i] == Approx(expected[i]).margin(20 * 2.3e-16 * 20));
}
