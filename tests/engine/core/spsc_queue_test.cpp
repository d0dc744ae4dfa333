#include "engine/core/spsc_queue.h"

#include <catch2/catch.hpp>
#include <cstdint>
#include <thread>

using tactus::SpscQueue;

TEST_CASE("spsc_queue: gives back what was pushed, oldest first", "[core]") {
  SpscQueue<int> queue{4};
  int item = -1;
  CHECK_FALSE(queue.pop(item));
  CHECK(item == -1);
  // Three rounds of four, so that the slots wrap.
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 4; ++i) REQUIRE(queue.push(10 * round + i));
    REQUIRE(queue.front() != nullptr);
    CHECK(*queue.front() == 10 * round);
    for (int i = 0; i < 4; ++i) {
      REQUIRE(queue.pop(item));
      CHECK(item == 10 * round + i);
    }
  }
  CHECK(queue.front() == nullptr);
}

TEST_CASE("spsc_queue: rounds its capacity up to a power of two and refuses one item more", "[core]") {
  SpscQueue<int> queue{5};
  REQUIRE(queue.capacity() == 8);
  for (int i = 0; i < 8; ++i) REQUIRE(queue.push(i));
  CHECK_FALSE(queue.push(8));
  int item = -1;
  REQUIRE(queue.pop(item));
  CHECK(item == 0);
  CHECK(queue.push(8));
}

TEST_CASE("spsc_queue: two threads, 200,000 items, none lost, doubled or torn", "[core]") {
  struct Pair {
    std::int64_t number, negative;
  };
  constexpr std::int64_t kItems = 200'000;
  SpscQueue<Pair> queue{64};
  std::thread producer{[&] {
    for (std::int64_t n = 0; n < kItems;) {
      if (queue.push({n, -n}))
        ++n;
      else
        std::this_thread::yield();
    }
  }};
  std::int64_t expected = 0;
  std::int64_t wrong = 0;
  while (expected < kItems) {
    Pair pair{};
    if (!queue.pop(pair)) {
      std::this_thread::yield();
      continue;
    }
    wrong += pair.number == expected && pair.negative == -expected ? 0 : 1;
    ++expected;
  }
  producer.join();
  CHECK(wrong == 0);
  CHECK(queue.front() == nullptr);
}
