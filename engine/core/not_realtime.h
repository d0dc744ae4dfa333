#pragma once
// Thread: [any]

#if defined(__has_feature)
#if __has_feature(realtime_sanitizer)
#define TACTUS_REALTIME_SANITIZER
#include <sanitizer/rtsan_interface.h>
#endif
#endif

namespace tactus {

/// For its life the real-time sanitizer reports nothing: in what is no part of playing: a study, or a
/// test's own processor or journal, which may allocate what it keeps, or wait on purpose.
#if defined(TACTUS_REALTIME_SANITIZER)
using NotRealtime = __rtsan::ScopedDisabler;
#else
struct NotRealtime {
  NotRealtime() {}
};
#endif

}  // namespace tactus
