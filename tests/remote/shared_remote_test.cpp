#include "remote/shared_remote.h"

#include <catch2/catch.hpp>

#include "tests/remote/fake_remote_target.h"

using namespace tactus;

namespace {

/// Its levels are given in turn.
class Levels final : public test::FakeRemoteTarget {
 public:
  RemoteMeters take_meters() override {
    ++taken;
    return {{level}, {level / 2}, {frames}, 0.125};
  }
  double level = 0.0, frames = 0.0;
  int taken = 0;
};

}  // namespace

TEST_CASE("shared remote: every server has every event", "[remote]") {
  test::FakeRemoteTarget target;
  SharedRemote shared{target};
  const auto one = shared.share(), other = shared.share();
  target.events = {{.kind = RemoteEvent::Kind::Armed, .value = 1, .frame = 10}};
  RemoteEvent event;
  REQUIRE(one->take_event(event));
  CHECK(event.frame == 10);
  CHECK_FALSE(one->take_event(event));
  target.events = {{.kind = RemoteEvent::Kind::Muted, .value = 1, .frame = 20}};
  REQUIRE(other->take_event(event));
  CHECK(event.frame == 10);
  REQUIRE(other->take_event(event));
  CHECK(event.frame == 20);
  CHECK_FALSE(other->take_event(event));
}

TEST_CASE("shared remote: every server has the highest levels since it asked last", "[remote]") {
  Levels target;
  SharedRemote shared{target};
  const auto one = shared.share(), other = shared.share();
  target.level = 0.5;
  target.frames = 7;
  CHECK(one->take_meters().inputs == std::vector{0.5});
  target.level = 0.25;
  target.frames = 9;
  CHECK(one->take_meters().inputs == std::vector{0.25});
  const auto meters = other->take_meters();
  CHECK(meters.inputs == std::vector{0.5});
  CHECK(meters.outputs == std::vector{0.25});
  CHECK(meters.guard == std::vector{9.0});  // no level: as it is now
  target.level = 0.0;
  CHECK(other->take_meters().inputs == std::vector{0.0});
}

TEST_CASE("shared remote: events that a server does not take are bounded, and orders reach the target",
          "[remote]") {
  test::FakeRemoteTarget target;
  SharedRemote shared{target};
  const auto one = shared.share(), idle = shared.share();
  RemoteEvent event;
  for (int i = 0; i < 3000; ++i) {
    target.events = {{.frame = i}};
    REQUIRE(one->take_event(event));
  }
  REQUIRE(idle->take_event(event));
  CHECK(event.frame == 3000 - 1024);
  const RemoteOrder order{.kind = RemoteOrder::Kind::Trigger, .number = 10, .received = {}};
  CHECK(idle->post({&order, 1}));
  CHECK(target.bundles.size() == 1);
  CHECK(one->order_arm() == test::FakeRemoteTarget::kArming);
  one->keep_alive(test::FakeRemoteTarget::kArming);
  CHECK(target.alives == 1);
  idle->mute(true);
  CHECK(one->muted());
  one->disarm();
  CHECK(target.times_disarmed == 1);
}
