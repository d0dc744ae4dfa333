#include "backends/library_calls.h"

#include <catch2/catch.hpp>
#include <future>
#include <memory>

using namespace tactus;
using namespace std::chrono_literals;

TEST_CASE("patient call: waits for a call that returns, and what it owned is gone then", "[backends]") {
  auto owned = std::make_shared<int>(1);
  const std::weak_ptr<int> watched = owned;
  auto ran = std::make_shared<int>(0);
  CHECK(call_with_timeout([owned = std::move(owned), ran] { *ran += *owned; }, 10s));
  CHECK(*ran == 1);
  CHECK(watched.expired());
}

TEST_CASE("patient call: gives up on a call that does not return", "[backends]") {
  auto never = std::make_shared<std::promise<void>>();
  auto ended = std::make_shared<std::promise<void>>();
  CHECK_FALSE(call_with_timeout(
      [never, ended] {
        never->get_future().wait();
        ended->set_value();
      },
      1ms));
  never->set_value();  // so that the test leaves no thread behind
  ended->get_future().wait();
}
