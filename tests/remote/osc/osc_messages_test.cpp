#include "remote/osc/osc_messages.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <string>

#include "tests/remote/osc/osc_bytes.h"

using namespace tactus;
using test::bundle_of;
using test::bytes;

namespace {

constexpr double kNow_s = 1.8e9;

Result<std::vector<OscBundle>> parse(const std::string& packet) { return parse_osc(packet, kNow_s); }

}  // namespace

TEST_CASE("osc: a message is read as the specification has its bytes", "[remote][osc]") {
  const auto packet = bytes("/oscillator/4/frequency\0,f\0\0\x43\xdc\0\0");  // an example of OSC 1.0
  const auto read = parse(packet);
  REQUIRE(read);
  REQUIRE(read->size() == 1);
  REQUIRE(read->front().messages.size() == 1);
  const auto& message = read->front().messages.front();
  CHECK(read->front().time_s == OscBundle::kNow);
  CHECK(message.address == "/oscillator/4/frequency");
  CHECK(message.values == std::vector<OscValue>{440.0});
  const OscMessage same{"/oscillator/4/frequency", {440.0}};
  CHECK(build_osc({&same, 1}) == std::vector{packet});
}

TEST_CASE("osc: numbers of every width, texts and truth values are values", "[remote][osc]") {
  const auto read = parse(
      bytes("/a\0\0,ihfdsSTFN\0\0\0\0\0\7\0\0\0\1\0\0\0\0\x3f\x80\0\0\x3f\xe0\0\0\0\0\0\0ab\0\0cd\0\0"));
  REQUIRE(read);
  CHECK(read->front().messages.front().values == std::vector<OscValue>{std::int64_t{7}, std::int64_t{1} << 32,
                                                                       1.0, 0.5, "ab", "cd", std::int64_t{1},
                                                                       std::int64_t{0}, std::monostate{}});
}

TEST_CASE("osc: a time tag is the time next to now", "[remote][osc]") {
  const std::vector<OscMessage> messages = {{"/a", {1.0}}, {"/b", {std::int64_t{2}}}};
  for (const double time_s : {kNow_s, kNow_s + 0.25, kNow_s - 1e6, 2085978496.5 /* the next era */}) {
    const auto packets = build_osc(messages, time_s);
    REQUIRE(packets.size() == 1);
    const auto read = parse_osc(packets.front(), time_s + 1.0);
    REQUIRE(read);
    CHECK(read->front().time_s == Approx(time_s).margin(1e-6));
    CHECK(read->front().messages.size() == 2);
  }
  CHECK(parse(bundle_of(bytes("\0\0\0\0\0\0\0\1"), {}))->front().time_s == OscBundle::kNow);
}

TEST_CASE("osc: too much of anything is refused", "[remote][osc]") {
  const auto message = bytes("/a\0\0,\0\0\0"), now = bytes("\0\0\0\0\0\0\0\1");
  CHECK(parse(bundle_of(now, std::vector(500, message))));
  CHECK_FALSE(parse(bundle_of(now, std::vector(600, message))));
  auto nested = message;
  for (int depth = 0; depth < 4; ++depth) nested = bundle_of(now, {nested});
  CHECK(parse(nested));
  for (int depth = 0; depth < 3; ++depth) nested = bundle_of(now, {nested});
  CHECK_FALSE(parse(nested));
  CHECK_FALSE(parse("/" + std::string(300, 'a') + bytes("\0\0\0,\0\0\0")));
  CHECK_FALSE(parse(bytes("/a\0\0,") + std::string(17, 'T') + bytes("\0\0")));
  CHECK_FALSE(parse(bytes("/\x01\0\0,\0\0\0")));
}

TEST_CASE("osc: what is no OSC is refused", "[remote][osc]") {
  for (const auto& packet :
       {std::string{}, bytes("/a"), bytes("/a\0\0,f\0\0"), bytes("/a\0\0,f\0\0\0\0\0"), bytes("#bundle\0"),
        bytes("/a\0\0,s\0\0abcd"), bytes("#bundle\0\0\0\0\0\0\0\0\1\0\0\0\x10/a\0\0"),
        bytes("#bundle\0\0\0\0\0\0\0\0\1\xff\xff\xff\xff/a\0\0"), bytes("/a\0\0,b\0\0\x7f\xff\xff\xff"),
        bytes("/a\0\0,b\0\0"), bytes("/a\0\0,ib\0\0\0\0\0\xff\xff\xff\xf0"),
        bytes("#bundle\0\0\0\0\0\0\0\0\1\0\0\0\x0c/a\0\0,b\0\0\x7f\xff\xff\xff")})
    CHECK_FALSE(parse(packet));
}

TEST_CASE("osc: many messages go out in packets of at most 1400 bytes", "[remote][osc]") {
  std::vector<OscMessage> messages(200, {"/control/some_name", {0.5}});
  messages[50] = {"/" + std::string(2000, 'a'), {}};  // it is left out
  std::size_t count = 0;
  for (const auto& packet : build_osc(messages, kNow_s)) {
    CHECK(packet.size() <= 1400);
    count += parse(packet)->front().messages.size();
  }
  CHECK(count == 199);
}

TEST_CASE("osc: address patterns", "[remote][osc]") {
  CHECK(matches_osc("/control/strength", "/control/strength"));
  CHECK(matches_osc("/control/*", "/control/strength"));
  CHECK(matches_osc("/c*l/?trength", "/control/strength"));
  CHECK(matches_osc("/control/{gain,strength}", "/control/strength"));
  CHECK(matches_osc("/voice/[0-3]", "/voice/2"));
  CHECK(matches_osc("/voice/[!0-3]", "/voice/4"));
  CHECK_FALSE(matches_osc("/voice/[!0-3]", "/voice/2"));
  CHECK_FALSE(matches_osc("/*", "/control/strength"));
  CHECK_FALSE(matches_osc("/control", "/control/strength"));
  CHECK_FALSE(matches_osc("/control/[s", "/control/s"));
  CHECK_FALSE(matches_osc("/control/{s", "/control/s"));
  CHECK(covers_osc("/control", "/control/strength"));
  CHECK(covers_osc("/level/*", "/level/in/mic"));
  CHECK(covers_osc("/", "/level/in/mic"));
  CHECK_FALSE(covers_osc("/con", "/control/strength"));
}

TEST_CASE("osc: a pattern of many stars costs bounded work", "[remote][osc]") {
  std::string pattern = "/";
  for (int n = 0; n < 100; ++n) pattern += "*a";
  CHECK_FALSE(matches_osc(pattern + "b", "/" + std::string(250, 'a')));
}
