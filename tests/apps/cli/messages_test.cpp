#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/desk.h"

// What the program answers to typical mistakes on the command line.

using namespace tactus;

namespace {

constexpr const char* kThree = R"(format = 1
name = "three"
[nodes]
x = { type = "sine", level = 0.3, frequency = "50 Hz" }
[outputs]
a = { from = "x" }
b = { from = "x" }
c = { from = "x" }
)";

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("messages: a mistake on the command line names its remedy", "[apps]") {
  const test::Desk desk;
  desk.folder.write("three.toml", kThree);
  const auto [arguments, remedy] = GENERATE(table<std::string, std::string>(
      {{"play three.toml --delay 20", "20 counts as 20 s; write \"20 ms\""},
       {"plya three.toml", "did you mean 'play'"},
       {"study three.toml", "write tactus study NAME three.toml"},
       {"play three.toml --backend loop --duration 1", "c = { channel = \"none\" }"},
       {"play three.toml --backend loop --outputs 1,2 --duration 1", "c = { channel = \"none\" }"},
       {"play three.toml --duratoin 1", "there is no option '--duratoin'; did you mean '--duration'"}}));
  const auto ran = desk.run(arguments);
  INFO(ran.err);
  CHECK(ran.exit == 2);
  CHECK(has(ran.err, remedy));
}

TEST_CASE("messages: with --json errors of the command line are JSON as well", "[apps]") {
  const test::Desk desk;
  const std::string arguments =
      GENERATE(as<std::string>{}, "play --json", "play x.toml --json --block 0",
               "play x.toml --json --nonsense 1", "plya --json", "study x --json", "list --json --xyz");
  const auto ran = desk.run(arguments);
  CAPTURE(arguments, ran.out);
  CHECK(ran.exit == 2);
  const auto json = nlohmann::json::parse(ran.out, nullptr, false);
  REQUIRE(json.is_object());
  REQUIRE(json["errors"].size() >= 1);
  CHECK_FALSE(json["errors"][0]["what"].get<std::string>().empty());
}

TEST_CASE("messages: a render that writes nothing says so", "[apps]") {
  const test::Desk desk;
  desk.folder.write("three.toml", kThree);
  CHECK(has(desk.run("render three.toml --duration '0.1 s'").err, "--out FILE"));
  CHECK_FALSE(has(desk.run("render three.toml --duration '0.1 s' --out o.wav").err, "--out FILE"));
}
