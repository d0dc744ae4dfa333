#pragma once

#include <atomic>
#include <cstddef>
#include <span>
#include <vector>

#include "engine/core/spsc_queue.h"
#include "remote/remote.h"

namespace tactus {

/// Bundles of orders between a network thread and the control thread. A bundle goes in as a whole or not at
/// all; neither side ever waits.
class OrderQueue {
 public:
  static constexpr std::size_t kOrders = 4096;

  /// [any, the network thread] False: there is no room for all of it.
  [[nodiscard]] bool push(std::span<const RemoteOrder> bundle) {
    if (pushed_ - taken_.load(std::memory_order_acquire) + bundle.size() > orders_.capacity()) return false;
    for (std::size_t i = 0; i < bundle.size(); ++i) {
      auto order = bundle[i];
      order.last = i + 1 == bundle.size();
      (void)orders_.push(order);
    }
    pushed_ += bundle.size();
    return true;
  }
  /// [control, one thread] The next whole bundle; false: there is none.
  [[nodiscard]] bool pop(std::vector<RemoteOrder>& bundle) {
    for (RemoteOrder order; orders_.pop(order);) {
      waiting_.push_back(order);
      taken_.fetch_add(1, std::memory_order_release);
      if (!order.last) continue;
      bundle.clear();
      bundle.swap(waiting_);
      return true;
    }
    return false;
  }

 private:
  SpscQueue<RemoteOrder> orders_{kOrders};
  std::size_t pushed_ = 0;  ///< producer's
  std::atomic<std::size_t> taken_{0};
  std::vector<RemoteOrder> waiting_;  ///< consumer's: of a bundle whose end is to come
};

}  // namespace tactus
