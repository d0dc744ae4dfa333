#include <catch2/catch.hpp>
#include <cmath>

#include "apps/play/live/performer.h"
#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"

using namespace tactus;
using namespace tactus::app;

namespace {

std::unique_ptr<Performer> single_strike() {
  const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  return make_world({resolve_target((root / "haptic_drum/single_strike.toml").string())});
}

/// The highest sample that the speakers get in so many seconds.
double loudest(Guarded& guarded, double seconds, int block = 256) {
  std::vector<double> left(static_cast<std::size_t>(block)), right(left);
  double* out[] = {left.data(), right.data()};
  double highest = 0;
  for (int done = 0; done < seconds * 48000; done += block) {
    guarded.process({nullptr, out, block});
    CHECK(left == right);  // one sound comes from every speaker
    for (const double sample : left) highest = std::max(highest, std::abs(sample));
  }
  return highest;
}

}  // namespace

TEST_CASE("live world: a strike by hand lifts the stick, and it falls on the drum", "[live]") {
  const auto world = single_strike();
  CHECK(world->inputs.empty());
  CHECK(world->outputs == std::vector<std::string>{"sound", "sound"});
  Guarded guarded{world->processor(), world->guards, false};
  REQUIRE(guarded.prepare({48_kHz, 0, 2, 256}));
  loudest(guarded, 2.0);  // the first fall, until it lies
  const double noise = loudest(guarded, 0.5);
  REQUIRE(world->strike());
  const double struck = loudest(guarded, 0.5);
  // The throw gives the stick 2 N for a decay of 20 ms: the impact is as that of a fall from centimetres.
  CHECK(struck > 20 * noise);
  loudest(guarded, 2.0);
  CHECK(loudest(guarded, 0.5) < 2 * noise);
}

TEST_CASE("live world: a rise of the strike is detected however long blocks are", "[live]") {
  for (const int block : {16, 256, 4096}) {
    CAPTURE(block);
    const auto world = single_strike();
    Guarded guarded{world->processor(), world->guards, false};
    REQUIRE(guarded.prepare({48_kHz, 0, 2, block}));
    loudest(guarded, 2.0, block);
    const double noise = loudest(guarded, 0.5, block);
    REQUIRE(world->strike());
    CHECK(loudest(guarded, 0.5, block) > 20 * noise);
  }
}

TEST_CASE("live world: after a reconnection a strike does not wait for one from before", "[live]") {
  const auto world = single_strike();
  Guarded guarded{world->processor(), world->guards, false};
  const StreamFormat format{48_kHz, 0, 2, 256};
  REQUIRE(guarded.prepare(format));
  loudest(guarded, 20.0);
  REQUIRE(world->strike());  // its end lies 20 s after the start, and the device goes away
  REQUIRE(guarded.prepare(format));
  loudest(guarded, 2.0);
  const double noise = loudest(guarded, 0.5);
  REQUIRE(world->strike());
  CHECK(loudest(guarded, 0.5) > 20 * noise);
  loudest(guarded, 2.0);
  CHECK(loudest(guarded, 0.5) < 2 * noise);
}

TEST_CASE("live world: the watch at a port finds the same energy as when the scene is rendered", "[live]") {
  const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
  const auto file = root / "exploding/scene.toml";
  const auto world = make_world({resolve_target(file.string())});
  Guarded guarded{world->processor(), world->guards, false};
  REQUIRE(guarded.prepare({48_kHz, 0, 2, 256}));
  loudest(guarded, 0.64);  // 120 blocks

  auto scene = load_scene_leniently(file, root);
  auto built = build_scene(scene, standard_nodes());
  REQUIRE(built);
  scene.scene->duration = Seconds{0.64};
  const auto rendered = play_scene(*scene.scene, *built, 256);
  REQUIRE(rendered);
  const auto live = world->ports();
  REQUIRE(live.size() == 1);
  REQUIRE(rendered->ports.size() == 1);
  CHECK(live[0].active_at_s.has_value());
  CHECK(live[0].given == rendered->ports[0].given);
  CHECK(live[0].active_at_s == rendered->ports[0].active_at_s);
}

TEST_CASE("live world: its networks are reported, and timed after it has played", "[live]") {
  const auto world = single_strike();
  Guarded guarded{world->processor(), world->guards, false};
  REQUIRE(guarded.prepare({48_kHz, 0, 2, 256}));
  loudest(guarded, 0.1);
  const auto networks = world->networks(64);
  REQUIRE_FALSE(networks.empty());
  for (const auto& network : networks) CHECK(network.ns_per_frame.value_or(0) > 0);
}
