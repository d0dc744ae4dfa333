#pragma once
// Thread: [any], by one producer and one consumer

#include <atomic>
#include <bit>
#include <cstddef>
#include <type_traits>
#include <vector>

namespace tactus {

/// A bounded first-in first-out queue between one producing and one consuming thread. Neither ever waits: a
/// full queue refuses, an empty one returns nothing. Each side owns its counter and keeps a copy of the
/// other's, which it refreshes only when by the copy it is full or empty, so that the two threads seldom
/// touch the same cache line. Counters run freely; a slot is the counter modulo the capacity, a power of two.
/// Source: Lamport, "Proving the correctness of multiprocess programs", IEEE TSE 3(2), 1977.
template <class T>
class SpscQueue {
  static_assert(std::is_trivially_copyable_v<T>, "a slot is overwritten, never destroyed");

 public:
  /// [control & before both threads] Room for at least `least_capacity` items.
  explicit SpscQueue(std::size_t least_capacity) : slots_(std::bit_ceil(least_capacity)) {}

  SpscQueue(const SpscQueue&) = delete;
  SpscQueue& operator=(const SpscQueue&) = delete;

  std::size_t capacity() const noexcept { return slots_.size(); }

  /// [any & producer] False: full, nothing happened.
  [[nodiscard]] bool push(const T& item) noexcept {
    const auto tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == slots_.size()) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == slots_.size()) return false;
    }
    slots_[tail & (slots_.size() - 1)] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// [any & consumer] The oldest item, or nullptr. Valid until it is dropped.
  const T* front() noexcept {
    const auto head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return nullptr;
    }
    return &slots_[head & (slots_.size() - 1)];
  }

  /// [any & consumer] Drops the item that `front` showed.
  void drop_front() noexcept {
    head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  /// [any & consumer] False: empty, `item` is as it was.
  [[nodiscard]] bool pop(T& item) noexcept {
    const T* oldest = front();
    if (oldest == nullptr) return false;
    item = *oldest;
    drop_front();
    return true;
  }

 private:
  static constexpr std::size_t kCacheLine = 128;  // two lines of 64: processors fetch them in pairs

  std::vector<T> slots_;
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;  // producer's
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;  // consumer's
};

}  // namespace tactus
