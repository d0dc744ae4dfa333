#include "backends/find_device.h"

#include <catch2/catch.hpp>

#include "tests/support/messages.h"

using namespace tactus;

namespace {

Device device(const std::string& id, const std::string& name, bool is_default = false) {
  Device made;
  made.id = id;
  made.name = name;
  made.in_channels = 2;
  made.out_channels = 4;
  made.sample_rates = {44100_Hz, 48_kHz};
  made.default_rate = 48_kHz;
  made.is_default = is_default;
  return made;
}

const std::vector<Device> kDevices{device("jack:system", "Built-in"),
                                   device("jack:scarlett", "Scarlett 2i2", true),
                                   device("jack:scarlett-2", "Scarlett 18i20")};

std::string found(const std::string& text) {
  const auto one = find_device(kDevices, text);
  return one ? one->id : to_string(one.error());
}

test::Messages refusal(StreamRequest request) {
  request.device = kDevices[1].id;
  request.input_device = kDevices[0].id;
  if (request.in_channels == 0) request.in_channels = 1;
  const auto choice = choose(kDevices, request);
  return choice ? "" : to_string(choice.error());
}

}  // namespace

TEST_CASE("find device: an id, a part of an id or name in any case, or the default", "[backends]") {
  CHECK(found("jack:system") == "jack:system");
  CHECK(found("jack:scarlett") == "jack:scarlett");  // though it is a part of another
  CHECK(found("BUILT") == "jack:system");
  CHECK(found("18i20") == "jack:scarlett-2");
  CHECK(found("") == "jack:scarlett");
}

TEST_CASE("find device: what may be several, or none, is refused with what there is", "[backends]") {
  CHECK(found("scarl") == "'scarl' matches several devices; write one of 'jack:scarlett', 'jack:scarlett-2'");
  CHECK(found("fireface") ==
        "there is no device 'fireface'; there is 'jack:system', 'jack:scarlett', 'jack:scarlett-2'");
  CHECK(to_string(find_device({}, "x").error()) ==
        "there is no device 'x'; no device was found; check that it is connected and that the sound server "
        "is running");
  CHECK(to_string(find_device({kDevices[0]}, "").error()) ==
        "there is no default device; there is 'jack:system'");
}

TEST_CASE("find device: by its id it is that one or none", "[backends]") {
  CHECK(device_with_id(kDevices, "jack:system")->id == "jack:system");
  CHECK(device_with_id(kDevices, "")->id == "jack:scarlett");
  CHECK(to_string(device_with_id(kDevices, "jack:syst").error()) ==
        "there is no device 'jack:syst'; there is 'jack:system', 'jack:scarlett', 'jack:scarlett-2'");
}

TEST_CASE("find device: a request that a device can give passes", "[backends]") {
  StreamRequest request;
  CHECK(refusal(request) == "");
  request.in_channels = 2;
  request.out_channels = 2;
  request.out_map = {3, 0};
  request.sample_rate = 44100_Hz;
  request.block_frames = 8192;
  request.periods = 2;
  CHECK(refusal(request) == "");
}

TEST_CASE("find device: channels that are not there are named", "[backends]") {
  StreamRequest request;
  request.in_channels = 3;
  CHECK(refusal(request) ==
        "'jack:system' has 2 inputs, but number 3 is requested; choose channels from 1 to 2");
  request = {};
  request.out_channels = 2;
  request.out_map = {1, 4};
  CHECK(refusal(request) ==
        "'jack:scarlett' has 4 outputs, but number 5 is requested; choose channels from 1 to 4");
  request.out_map = {1};
  CHECK(refusal(request) == "1 outputs are mapped, but 2 are requested");
  request.out_map = {0, -1};
  CHECK_FALSE(refusal(request).empty());
  request = {};
  request.out_channels = -1;
  CHECK(refusal(request) == "there cannot be -1 outputs");
}

TEST_CASE("find device: two outputs may not add up on one channel, two inputs may hear the same",
          "[backends]") {
  StreamRequest request;
  request.out_channels = 2;
  request.out_map = {1, 1};
  CHECK(refusal(request).starts_with("two outputs share a channel"));
  request.out_map = {1, 0};
  request.in_channels = 2;
  request.in_map = {1, 1};
  CHECK(refusal(request).empty());
}

TEST_CASE("find device: rates, blocks and periods that cannot be are refused", "[backends]") {
  StreamRequest request;
  request.sample_rate = 96_kHz;
  CHECK(refusal(request) ==
        "'jack:system' does not run at 96000 Hz; it runs at 44100, 48000 Hz; omit the rate, or set the "
        "device "
        "to another");
  request.sample_rate = 4_kHz;
  CHECK(refusal(request) == "4000 Hz is not a sample rate of sound cards; choose 8 kHz to 192 kHz");
  request = {};
  request.block_frames = 8193;
  CHECK(refusal(request) == "a block cannot have 8193 frames; choose 1 to 8192");
  request = {};
  request.periods = 0;
  CHECK(refusal(request) == "a buffer cannot have 0 periods; choose 2 or 3");
}
