#include "remote/panel/panel_server.h"

#include <catch2/catch.hpp>

#include "remote/panel/pages.h"
#include "tests/remote/fake_remote_target.h"
#include "tests/remote/osc/osc_client.h"
#include "tests/remote/panel/browser_client.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace std::chrono_literals;
using test::BrowserClient;
using test::Json;

TEST_CASE("panel server: addresses", "[remote][panel]") {
  CHECK(parse_panel_address("")->port == 0);
  CHECK(parse_panel_address("8080")->address == "127.0.0.1");
  CHECK(parse_panel_address("0.0.0.0:8080")->port == 8080);
  for (const auto* wrong : {"x", "65536", "-1", "127.0.0.1:"}) CHECK_FALSE(parse_panel_address(wrong));
  test::FakeRemoteTarget target;
  const auto first = PanelServer::open({}, target);
  REQUIRE(first);
  const auto second = PanelServer::open({.port = (*first)->port()}, target);
  REQUIRE_FALSE(second);
  CHECK(second.error().code == Errc::Device);
  const auto link = (*first)->link();
  CHECK(link.starts_with("http://127.0.0.1:" + std::to_string((*first)->port()) + "/#"));
  CHECK(test::token_of((*first)->link()).size() == 32);
  CHECK(test::token_of((*PanelServer::open({}, target))->link()) != test::token_of((*first)->link()));
}

TEST_CASE("panel server: its pages name no other place", "[remote][panel]") {
  test::FakeRemoteTarget target;
  const auto server = PanelServer::open({}, target);
  REQUIRE(server);
  const auto get = [&](const std::string& path, const std::string& host = "localhost") {
    return test::http((*server)->port(),
                      "GET " + path + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
  };
  CHECK(get("/").find("HTTP/1.1 200 OK\r\n") == 0);
  CHECK(get("/").find("Content-Security-Policy: default-src 'self';") != std::string::npos);
  for (const auto* page : {"/main.js", "/panel.css", "/uplot.js", "/uplot.css"})
    CHECK(get(page).find("HTTP/1.1 200 OK\r\n") == 0);
  CHECK(get("/../../etc/passwd").find("HTTP/1.1 404") == 0);
  CHECK(get("/main.js?x=1").find("HTTP/1.1 200") == 0);
  // A name of another site that was made to point here.
  for (const auto* host : {"evil.example", "evil.example:80", "127.0.0.1.evil.example", ""})
    CHECK(get("/", host).find("HTTP/1.1 403") == 0);
  CHECK(get("/", "[::1]:80").find("HTTP/1.1 200") == 0);
  CHECK(test::http((*server)->port(),
                   "POST / HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
            .find("HTTP/1.1 405") == 0);
  for (const auto& page : panel_pages())
    if (page.name != "uplot.js") CHECK(std::string{page.bytes}.find("https://") == std::string::npos);
}

TEST_CASE("panel server: a session needs the token, this host and a page of this server", "[remote][panel]") {
  test::FakeRemoteTarget target;
  const auto server = PanelServer::open({}, target);
  REQUIRE(server);
  const auto host = test::address_of((*server)->link()), origin = "http://" + host,
             token = test::token_of((*server)->link());
  for (const auto& [wrong_host, wrong_origin, wrong_token] :
       {std::tuple{host, origin, std::string(32, '0')},
        {host, origin, std::string{}},
        {host, origin, token.substr(1)},
        {host, std::string{"http://evil.example"}, token},
        {host, std::string{}, token},
        {std::string{"evil.example"}, std::string{"http://evil.example"}, token}})
    CHECK_FALSE(BrowserClient{(*server)->port()}.open({wrong_host, wrong_origin, wrong_token}));
  BrowserClient right{(*server)->port()};
  REQUIRE(right.open((*server)->link()));
  CHECK(right.wait_for("description")["name"] == "fake");
  CHECK(right.wait_for("state")["armed"] == false);
  right.send(R"({"do":"mute"})");
  CHECK(test::wait_until([&] { return target.is_muted.load(); }));
  right.send("no json");
  CHECK(right.wait_for("answer")["error"] == "this is no order");
}

TEST_CASE("panel server: a browser that reads nothing holds up nobody", "[remote][panel]") {
  test::FakeRemoteTarget target;
  const auto server = PanelServer::open({}, target);
  REQUIRE(server);
  BrowserClient stalled{(*server)->port()}, half{(*server)->port()};  // `half` never asks for anything
  REQUIRE(stalled.open((*server)->link()));
  BrowserClient reading{(*server)->port()};
  REQUIRE(reading.open((*server)->link()));
  for (int i = 0; i < 200; ++i) stalled.send(R"({"do":"set","name":"none","value":1})");
  for (int i = 0; i < 20; ++i) CHECK(reading.wait_for("state").contains("inputs"));
  reading.send(R"({"do":"disarm"})");
  CHECK(test::wait_until([&] { return target.times_disarmed == 1; }));
  CHECK(test::wait_until([&] { return (*server)->counts().messages == 201; }));
}

TEST_CASE("panel server: drives that a browser armed are disarmed when it is gone", "[remote][panel]") {
  test::FakeRemoteTarget target;
  const auto server = PanelServer::open({}, target);
  REQUIRE(server);
  {
    BrowserClient browser{(*server)->port()};
    REQUIRE(browser.open((*server)->link()));
    browser.send(R"({"do":"arm_request"})");
    const auto answer = browser.wait_for("answer");
    browser.send(Json{{"do", "arm"}, {"number", answer["number"]}}.dump());
    CHECK(test::wait_until([&] { return target.arms == 1; }));
    CHECK(target.times_disarmed == 0);
  }
  CHECK(test::wait_until([&] { return target.times_disarmed == 1; }));
}
