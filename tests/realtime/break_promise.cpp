// Breaks one promise of the audio thread, on purpose: the sanitizer that watches over it must say so.
//   break_promise allocation | lock | node | race | overflow

#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>

#include "engine/graph/node.h"
#include "engine/guard/guarded.h"

namespace {

using namespace tactus;

/// The compiler cannot see through it, or it would leave out a pair of malloc and free.
void* (*volatile allocate)(std::size_t) = std::malloc;
std::mutex mutex;
int shared = 0;
volatile int index_behind = 64;

/// What a careless processor might do; it says nothing itself of the audio thread.
struct Careless final : BlockProcessor {
  explicit Careless(const char* broken) : promise(broken) {}
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    if (std::strcmp(promise, "allocation") == 0) std::free(allocate(8));
    if (std::strcmp(promise, "lock") == 0) const std::lock_guard lock{mutex};
    if (std::strcmp(promise, "race") == 0) ++shared;
    if (std::strcmp(promise, "overflow") == 0) io.out[0][index_behind] = 0;
  }
  const char* promise;
};

struct CarelessNode final : Node {
  void process(const NodeBlock&) noexcept override { std::free(allocate(8)); }
  void reset() noexcept override {}
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  if (std::strcmp(argv[1], "node") == 0) {
    CarelessNode node;
    static_cast<Node&>(node).process({});
    return 0;
  }
  Careless careless{argv[1]};
  Guarded guarded{careless, {}};
  if (!guarded.prepare({48_kHz, 0, 1, 64})) return 2;
  auto* const samples = new double[64]();
  std::thread control{[] { ++shared; }};
  guarded.process({nullptr, &const_cast<double* const&>(samples), 64});
  control.join();
  delete[] samples;
  return 0;
}
