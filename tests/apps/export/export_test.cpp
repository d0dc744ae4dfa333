#include <catch2/catch.hpp>

#include "tests/support/desk.h"
#include "tests/support/skip.h"

using namespace tactus::test;

namespace {

const std::string kWire =
    "format = 1\nname = \"a wire\"\n[inputs]\nx = {}\n[outputs]\ny = { from = \"x\" }\n";
const std::string kWall = TACTUS_SOURCE_DIR "/instruments/wall";

}  // namespace

TEST_CASE("tactus export: the files of the folder compile and run as its README says", "[apps][export]") {
  if (std::system(TACTUS_C_COMPILER " --version > /dev/null 2>&1") != 0) skip("there is no C compiler");
  const Desk desk;
  desk.folder.write("wire.toml", kWire);
  check_exit(desk.run("export wire.toml --no-guard"), 0,
             "a_wire_export/a_wire.h a_wire.c example.c README.md");
  const auto folder = desk.file("a_wire_export").string();
  const auto compile =
      "cd " + folder +
      " && " TACTUS_C_COMPILER
      " -std=c99 -O2 -ffp-contract=off a_wire.c example.c -lm -o example && ./example < ../x > ../y";
  desk.folder.write("x", std::string("\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\xe0\xbf", 16));  // 1, -0.5
  REQUIRE(std::system(compile.c_str()) == 0);
  CHECK(text_of(desk.file("y")) == text_of(desk.file("x")));
  CHECK(text_of(desk.file("a_wire_export/README.md")).find("Never connect an actuator") != std::string::npos);
}

TEST_CASE("tactus export: limits are the built-in ones of an unknown drive, or of the rig",
          "[apps][export]") {
  const Desk desk;
  desk.folder.write("rig.toml",
                    "format = 1\n[device]\noutput = \"loop:1\"\n[inputs]\nencoder = { channel = 1, "
                    "volts_per_full_scale = \"1 V\", "
                    "sensitivity = \"1 V/m\" }\n[outputs]\nmotor = { channel = 1, ceiling = 0.25 }\nsound = "
                    "{ channel = 2 }\n");
  check_exit(desk.run("export " + kWall + " -o out"), 0, "out/wall.h");
  CHECK(text_of(desk.file("out/wall.h")).find("motor: ceiling 0.5, slew 6300 per second") !=
        std::string::npos);
  CHECK(text_of(desk.file("out/wall.h")).find("sound: ceiling 0.5, soft start 0.5 s") != std::string::npos);
  check_exit(desk.run("export " + kWall + " -o out --rig rig.toml"), 0, "out/wall.h");
  CHECK(text_of(desk.file("out/wall.h")).find("(rig rig.toml)") != std::string::npos);
  CHECK(text_of(desk.file("out/wall.h")).find("motor: ceiling 0.25, slew 6300 per second") !=
        std::string::npos);
  CHECK(text_of(desk.file("out/wall.h")).find("sound: ceiling 1, soft start") != std::string::npos);
}

TEST_CASE("tactus export: what it cannot do is an error with its place", "[apps][export]") {
  const Desk desk;
  check_exit(desk.run("export " + kWall + "/scene.toml"), 2, "scene instrument");
  desk.folder.write(
      "net.toml",
      "format = 1\n[networks.n]\nsolver = \"reference\"\nm = { type = \"mass\", mass = \"1 g\" }\n"
      "[outputs]\ny = { from = \"n.m.position / 1 m\" }\n");
  check_exit(desk.run("export net.toml"), 3,
             "net.toml network cannot be exported reference solver = \"auto\"");
  check_exit(desk.run("export " + kWall + " --ram 100"), 3, "bytes allowed");
  check_exit(desk.run("export nothing"), 3, "nothing");
  CHECK(desk.run("export " + kWall + " --number decimal").exit == 2);
}
