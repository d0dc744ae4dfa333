#pragma once

#include <cstdint>

namespace tactus::realtime {

/// What a thread asked for while it was watched.
struct Asked {
  std::int64_t heap_calls = 0;    ///< malloc, calloc, realloc, free and their relatives
  std::int64_t system_calls = 0;  ///< at most one for each `watch`: the first one switches the trap off
  long last_system_call = -1;     ///< its number, as in <sys/syscall.h>
};

/// Sets the trap for this thread. Linux on x86-64 from 5.11 on: the kernel then turns every system call of
/// the thread into a signal while a byte in its memory says so, which costs nothing where there are none.
/// False: the kernel has no such trap.
bool set_trap() noexcept;

/// Counts from here to `look_away`, on this thread.
void watch() noexcept;
void look_away() noexcept;

/// Everything this thread was seen to ask for since `set_trap`.
Asked asked() noexcept;

}  // namespace tactus::realtime
