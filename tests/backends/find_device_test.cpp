#include "backends/find_device.h"

#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"

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
  return one ? one->id : test::summary(one);
}

std::string refusal(StreamRequest request) {
  request.device = kDevices[1].id;
  request.input_device = kDevices[0].id;
  if (request.in_channels == 0) request.in_channels = 1;
  return test::summary(choose(kDevices, request));
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
  CHECK(found("scarl") == "BadArgument 'scarl' 'jack:scarlett' 'jack:scarlett-2'");
  CHECK(found("fireface") == "UnknownName 'fireface' 'jack:system' 'jack:scarlett' 'jack:scarlett-2'");
  CHECK(test::summary(find_device({}, "x")) == "UnknownName 'x'");
  CHECK(test::summary(find_device({kDevices[0]}, "")) == "UnknownName 'jack:system'");
}

TEST_CASE("find device: by its id it is that one or none", "[backends]") {
  CHECK(device_with_id(kDevices, "jack:system")->id == "jack:system");
  CHECK(device_with_id(kDevices, "")->id == "jack:scarlett");
  CHECK(test::summary(device_with_id(kDevices, "jack:syst")) ==
        "UnknownName 'jack:syst' 'jack:system' 'jack:scarlett' 'jack:scarlett-2'");
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

TEST_CASE("find device: who else writes is hidden by JACK and by ALSA's plugins, not by a card of its own",
          "[backends]") {
  const auto hidden = [](const std::string& api, const std::string& library_name) {
    auto one = device(api + ":one", "one");
    one.api = api;
    one.library_name = library_name;
    StreamRequest request;
    request.device = one.id;
    request.out_channels = 1;
    return choose({one}, request)->granted.writers_unknown;
  };
  CHECK(hidden("jack", "system"));
  CHECK(hidden("pulse", "Built-in"));
  CHECK(hidden("alsa", "default"));
  CHECK(hidden("alsa", "jack"));
  CHECK_FALSE(hidden("alsa", "hw:USB,0"));
  CHECK_FALSE(hidden("alsa", "HDA Intel: Analog (hw:0,0)"));
}

TEST_CASE("find device: channels that are not there are named", "[backends]") {
  StreamRequest request;
  request.in_channels = 3;
  CHECK(refusal(request) == "OutOfRange 'jack:system' 2 3 1 2");
  request = {};
  request.out_channels = 2;
  request.out_map = {1, 4};
  CHECK(refusal(request) == "OutOfRange 'jack:scarlett' 4 5 1 4");
  request.out_map = {1};
  CHECK(refusal(request) == "BadArgument 1 2");
  request.out_map = {0, -1};
  CHECK_FALSE(refusal(request).empty());
  request = {};
  request.out_channels = -1;
  CHECK(refusal(request) == "BadArgument -1");
}

TEST_CASE("find device: two outputs may not add up on one channel, two inputs may hear the same",
          "[backends]") {
  StreamRequest request;
  request.out_channels = 2;
  request.out_map = {1, 1};
  CHECK(refusal(request) == "BadArgument");
  request.out_map = {1, 0};
  request.in_channels = 2;
  request.in_map = {1, 1};
  CHECK(refusal(request).empty());
}

TEST_CASE("find device: rates, blocks and periods that cannot be are refused", "[backends]") {
  StreamRequest request;
  request.sample_rate = 96_kHz;
  CHECK(refusal(request) == "BadArgument 'jack:system' 96000 44100 48000");
  request.sample_rate = 4_kHz;
  CHECK(refusal(request) == "OutOfRange 4000 8 192");
  request = {};
  request.block_frames = 8193;
  CHECK(refusal(request) == "OutOfRange 8193 1 8192");
  request = {};
  request.periods = 0;
  CHECK(refusal(request) == "OutOfRange 0 2 3");
}

namespace {

std::vector<Device> twins(const std::string& first, const std::string& second) {
  std::vector<Device> devices{device("alsa:USB", "USB"), device("alsa:PCH", "PCH"),
                              device("alsa:USB", "USB")};
  devices[0].hardware = first;
  devices[2].hardware = second;
  distinguish_same_ids(devices);
  return devices;
}

std::string found_in(const std::vector<Device>& devices, const std::string& id,
                     const std::string& hardware = {}) {
  const auto one = device_with_id(devices, id, hardware);
  return one ? one->hardware : test::summary(one);
}

}  // namespace

TEST_CASE("find device: two devices of one name are told apart by their hardware, in any order",
          "[backends]") {
  const auto both = twins("1-2:1.0", "1-3:1.0");
  CHECK(both[0].id == "alsa:USB@1-2:1.0");
  CHECK(both[1].id == "alsa:PCH");
  CHECK(both[2].id == "alsa:USB@1-3:1.0");
  CHECK_FALSE(both[0].ambiguous);
  CHECK(found_in(twins("1-3:1.0", "1-2:1.0"), "alsa:USB@1-3:1.0") == "1-3:1.0");
  // The bare name no longer means any of them, unless it is known which one it was.
  CHECK(test::summary(device_with_id(both, "alsa:USB")) ==
        "UnknownName 'alsa:USB' 'alsa:USB@1-2:1.0' 'alsa:PCH' 'alsa:USB@1-3:1.0'");
  CHECK(found_in(both, "alsa:USB", "1-3:1.0") == "1-3:1.0");
}

TEST_CASE("find device: when one of two equal devices is unplugged the other does not take its place",
          "[backends]") {
  std::vector<Device> second{device("alsa:USB", "USB")};
  second[0].hardware = "1-3:1.0";
  distinguish_same_ids(second);
  CHECK(second[0].id == "alsa:USB");
  CHECK(test::summary(device_with_id(second, "alsa:USB@1-2:1.0")) ==
        "UnknownName 'alsa:USB@1-2:1.0' 'alsa:USB'");
  CHECK(found_in(second, "alsa:USB@1-3:1.0") == "1-3:1.0");
}

TEST_CASE("find device: devices of one name and unknown hardware are numbered, and ambiguous", "[backends]") {
  const auto both = twins("", "");
  CHECK(both[0].id == "alsa:USB");
  CHECK(both[2].id == "alsa:USB #2");
  CHECK(both[0].ambiguous);
  CHECK_FALSE(both[1].ambiguous);
  CHECK(both[2].ambiguous);
  CHECK(twins("1-2:1.0", "1-2:1.0")[2].ambiguous);
}

TEST_CASE("find device: what is granted says which hardware it is, for each direction with channels",
          "[backends]") {
  auto devices = twins("1-2:1.0", "1-3:1.0");
  StreamRequest request;
  request.device = "alsa:USB@1-2:1.0";
  request.input_device = "alsa:USB@1-3:1.0";
  request.in_channels = request.out_channels = 1;
  const auto both = choose(devices, request);
  REQUIRE(both);
  CHECK(both->granted.output == DeviceIdentity{"1-2:1.0", 4, {}, false});
  CHECK(both->granted.input == DeviceIdentity{"1-3:1.0", 2, {}, false});
  request.in_channels = 0;
  CHECK(choose(devices, request)->granted.input == DeviceIdentity{});
  request.device = "alsa:USB";
  request.previous = both->granted;
  CHECK(choose(devices, request)->granted.output.hardware == "1-2:1.0");
}

TEST_CASE("find device: a device that kept its hardware is the same under a longer name", "[backends]") {
  StreamGranted before, now;
  before.device = "alsa:USB";
  before.output.hardware = "1-2:1.0";
  now = before;
  now.device = "alsa:USB@1-2:1.0";
  CHECK(differences(before, now).empty());
  before.output.hardware = now.output.hardware = "";
  CHECK(differences(before, now).size() == 1);
}

TEST_CASE("find device: a second device is compared as the first one is", "[backends]") {
  const DeviceIdentity inputs{"usb-2 054c:0ce6:8111", 19, {}, false}, outputs{inputs.hardware, 2, {}, false};
  StreamGranted before;
  before.second = {"sdl:Pad", inputs, outputs, {}, {}};
  auto now = before;
  CHECK(differences(before, now).empty());
  now.second->input.channels = 4;
  CHECK(differences(before, now) ==
        std::vector<std::string>{"it has 4 inputs of the second device instead of 19"});
  now = before;
  now.second->output.hardware = "usb-2 044f:b66e:0100";
  CHECK(differences(before, now) ==
        std::vector<std::string>{"the hardware of the outputs of the second device is 'usb-2 "
                                 "044f:b66e:0100' instead of 'usb-2 054c:0ce6:8111'"});
  now = before;
  now.second->input.hardware = now.second->output.hardware = "";
  CHECK(differences(before, now).front() ==
        "it may be another device of the same name: check its second device");
  CHECK(differences_between_openings(before, now, true).size() == 2);
}

TEST_CASE("find device: between two openings unknown hardware is no difference, a new connection is one",
          "[backends]") {
  StreamGranted before;
  before.device = "jack:card";
  before.output = {"", 2, {"card:playback_1"}, false};
  before.connection = "7";
  auto now = before;
  CHECK_FALSE(differences(before, now).empty());  // it returned: it may be another one
  CHECK(differences_between_openings(before, now, true).empty());
  now.connection = "9";
  CHECK(differences(before, now) == differences(before, before));  // each return is a new connection
  CHECK(differences_between_openings(before, now, true).size() == 1);
  now = before;
  now.output.channels = 4;
  CHECK(differences_between_openings(before, now, false).size() == 1);
  now = before;
  now.block_frames = 128;
  CHECK(differences_between_openings(before, now, false).empty());
  CHECK(differences_between_openings(before, now, true).size() == 1);
}
