#pragma once
// Thread: [realtime] unless stated otherwise

#include <atomic>
#include <chrono>
#include <thread>

#include "engine/guard/guarded.h"

namespace tactus::app {

/// Forwards blocks and entries to a tap that can be taken away while blocks flow.
class TapGate final : public BlockTap {
 public:
  /// [control, one thread] From now on to `tap`; nullptr: to none. When it returns, no call of the tap before
  /// is running, and none will follow.
  void set(BlockTap* tap) {
    tap_ = tap;
    while (in_use_) std::this_thread::sleep_for(std::chrono::microseconds{100});
  }

  void applied(const JournalEntry& entry) noexcept TACTUS_NONBLOCKING override {
    use([&](BlockTap& tap) { tap.applied(entry); });
  }
  void observe(const BlockIo& io, std::int64_t first_frame) noexcept TACTUS_NONBLOCKING override {
    use([&](BlockTap& tap) { tap.observe(io, first_frame); });
  }

 private:
  // Sequentially consistent: either `set` sees that the tap is in use, or `use` sees the new one.
  template <class Call>
  void use(Call call) noexcept {
    in_use_ = true;
    if (auto* tap = tap_.load()) call(*tap);
    in_use_ = false;
  }

  std::atomic<BlockTap*> tap_{nullptr};
  std::atomic<bool> in_use_{false};
};

}  // namespace tactus::app
