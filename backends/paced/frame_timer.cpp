#include "backends/paced/frame_timer.h"

#if defined(__linux__)
#include <pthread.h>
#include <sched.h>
#include <unistd.h>
#endif

#include <cerrno>
#include <cstring>
#include <ctime>
#include <string>
#include <thread>

namespace tactus {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Lets the other thread of the core run, and saves power.
void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#endif
}

}  // namespace

FrameTimer::Time SystemTimer::now() noexcept { return std::chrono::steady_clock::now().time_since_epoch(); }

void SystemTimer::wait_until(Time time) noexcept {
  if (wait_ == Wait::Busy) {
    while (now() < time) relax();
    return;
  }
#if defined(__linux__)
  const timespec at{time.count() / kSecond_ns, time.count() % kSecond_ns};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) continue;
#else
  std::this_thread::sleep_until(std::chrono::steady_clock::time_point{
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(time)});
#endif
}

#if defined(__linux__)
Status stay_on_core(int core) {
  cpu_set_t only;
  CPU_ZERO(&only);
  const bool exists = core >= 0 && core < CPU_SETSIZE;
  if (exists) CPU_SET(static_cast<std::size_t>(core), &only);
  const int wrong = exists ? pthread_setaffinity_np(pthread_self(), sizeof only, &only) : EINVAL;
  if (wrong == 0) return {};
  return fail(Errc::OutOfRange, "",
              "the loop cannot run on core " + std::to_string(core) + ": " + std::strerror(wrong),
              "choose one of 0 to " + std::to_string(sysconf(_SC_NPROCESSORS_ONLN) - 1));
}
#else
Status stay_on_core(int) {
  return fail(Errc::OutOfRange, "", "a core can only be chosen on Linux", "omit it");
}
#endif

Status check_core(int core) {
  Status allowed;
  std::thread{[&] { allowed = stay_on_core(core); }}.join();
  return allowed;
}

}  // namespace tactus
