#include "remote/hid/hid_map.h"

#include <catch2/catch.hpp>

#include "tests/remote/fake_remote_target.h"

using namespace tactus;

namespace {

RigHid source(const std::string& device, HidPart part, int number, bool invert = false) {
  return {"", {}, device, part, number, invert};
}

struct Stage {
  /// Of strength, hold and level.
  explicit Stage(const std::vector<RigHid>& sources) {
    target.hid = sources;
    target.describe({{"strength", ""}, {"hold", "ms"}, {"level", "dB"}});
  }
  std::vector<RemoteOrder> move(const std::string& device, HidPart part, int number, double position) {
    return map.handle({device, part, number, position}, target);
  }

  test::FakeRemoteTarget target;
  HidMap map;
};

}  // namespace

TEST_CASE("hid map: an axis moves its control over its range, along its taper", "[remote]") {
  Stage stage{{source("Pedal", HidPart::Axis, 1), source("", HidPart::Axis, 0, /*invert=*/true),
               source("Stick", HidPart::Axis, 2)}};
  auto orders = stage.move("My Pedal", HidPart::Axis, 1, 0.25);
  REQUIRE(orders.size() == 1);
  CHECK(orders[0].number == 10);
  CHECK(orders[0].value == 0.25);
  orders = stage.move("anything", HidPart::Axis, 0, 0.25);
  REQUIRE(orders.size() == 1);
  CHECK(orders[0].value == Approx(0.002 + 0.75 * 0.098));
  orders = stage.move("Stick", HidPart::Axis, 2, 0.5);
  REQUIRE(orders.size() == 1);
  CHECK(orders[0].value == Approx(0.0316227766));  // -30 dB of -60 to 0 dB
  CHECK(stage.move("Stick", HidPart::Axis, 1, 0.5).empty());
  CHECK(stage.move("My Pedal", HidPart::Button, 1, 1.0).empty());
}

TEST_CASE("hid map: a button is the highest value while it is pressed", "[remote]") {
  Stage stage{{source("", HidPart::Button, 3)}};
  CHECK(stage.move("Pad", HidPart::Button, 3, 1.0).at(0).value == 1.0);
  CHECK(stage.move("Pad", HidPart::Button, 3, 0.0).at(0).value == 0.0);
}

TEST_CASE("hid map: an axis that moves a control can be learnt for another one", "[remote]") {
  Stage stage{{source("Pad", HidPart::Axis, 2)}};
  CHECK(stage.move("Pad", HidPart::Axis, 2, 0.5).size() == 1);
  stage.target.learning = true;
  CHECK(stage.move("Pad", HidPart::Axis, 2, 0.6).size() == 1);
  CHECK(stage.move("Pad", HidPart::Axis, 2, 0.8).empty());
  CHECK(stage.target.learnt_hid);
}

TEST_CASE("hid map: what moves far enough is learnt", "[remote]") {
  Stage stage{{}};
  stage.target.learning = true;
  for (const double position : {0.50, 0.51, 0.49, 0.70})
    CHECK(stage.move("Pad", HidPart::Axis, 2, position).empty());
  CHECK_FALSE(stage.target.learnt_hid);
  (void)stage.move("Pad", HidPart::Axis, 2, 0.76);
  REQUIRE(stage.target.learnt_hid);
  CHECK(stage.target.learnt_hid->device == "Pad");
  CHECK(stage.target.learnt_hid->part == HidPart::Axis);
  CHECK(stage.target.learnt_hid->number == 2);
  stage.target.learnt_hid.reset();
  (void)stage.move("Pad", HidPart::Button, 1, 0.0);
  CHECK_FALSE(stage.target.learnt_hid);
  (void)stage.move("Pad", HidPart::Button, 1, 1.0);
  CHECK(stage.target.learnt_hid);
}
