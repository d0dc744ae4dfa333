#include "engine/nodes/world/ode_memory.h"

#include <ode/ode.h>

#include <bit>
#include <cstdlib>
#include <cstring>

namespace tactus {
namespace {

// In the initial-exec model an access never allocates, in a shared library either.
thread_local OdeArena* arena_in_use __attribute__((tls_model("initial-exec"))) = nullptr;

void* allocate_ode(dsizeint bytes) {
  return arena_in_use != nullptr ? arena_in_use->allocate(bytes) : std::malloc(bytes);
}
void release_ode(void* block, dsizeint bytes) {
  if (arena_in_use != nullptr && arena_in_use->contains(block))
    arena_in_use->release(block, bytes);
  else
    std::free(block);
}
void* reallocate_ode(void* block, dsizeint before, dsizeint bytes) {
  void* next = allocate_ode(bytes);
  if (next == nullptr) return nullptr;
  if (block != nullptr) std::memcpy(next, block, before < bytes ? before : bytes);
  release_ode(block, before);
  return next;
}
void no_message(int, const char*, va_list) {}

thread_local std::jmp_buf* goes_to __attribute__((tls_model("initial-exec"))) = nullptr;

void leave_call(int, const char*, va_list) {
  if (goes_to != nullptr) std::longjmp(*goes_to, 1);
}

}  // namespace

int OdeArena::class_of(std::size_t bytes) noexcept {
  return static_cast<int>(std::bit_width((bytes < 64 ? 64 : bytes) - 1));
}

void* OdeArena::allocate(std::size_t bytes) noexcept {
  const int size_class = class_of(bytes);
  auto& first = free_[static_cast<std::size_t>(size_class)];
  if (first != nullptr) {
    void* const block = first;
    std::memcpy(&first, block, sizeof(first));
    return block;
  }
  const auto size = std::size_t{1} << size_class;
  if (size > bytes_ - used_) return nullptr;
  void* const block = memory_.get() + used_;
  used_ += size;
  return block;
}

void OdeArena::release(void* block, std::size_t bytes) noexcept {
  if (block == nullptr) return;
  auto& first = free_[static_cast<std::size_t>(class_of(bytes))];
  std::memcpy(block, &first, sizeof(first));
  first = block;
}

OdeArena::Use::Use(OdeArena& arena) noexcept : before_(arena_in_use) { arena_in_use = &arena; }
OdeArena::Use::~Use() { arena_in_use = before_; }

RandomTurn::RandomTurn(bool needed) noexcept : needed_(needed) {
  while (needed_ && taken_.test_and_set(std::memory_order_acquire)) {
  }
  if (needed_) dRandSetSeed(0);
}

std::jmp_buf*& ode_assertion_goes_to() noexcept { return goes_to; }

bool start_ode() {
  static const bool started = [] {
    dSetAllocHandler(allocate_ode);
    dSetReallocHandler(reallocate_ode);
    dSetFreeHandler(release_ode);
    dSetMessageHandler(no_message);
    dSetErrorHandler(leave_call);
    dSetDebugHandler(leave_call);
    return dInitODE2(0) != 0;
  }();
  return started && dCheckConfiguration("ODE_double_precision") != 0;
}

}  // namespace tactus
