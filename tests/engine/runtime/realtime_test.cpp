#include <catch2/catch.hpp>
#include <thread>

#include "tests/support/allocation_count.h"
#include "tests/support/graphs/busy_graph.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

using namespace tactus;

namespace {

const std::string kBig = test::kBusyGraph + R"([outputs]
y = { from = "all + tuned" }
z = { from = "back" }
)";

}  // namespace

TEST_CASE("Player: process allocates nothing", "[runtime]") {
  CompileOptions options;
  options.taps = {"hit", "hit.level"};
  const auto engine = test::engine_of(kBig, options);
  REQUIRE(engine->prepare({48_kHz, 2, 2, 1000}));
  const auto x = test::noise(1000, 1);
  test::Samples go(1000), y(1000), z(1000);
  go[77] = 1;
  const double* in[] = {x.data(), go.data()};
  double* out[] = {y.data(), z.data()};
  engine->set_journal(
      {{3, JournalEntry::Kind::ControlChange, 0, 0.1}, {1501, JournalEntry::Kind::ControlChange, 1, 900}});
  const auto before = test::allocation_count();
  bool posted = true;
  for (int block = 0; block < 50; ++block) {
    posted = posted && engine->post({JournalEntry::kNow, JournalEntry::Kind::ControlChange, 0, 0.01 * block});
    engine->process({in, out, 1000});
  }
  CHECK(test::allocation_count() == before);
  CHECK(posted);
  CHECK(engine->faults().empty());
}

TEST_CASE("Player: entries posted from another thread hold from their frame, none is lost", "[runtime]") {
  const auto engine = test::engine_of(R"(format = 1
name = "test"
[controls]
c = { value = 0, range = [0, 1e6], smooth = "0 ms" }
[outputs]
c = { from = "c" }
)");
  REQUIRE(engine->prepare({48_kHz, 0, 1, 64}));
  constexpr int kEntries = 5000;
  // Entry k says k at frame 10 k; the queue holds 256, so that both threads run into its ends.
  std::thread poster{[&] {
    for (int k = 1; k <= kEntries; ++k)
      while (!engine->post({10 * k, JournalEntry::Kind::ControlChange, 0, static_cast<double>(k)}))
        std::this_thread::yield();
  }};
  double last = 0;
  bool ordered = true, early = false;
  test::Samples y(64);
  double* out[] = {y.data()};
  while (last < kEntries) {
    const auto first = engine->frame();
    engine->process({nullptr, out, 64});
    for (int n = 0; n < 64; ++n) {
      const double now = y[static_cast<std::size_t>(n)];
      ordered = ordered && now >= last;
      early = early || now * 10 > static_cast<double>(first + n);
      last = now;
    }
  }
  poster.join();
  CHECK(ordered);
  CHECK_FALSE(early);
}
