#include "backends/library_calls.h"

#if defined(TACTUS_HAS_ALSA)
#include <alsa/asoundlib.h>
#endif
#if defined(TACTUS_HAS_JACK)
#include <jack/jack.h>
#endif

#include <future>
#include <thread>

namespace tactus {

static std::function<void(const std::string&)>& slow_calls() {
  static auto& report = *new std::function<void(const std::string&)>;
  return report;
}

void on_slow_call(std::function<void(const std::string&)> report) { slow_calls() = std::move(report); }

std::chrono::milliseconds& listing_patience() {
  static std::chrono::milliseconds patience{30000};
  return patience;
}

bool call_with_timeout(std::function<void()> call, std::chrono::milliseconds patience,
                       const std::string& slow) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  auto done = std::make_shared<std::promise<void>>();
  auto returned = done->get_future();
  std::thread{[call = std::move(call), done]() mutable {
    call();
    call = {};  // what it owned is freed before the caller returns
    done->set_value();
  }}.detach();
  const auto in_time = [&](auto until) { return returned.wait_until(until) == std::future_status::ready; };
  if (!slow.empty() && slow_calls() && patience > kPatience) {
    if (in_time(deadline - patience + kPatience)) return true;
    slow_calls()(slow);
  }
  return in_time(deadline);
}

std::optional<std::chrono::milliseconds> silence_until_lost(const std::string& api) {
  using namespace std::chrono_literals;
  if (api == "jack") return std::nullopt;
  if (api == "alsa" || api == "pulse" || api == "oss") return 1s;
  return 5s;
}

#if defined(TACTUS_HAS_ALSA)
static void ignore_alsa(const char*, int, const char*, int, const char*, ...) {}
#endif

void silence_library_logs() {
#if defined(TACTUS_HAS_ALSA)
  snd_lib_error_set_handler(ignore_alsa);
#endif
#if defined(TACTUS_HAS_JACK)
  jack_set_error_function([](const char*) {});
  jack_set_info_function([](const char*) {});
#endif
}

}  // namespace tactus
