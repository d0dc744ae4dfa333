#include "apps/play/live/tap_gate.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

using namespace tactus;
using app::TapGate;

namespace {

struct CountingTap final : BlockTap {
  void applied(const JournalEntry&) noexcept override { ++calls; }
  void observe(const BlockIo&, std::int64_t) noexcept override { ++calls; }
  std::atomic<int> calls{0};
};

}  // namespace

TEST_CASE("tap gate: a tap that was taken away is called no more, while blocks flow", "[live]") {
  TapGate gate;
  std::atomic<bool> done{false};
  std::thread audio{[&] {
    while (!done) {
      gate.applied({});
      gate.observe({}, 0);
    }
  }};
  for (int turn = 0; turn < 200; ++turn) {
    CountingTap tap;
    gate.set(&tap);
    while (tap.calls < 3) std::this_thread::yield();
    gate.set(nullptr);
    const int calls = tap.calls;
    std::this_thread::yield();
    if (tap.calls != calls) FAIL("called after it was taken away");
  }
  done = true;
  audio.join();
}
