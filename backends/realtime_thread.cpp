#include "backends/realtime_thread.h"

#include <cstddef>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>
#include <string>

namespace tactus {

int realtime_priority() noexcept {
  int policy = SCHED_OTHER;
  sched_param parameters{};
  if (pthread_getschedparam(pthread_self(), &policy, &parameters) != 0) return 0;
  return policy == SCHED_OTHER ? 0 : parameters.sched_priority;
}

Status become_realtime(int priority) {
  if (realtime_priority() >= priority) return {};
  sched_param parameters{};
  parameters.sched_priority = priority;
  if (const int wrong = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters); wrong != 0)
    return fail(Errc::Device, "",
                std::string{"the audio thread has no real-time priority: "} + std::strerror(wrong),
                "see tactus doctor");
  return {};
}

Status lock_memory() {
#if defined(MCL_ONFAULT)
  if (mlockall(MCL_CURRENT) == 0 && mlockall(MCL_FUTURE | MCL_ONFAULT) == 0) return {};
#endif
  if (mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return fail(Errc::Device, "", std::string{"the memory is not locked: "} + std::strerror(errno),
              "see tactus doctor");
}

}  // namespace tactus
#else
namespace tactus {

int realtime_priority() noexcept { return 0; }
Status become_realtime(int) { return fail(Errc::Device, "", "not supported on this system"); }
Status lock_memory() { return fail(Errc::Device, "", "not supported on this system"); }

}  // namespace tactus
#endif

namespace tactus {

void use_stack() noexcept {
  volatile char bytes[1 << 16];
  for (std::size_t at = 0; at < sizeof bytes; at += 1024) bytes[at] = 0;
}

}  // namespace tactus
