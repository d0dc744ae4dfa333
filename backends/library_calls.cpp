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
