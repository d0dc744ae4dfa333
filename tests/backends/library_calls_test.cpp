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

TEST_CASE("patient call: a slow listing is reported, and waited for", "[backends]") {
  auto reported = std::make_shared<std::promise<void>>();
  std::string message;
  on_slow_call([&](const std::string& slow) {
    message = slow;
    reported->set_value();
  });
  CHECK(call_with_timeout([reported] { reported->get_future().wait(); }, 60s, "still looking"));
  CHECK(message == "still looking");
  on_slow_call({});
  CHECK(call_with_timeout([] {}, 60s, "still looking"));
}

TEST_CASE("silence until lost: a card without a server is lost when no block comes", "[backends]") {
  CHECK_FALSE(silence_until_lost("jack"));  // a stopped server may go on
  CHECK(silence_until_lost("alsa") == 1s);
  CHECK(silence_until_lost("core") == 5s);  // reports no error when it is unplugged
  CHECK(silence_until_lost("wasapi") == 5s);
}
