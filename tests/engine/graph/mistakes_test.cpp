#include <catch2/catch.hpp>

#include "tests/engine/graph/temporary_folder.h"
#include "tests/support/graph_runner.h"

using namespace tactus;
using test::mistakes;
using test::TemporaryFolder;

namespace {

/// Line 1 is the format; line 2 is the first of `text`.
std::string told(const std::string& text) { return mistakes("format = 1\n" + text); }

}  // namespace

TEST_CASE("mistakes: those of the text and those of its meaning come together, in file order", "[graph]") {
  CHECK(told(R"([inputs]
x = { unit = "m" }
[nodes]
Hit = { type = "clip", in = "x" }
sum = "x + 3 N"
lost = { in = "x" }
c = { type = "clip", in = "lost" }
d = { type = "clip", in = "nowhere" }
[outputs]
y = { from = "sum" }
)") == "");
}

TEST_CASE("mistakes: what was told already raises no second error", "[graph]") {
  CHECK(told(R"([inputs]
i = 3
j = { unit = "furlong" }
[controls]
k = 0.5
l = { range = [0, 1] }
m_ = { value = "3 N", unit = "m" }
[nodes]
n = { typ = "clip", in = "i" }
o = "3 +"
twice = "1 m"
twice = "2 N"
[networks.net]
mass_ = { mass = "1 kg" }
[outputs]
y = { from = "i + j + k + l + m_ + n + o + net.mass_.position" }
)") == "");
  CHECK(told(R"([inputs]
i = 3
j = { unit = "furlong" }
[controls]
k = 0.5
l = { range = [0, 1] }
m_ = { value = "3 N", unit = "m" }
[nodes]
n = { typ = "clip", in = "i" }
o = "3 +"
j = "2 N"
[networks.net]
mass_ = { mass = "1 kg" }
[outputs]
y = { from = "i + j + k + l + m_ + n + o + net.mass_.position" }
)") == "");
}

TEST_CASE("mistakes: in a section with a wrong name, nothing is missed", "[graph]") {
  CHECK(told(R"([nods]
a = { type = "clip", in = "x" }
[outputs]
y = { from = "a + b + 3 m" }
)") == "");
}

TEST_CASE("mistakes: units that meet in an expression", "[graph]") {
  CHECK(told(R"([inputs]
x = { unit = "m" }
f = { unit = "N" }
[nodes]
a = "x - f"
b = "min(x, 2 s)"
c = { type = "clip", in = ["x", "f"] }
d = { type = "spring", in = "x / 1 s", stiffness = "2 N" }
e = "max(x, -0.5)"
[outputs]
y = { from = "e", unit = "N" }
z = { from = "e", unit = "parsec" }
)") == "");
}

TEST_CASE("mistakes: types, ports and settings", "[graph]") {
  CHECK(told(R"([nodes]
a = { type = "lowpas", in = 1 }
b = { type = "delay", in = 1, time = "1 ms", interpolation = "cubik" }
c = { type = "delay", inn = 1, time = true }
d = { type = "delay", in = 1, time = "1 ms", interpolation = 3 }
e = { type = "clip", in = "b.left" }
f = { type = "clip", in = [], low = { from = 1 }, voices = 0 }
g = { type = "curve", points = [["0 s", 1], ["1 m", 2], 3] }
h = { type = "noise", seed = 1.5 }
[outputs]
y = { form = "a", kind = "sound" }
)") == "");
}

TEST_CASE("mistakes: lanes", "[graph]") {
  CHECK(told(R"([inputs]
x = { lanes = 2 }
many = { lanes = 0 }
[nodes]
a = "x * three"
three = { type = "clip", in = [1, 2, 3] }
b = { type = "clip", in = [[1], 2] }
c = { type = "clip", in = { from = 1, to = "2 m", curve = "round" } }
[outputs]
y = { from = "a" }
)") == "");
}

TEST_CASE("mistakes: controls", "[graph]") {
  CHECK(told(R"([controls]
a = { value = 2, range = [0, 1] }
b = { value = "-70 dB", range = ["-60 dB", "0 dB"] }
c = { value = 0.5, range = [1, 0] }
d = { value = "5 ms", range = ["1 mm", "20 mm"] }
e = { value = 0.5, range = [1] }
f = { value = "loud" }
g = { value = 1, smooth = "-1 ms" }
h = { value = 1, rnage = [0, 2] }
[delay]
tested = ["40 ms", "0 m"]
)") == "");
  CompileOptions options;
  options.controls = {{"gain", 3.0}, {"loudness", 1.0}};
  CHECK(mistakes("format = 1\n[controls]\ngain = { value = \"1 V\", range = [\"0 V\", \"2 V\"] }\n", options) == "");
}

TEST_CASE("mistakes: networks", "[graph]") {
  CHECK(told(R"([networks.drum]
solver = "fast"
stick = { type = "mass", mass = "3 m" }
ball  = { type = "mas", mass = "3 kg" }
link  = { type = "spring", between = ["stick", "stik"], stiffness = "1 N/m" }
[networks.wall]
stick = { type = "mass", mass = "3 m", at = "nowhere" }
[nodes]
a = "drum.stick.position"
b = "wall.stick.colour"
c = "2 * wall"
)") == "");
}

TEST_CASE("mistakes: delays, compensation and what must not change", "[graph]") {
  CHECK(told(R"([inputs]
x = {}
[controls]
late = { value = "1 ms" }
[nodes]
s = "1"
a = { type = "delay", in = "x", time = "late" }
b = { type = "delay", in = "x", time = "1 ms", compensate = ["nobody", "s"] }
[outputs]
y = { from = "a" }
)") == "");
  CHECK(told(R"([inputs]
x = {}
[controls]
late = { value = "1 ms" }
[nodes]
a = { type = "delay", in = "x", time = "late" }
b = { type = "string", in = "x + b", frequency = "x * 1 Hz" }
p = { type = "clip", in = "q + x" }
q = { type = "clip", in = "p" }
r = { type = "clip", in = "r + x" }
[outputs]
y = { from = "a + b + p + r" }
)") == "");
}

TEST_CASE("mistakes: parts", "[graph]") {
  const TemporaryFolder folder;
  folder.write("part.toml", R"(format = 1
[inputs]
in = { unit = "m", about = "what it hears" }
out = {}
[controls]
gain = { value = "1 N/m", range = ["0 N/m", "2 N/m"] }
[nodes]
wrong = "in + 1 s"
[outputs]
force = { from = "in * gain" }
raw = { from = "in" }
)");
  folder.write("whole.toml", R"(format = 1
[inputs]
x = { unit = "V" }
[nodes]
a = { use = "part.toml", in = "x", gian = "1 N/m" }
b = { use = "part.toml", in = 3, out = 0, gain = "1 m" }
c = { use = "prat.toml", in = "x" }
d = { use = "../part.toml", in = "x" }
e = { use = "/part.toml" }
f = "a + b.froce + c.anything"
g = { use = "whole.toml" }
[outputs]
y = { from = "f" }
)");
  const auto loaded = load_graph_leniently(folder.path() / "whole.toml");
  const auto schedule = compile(loaded, standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(folder.strip(to_string(schedule.error())) == "");
}
