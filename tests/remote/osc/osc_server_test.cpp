#include "remote/osc/osc_server.h"

#include <catch2/catch.hpp>
#include <mutex>

#include "tests/remote/fake_remote_target.h"
#include "tests/remote/osc/osc_client.h"

using namespace tactus;

TEST_CASE("osc server: addresses", "[remote][osc]") {
  CHECK(parse_osc_address("9000")->address == "127.0.0.1");
  CHECK(parse_osc_address("9000")->port == 9000);
  CHECK(parse_osc_address("0.0.0.0:9000")->address == "0.0.0.0");
  CHECK(parse_osc_address("localhost:1")->address == "127.0.0.1");
  CHECK(parse_osc_address("[::1]:9000")->address == "::1");
  for (const auto* wrong : {"", "x", "9000x", "65536", "-1", "127.0.0.1:", "127.0.0.1"}) {
    CAPTURE(wrong);
    REQUIRE_FALSE(parse_osc_address(wrong));
    CHECK(parse_osc_address(wrong).error().where == "--osc");
  }
}

TEST_CASE("osc server: packets and requests are answered at one port", "[remote][osc]") {
  test::FakeRemoteTarget target;
  const auto server = OscServer::open({}, target);
  REQUIRE(server);
  const int port = (*server)->port();
  CHECK((*server)->announcement() == "OSC       udp 127.0.0.1:" + std::to_string(port) +
                                         ", description http://127.0.0.1:" + std::to_string(port) + "/");
  test::OscClient client{port};
  client.send_bytes("nonsense");
  CHECK(client.wait_for("/error"));
  client.send({"/list"});
  CHECK(client.wait_for("/list/end"));
  client.send({"/subscribe", {std::string{"/level"}, 100.0}});
  CHECK(client.wait_for("/level/in/mic")->values == std::vector<OscValue>{0.5});
  const auto answer = test::http(port, "GET /control/hold?VALUE HTTP/1.1\r\n\r\n");
  CHECK(answer.find("HTTP/1.1 200 OK\r\n") == 0);
  CHECK(answer.find("100.0") != std::string::npos);
  CHECK(test::http(port, "GET " + std::string(20'000, 'x')).empty());  // refused, or closed
  CHECK(test::http(port, "GET / HTTP/1.1\r\n\r\n").size() > 1000);
  CHECK(test::wait_until([&] { return (*server)->counts().refused_packets == 1; }));
}

TEST_CASE("osc server: a port that is in use is an error", "[remote][osc]") {
  test::FakeRemoteTarget target;
  const auto first = OscServer::open({}, target);
  REQUIRE(first);
  const auto second = OscServer::open({.port = (*first)->port()}, target);
  REQUIRE_FALSE(second);
  CHECK(second.error().code == Errc::Device);
  CHECK(second.error().where == "--osc");
  CHECK_FALSE(OscServer::open({.address = "300.1.1.1"}, target));
}

TEST_CASE("osc server: a receiver that is gone, and idle connections, hold up nothing", "[remote][osc]") {
  test::FakeRemoteTarget target;
  const auto server = OscServer::open({}, target);
  REQUIRE(server);
  const int port = (*server)->port();
  for (int n = 0; n < 8; ++n) {
    const test::OscClient gone{port};
    gone.send({"/subscribe", {std::string{"/"}, 100.0}});
  }
  std::vector<int> idle;
  for (int n = 0; n < 20; ++n) {
    idle.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    const auto to = test::loopback(port);
    REQUIRE(::connect(idle.back(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0);
  }
  test::OscClient client{port};
  client.send({"/subscribe", {std::string{"/load"}, 100.0}});
  for (int n = 0; n < 20; ++n) CHECK(client.wait_for("/load"));
  for (const int socket : idle) ::close(socket);
  CHECK(test::wait_until([&] { return test::http(port, "GET / HTTP/1.1\r\n\r\n").size() > 1000; }));
}
