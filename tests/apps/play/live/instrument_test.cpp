#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "apps/play/live/performer.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using namespace tactus::app;

namespace {

std::string graph(const std::string& from, const std::string& kind) {
  return R"(format = 1
name = "test"
[inputs]
x = {}
[nodes]
hiss = { type = "noise", level = 0.25 }
tone = { type = "sine", level = 0.5, frequency = "1 kHz" }
[outputs]
y = { from = ")" +
         from + R"(", kind = ")" + kind + "\" }\n";
}

void run(Guarded& guarded, int frames) {
  std::vector<double> in(static_cast<std::size_t>(frames)), out(in);
  const double* from[] = {in.data()};
  double* to[] = {out.data()};
  guarded.process({from, to, frames});
}

}  // namespace

TEST_CASE("live instrument: without a rig sound needs arming but passes up to -6 dBFS at 1 kHz, and noise",
          "[live]") {
  const test::TemporaryFolder folder;
  const std::string from = GENERATE("hiss", "tone");
  const auto file = folder.write("test.toml", graph(from, "audio"));
  const auto instrument = make_instrument({resolve_target(file.string())});
  REQUIRE(instrument->guards.size() == 1);
  const auto& [kind, limits, feedback, origins] = instrument->guards.front();
  CHECK(kind == DriveGuard::Kind::Drive);
  CHECK(limits.slew_per_second == std::numeric_limits<double>::infinity());
  CHECK(limits.ceiling == conservative_limits().ceiling);
  CHECK(limits.soft_start == conservative_limits().soft_start);
  CHECK(limits.dc.level == conservative_limits().dc.level);
  CHECK(feedback == FeedbackPath{false, false});
  Guarded guarded{instrument->processor(), instrument->guards, true};
  REQUIRE(guarded.prepare({48_kHz, 1, 1, 96'000}));
  guarded.skip_soft_start();
  run(guarded, 96'000);
  CHECK(guarded.counts(0) == GuardCounts{});
}

TEST_CASE("live instrument: a drive without a rig takes 1 kHz at its ceiling", "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("test.toml", graph("tone", "drive"));
  const auto instrument = make_instrument({resolve_target(file.string())});
  Guarded guarded{instrument->processor(), instrument->guards, true};
  REQUIRE(guarded.prepare({48_kHz, 1, 1, 96'000}));
  guarded.skip_soft_start();
  run(guarded, 96'000);
  CHECK(guarded.counts(0) == GuardCounts{});
}

TEST_CASE("live instrument: the slew limit of a drive without a rig lets 1 kHz at full scale pass",
          "[live]") {
  // 2 pi 1000 /s; 1.1 kHz is beyond it.
  CHECK(conservative_limits().slew_per_second >= 2 * kPi * 1000);
  CHECK(conservative_limits().slew_per_second < 2 * kPi * 1100);
}

TEST_CASE("live instrument: an edit that leads an input to an output has it watched for feedback", "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("test.toml", graph("tone", "drive"));
  const auto instrument = make_instrument({resolve_target(file.string())});
  Guarded guarded{instrument->processor(), instrument->guards, true};
  REQUIRE(guarded.prepare({48_kHz, 1, 1, 4096}));
  folder.write("test.toml", graph("0.5 * tone + 0.1 * x", "drive"));
  const auto edit = instrument->read_edit();
  REQUIRE(edit.errors.empty());
  edit.take_over(guarded);
  run(guarded, 1);
  CHECK(guarded.state() == std::vector<JournalEntry>{{0, JournalEntry::Kind::FeedbackPath, 0, 1.0}});
}

TEST_CASE("live instrument: its networks are reported, and timed after it has played", "[live]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("test.toml", R"(format = 1
name = "test"
[networks.drum]
solver = "exact"
skin = { type = "chain", masses = 20, mass = "1 g", stiffness = "1 kN/m" }
ear = { type = "probe", on = "skin.3" }
push = { type = "force", on = "skin.5", force = "x * 1 N" }
[inputs]
x = {}
[outputs]
y = { from = "drum.ear.position / 1 m" }
)");
  const auto instrument = make_instrument({resolve_target(file.string())});
  Guarded guarded{instrument->processor(), instrument->guards, false};
  REQUIRE(guarded.prepare({48_kHz, 1, 1, 64}));
  run(guarded, 64);
  const auto networks = instrument->networks(64);
  REQUIRE(networks.size() == 1);
  CHECK(networks[0].name == "drum");
  CHECK(networks[0].ns_per_frame.value_or(0) > 0);
}
