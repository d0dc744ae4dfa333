#pragma once

#include "engine/core/error.h"

namespace tactus {

/// [any] The priority at which the calling thread preempts ordinary ones: 1 to 99 under SCHED_FIFO or
/// SCHED_RR, 0 for an ordinary thread or where the system does not say.
int realtime_priority() noexcept;
/// [any] Makes the calling thread one of priority `priority`, if it is not above already. Errors: Device,
/// with what to do.
Status become_realtime(int priority);
/// [control] Keeps all of the program in memory, now and later, so that no page is missing when a block
/// comes. Errors: Device, with what to do.
Status lock_memory();

}  // namespace tactus
