#include "backends/paced/output_watchdog.h"

#include <string>

#if defined(__linux__)
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstring>
#include <new>

namespace tactus {
namespace {

constexpr int kLook_ms = 20;
constexpr int kWatchdogPriority = 90;  // above the loop, which may use its core up

tl::unexpected<Error> no_watchdog(const char* what) {
  return fail(
      Errc::Device, "",
      std::string{"no second process can bring the outputs to zero: "} + what + ": " + std::strerror(errno),
      "raise the limits of processes and files (ulimit -u, ulimit -n)");
}

/// A system call alone. `kept` is sorted.
void close_others(const std::vector<int>& kept) noexcept {
  unsigned first = 0;
  for (const int file : kept) {
    if (static_cast<unsigned>(file) > first) (void)close_range(first, static_cast<unsigned>(file) - 1, 0);
    first = static_cast<unsigned>(file) + 1;
  }
  (void)close_range(first, UINT_MAX, 0);
}

}  // namespace

void OutputWatchdog::guard(const Shared& shared, int socket, void (*to_zero)(void*), void* context) noexcept {
  (void)mlockall(MCL_CURRENT);
  sched_param priority{};
  priority.sched_priority = kWatchdogPriority;
  (void)sched_setscheduler(0, SCHED_FIFO, &priority);
  if (write(socket, "r", 1) != 1) _exit(1);  // ready
  FrameStall stall{kPatience};
  while (true) {
    pollfd ended{socket, POLLIN, 0};
    if (poll(&ended, 1, kLook_ms) > 0) break;
    if (!shared.expected.load()) {
      stall.pause();
      continue;
    }
    if (stall.observe(shared.frames.load(), std::chrono::steady_clock::now().time_since_epoch()))
      to_zero(context);
  }
  to_zero(context);
  _exit(0);
}

Result<std::unique_ptr<OutputWatchdog>> OutputWatchdog::start(void (*to_zero)(void*), void* context,
                                                              std::vector<int> files) {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return no_watchdog("socketpair");
  void* memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  auto* shared = memory == MAP_FAILED ? nullptr : new (memory) Shared;
  files.push_back(ends[0]);
  std::sort(files.begin(), files.end());
  // The child must not run a handler of this program.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const pid_t process = shared == nullptr ? -1 : fork();
  const int why = errno;
  if (process == 0) {
    setsid();  // a signal to the group of this program does not reach it
    close_others(files);
    guard(*shared, ends[0], to_zero, context);
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  close(ends[0]);
  if (process > 0) {
    std::unique_ptr<OutputWatchdog> watchdog{new OutputWatchdog{shared, ends[1], process}};
    char ready = 0;
    ssize_t bytes = 0;
    while ((bytes = read(ends[1], &ready, 1)) < 0 && errno == EINTR) continue;
    if (bytes == 1) return watchdog;
    errno = ECHILD;
    return no_watchdog("it ended at once");
  }
  close(ends[1]);
  if (shared != nullptr) munmap(shared, sizeof(Shared));
  errno = why;
  return no_watchdog(shared == nullptr ? "mmap" : "fork");
}

OutputWatchdog::~OutputWatchdog() {
  close(socket_);
  if (process_ > 0)
    while (waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
  munmap(shared_, sizeof(Shared));
}

bool OutputWatchdog::alive() noexcept {
  if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) != 0) process_ = 0;
  return process_ > 0;
}

}  // namespace tactus
#else
namespace tactus {

Result<std::unique_ptr<OutputWatchdog>> OutputWatchdog::start(void (*)(void*), void*, std::vector<int>) {
  return fail(Errc::Device, "", "not supported on this system", "use Linux");
}
OutputWatchdog::~OutputWatchdog() = default;
bool OutputWatchdog::alive() noexcept { return false; }

}  // namespace tactus
#endif
