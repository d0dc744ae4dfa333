#pragma once

#include "engine/core/error.h"

namespace tactus {

/// [any] The priority at which the calling thread preempts ordinary ones: 1 to 99 under SCHED_FIFO or
/// SCHED_RR, 0 for an ordinary thread or where the system does not say.
int realtime_priority() noexcept;
/// [any] Makes the calling thread one of priority `priority`, if it is not above already. Errors: Device,
/// with what to do.
Status become_realtime(int priority);
/// [control] Keeps all of the program in memory: all that there is now, and later whatever was used once, so
/// that a stack of 8 MB of which 20 kB are used costs 20 kB. Errors: Device, with what to do.
Status lock_memory();
/// [any] Uses 64 kB of the calling thread's stack, so that no page of it is missing later.
void use_stack() noexcept;

}  // namespace tactus
