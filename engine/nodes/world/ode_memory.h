#pragma once

// Thread: [realtime], except where a function says otherwise
#include <array>
#include <atomic>
#include <csetjmp>
#include <cstddef>
#include <memory>

namespace tactus {

/// Memory of the steps of one world, taken once. Blocks are powers of two; what is freed serves the next
/// block of its size.
class OdeArena {
 public:
  /// [control]
  explicit OdeArena(std::size_t bytes) : bytes_(bytes), memory_(std::make_unique<std::byte[]>(bytes)) {}

  /// nullptr: it is full.
  void* allocate(std::size_t bytes) noexcept;
  void release(void* block, std::size_t bytes) noexcept;
  bool contains(const void* block) const noexcept {
    const auto* at = static_cast<const std::byte*>(block);
    return at >= memory_.get() && at < memory_.get() + bytes_;
  }
  std::size_t used() const noexcept { return used_; }
  /// [control] Its memory is never freed.
  void lose() noexcept { (void)memory_.release(); }

  /// All that the library allocates on this thread comes from the arena, for as long as this lives; what it
  /// frees goes back to where it came from.
  class Use {
   public:
    explicit Use(OdeArena& arena) noexcept;
    ~Use();
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    OdeArena* before_;
  };

 private:
  static int class_of(std::size_t bytes) noexcept;

  std::size_t bytes_, used_ = 0;
  std::unique_ptr<std::byte[]> memory_;
  std::array<void*, 48> free_{};  ///< by class: a list through the first bytes of each block
};

/// Of the generator that all iterative solvers of the process share.
class RandomTurn {
 public:
  explicit RandomTurn(bool needed) noexcept;
  ~RandomTurn() {
    if (needed_) taken_.clear(std::memory_order_release);
  }
  RandomTurn(const RandomTurn&) = delete;
  RandomTurn& operator=(const RandomTurn&) = delete;

 private:
  static inline std::atomic_flag taken_;
  bool needed_;
};

/// [control] Starts the library, once in a process, with memory from arenas and without messages to stderr.
/// False: it cannot be started.
bool start_ode();

/// Of this thread: where an assertion of the library goes on; nullptr: it ends the program.
std::jmp_buf*& ode_assertion_goes_to() noexcept;

/// False: an assertion of the library has left `call` in the middle of whatever it did. The world must not be
/// touched any more, not even to be destroyed, and objects that `call` made are not destroyed.
template <class Call>
bool survives(Call call) noexcept {
  std::jmp_buf here;
  std::jmp_buf* const before = ode_assertion_goes_to();
  ode_assertion_goes_to() = &here;
  const bool failed = setjmp(here) != 0;
  if (!failed) call();
  ode_assertion_goes_to() = before;
  return !failed;
}

}  // namespace tactus
