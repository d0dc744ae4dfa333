#include "tests/realtime/watch.h"

#include <linux/prctl.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstring>

// glibc's own names for what this program replaces.
extern "C" {
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);
void __libc_free(void* memory);
}

namespace tactus::realtime {
namespace {

thread_local bool watching = false;
thread_local Asked seen;
thread_local volatile char trap = SYSCALL_DISPATCH_FILTER_ALLOW;

void count_heap_call() noexcept {
  if (watching) ++seen.heap_calls;
}

/// Counts the call, and makes it after all, so that what follows does not stumble over its answer. The
/// signal's own return is a system call too: hence the trap stays off until the next `watch`.
void on_system_call(int, siginfo_t* info, void* context) {
  trap = SYSCALL_DISPATCH_FILTER_ALLOW;
  ++seen.system_calls;
  seen.last_system_call = info->si_syscall;
  auto& registers = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
  const long answer = syscall(info->si_syscall, registers[REG_RDI], registers[REG_RSI], registers[REG_RDX],
                              registers[REG_R10], registers[REG_R8], registers[REG_R9]);
  registers[REG_RAX] = answer == -1 ? -errno : answer;
}

}  // namespace

bool set_trap() noexcept {
  struct sigaction action;
  std::memset(&action, 0, sizeof action);
  action.sa_sigaction = on_system_call;
  action.sa_flags = SA_SIGINFO;
  seen = {};
  return sigaction(SIGSYS, &action, nullptr) == 0 &&
         prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_ON, 0L, 0L, &trap) == 0;
}

void watch() noexcept {
  watching = true;
  trap = SYSCALL_DISPATCH_FILTER_BLOCK;
}

void look_away() noexcept {
  trap = SYSCALL_DISPATCH_FILTER_ALLOW;
  watching = false;
}

Asked asked() noexcept { return seen; }

}  // namespace tactus::realtime

// Every allocation of the program, of its libraries and of `new` comes through here.
extern "C" {

void* malloc(std::size_t bytes) noexcept {
  tactus::realtime::count_heap_call();
  return __libc_malloc(bytes);
}

void* calloc(std::size_t count, std::size_t bytes) noexcept {
  tactus::realtime::count_heap_call();
  return __libc_calloc(count, bytes);
}

void* realloc(void* memory, std::size_t bytes) noexcept {
  tactus::realtime::count_heap_call();
  return __libc_realloc(memory, bytes);
}

void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  tactus::realtime::count_heap_call();
  return __libc_memalign(alignment, bytes);
}

void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept { return memalign(alignment, bytes); }

int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  *memory = memalign(alignment, bytes);
  return *memory == nullptr ? ENOMEM : 0;
}

void free(void* memory) noexcept {
  tactus::realtime::count_heap_call();
  __libc_free(memory);
}

}  // extern "C"
