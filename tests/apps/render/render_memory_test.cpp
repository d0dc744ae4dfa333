#include <catch2/catch.hpp>
#include <string_view>

#include "backends/wav_file.h"
#include "tests/support/desk.h"
#include "tests/support/skip.h"

using namespace tactus;

TEST_CASE("render: the memory of an instrument does not grow with the duration", "[apps]") {
  if (!std::string_view{TACTUS_SANITIZE}.empty())
    test::skip("sanitizers reserve more address space than this test allows");
  const test::Desk desk;
  std::string outputs;
  for (int n = 1; n <= 8; ++n) outputs += "out" + std::to_string(n) + " = { from = \"0.1 + 0 * in\" }\n";
  desk.folder.write("many.toml", "format = 1\n[inputs]\nin = {}\n[outputs]\n" + outputs);
  // Kept in memory, 9 signals of 200 s would need 0.7 GB.
  const auto ran = desk.run("render many.toml --duration '200 s' --block 8192 --json", "ulimit -v 500000;");
  INFO(ran.out << ran.err);
  CHECK(ran.exit == 0);
  CHECK(ran.json()["frames"] == 200 * 48000);
}

TEST_CASE("render: a scene that would record more than 4 GB is refused before it runs", "[apps]") {
  // The position alone is 48000 * 8 B/s, 4 GB in 3.1 h.
  const test::Desk desk;
  desk.folder.write("plant.toml", R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 g", velocity = "1 m/s" }
[outputs]
x = { from = "n.a.position", unit = "m" }
)");
  desk.folder.write("long.toml", R"(format = 1
rate = "48 kHz"
duration = "20000 s"
[parts]
plant = { use = "plant.toml" }
)");
  const auto ran = desk.run("render long.toml");
  test::check_exit(ran, 3, "long.toml:3:12: more than 4");
}

TEST_CASE("render: a file is followed by silence up to the duration, at its rate or another one", "[apps]") {
  const test::Desk desk;
  desk.folder.write("through.toml",
                    "format = 1\n[inputs]\nin = {}\n[outputs]\nout = { from = \"0.5 * in\" }\n");
  REQUIRE(write_wav(desk.file("in.wav"), {44.1_kHz, {std::vector<double>(1000, 0.5)}}));
  const auto frames = [&](const std::string& options) {
    const auto ran = desk.run("render through.toml --in in.wav --out out.wav " + options);
    INFO(ran.out << ran.err);
    REQUIRE(ran.exit == 0);
    const auto out = read_wav(desk.file("out.wav"));
    REQUIRE(out);
    CHECK(out->channels[0][500] == Approx(0.25).epsilon(0.01));
    return out->frames();
  };
  CHECK(frames("") == 1000);
  CHECK(frames("--duration '50 ms'") == 2205);
  CHECK(read_wav(desk.file("out.wav"))->channels[0][1500] == 0.0);
  CHECK(frames("--duration '20 ms'") == 882);
  CHECK(frames("--rate '88.2 kHz'") == 2000);
  CHECK(frames("--rate '88.2 kHz' --duration '50 ms'") == 4410);
}
