#include "remote/order_queue.h"

#include <catch2/catch.hpp>
#include <thread>

using namespace tactus;

namespace {

std::vector<RemoteOrder> orders(std::size_t count, int number) {
  return std::vector<RemoteOrder>(count, {.number = number, .received = {}});
}

}  // namespace

TEST_CASE("order queue: bundles come out whole and in order, across threads", "[remote]") {
  OrderQueue queue;
  constexpr int kBundles = 20'000;
  std::thread network{[&] {
    for (int b = 0; b < kBundles; ++b) {
      const auto bundle = orders(static_cast<std::size_t>(1 + b % 7), b);
      while (!queue.push(bundle)) std::this_thread::yield();
    }
  }};
  int wrong = 0;
  for (int b = 0; b < kBundles;) {
    std::vector<RemoteOrder> bundle;
    if (!queue.pop(bundle)) {
      std::this_thread::yield();
      continue;
    }
    wrong += bundle.size() != static_cast<std::size_t>(1 + b % 7) || bundle.front().number != b ||
             bundle.back().number != b;
    ++b;
  }
  network.join();
  CHECK(wrong == 0);
}

TEST_CASE("order queue: a bundle that does not fit is refused as a whole", "[remote]") {
  OrderQueue queue;
  REQUIRE(queue.push(orders(OrderQueue::kOrders - 1, 1)));
  CHECK_FALSE(queue.push(orders(2, 2)));
  CHECK(queue.push(orders(1, 3)));
  std::vector<RemoteOrder> bundle;
  REQUIRE(queue.pop(bundle));
  CHECK(bundle.size() == OrderQueue::kOrders - 1);
  REQUIRE(queue.pop(bundle));
  CHECK(bundle.front().number == 3);
  CHECK_FALSE(queue.pop(bundle));
  CHECK(queue.push(orders(OrderQueue::kOrders, 4)));
}
