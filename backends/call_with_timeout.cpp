#include "backends/call_with_timeout.h"

#include <future>
#include <memory>
#include <thread>

namespace tactus {

bool call_with_timeout(std::function<void()> call, std::chrono::milliseconds patience) {
  auto done = std::make_shared<std::promise<void>>();
  auto returned = done->get_future();
  std::thread{[call = std::move(call), done]() mutable {
    call();
    call = {};  // what it owned is freed before the caller returns
    done->set_value();
  }}.detach();
  return returned.wait_for(patience) == std::future_status::ready;
}

}  // namespace tactus
