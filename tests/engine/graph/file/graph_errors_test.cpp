#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::errors_of;
using test::TemporaryFolder;

namespace {

/// Line 1 is the format; line 2 is the first of `text`.
std::string body_errors(const std::string& text) { return errors_of("format = 1\n" + text); }

}  // namespace

TEST_CASE("errors: those of the text and those of its meaning come together, in file order", "[graph]") {
  CHECK(body_errors(R"([inputs]
x = { unit = "m" }
[nodes]
Hit = { type = "clip", in = "x" }
sum = "x + 3 N"
lost = { in = "x" }
c = { type = "clip", in = "lost" }
d = { type = "clip", in = "nowhere" }
[outputs]
y = { from = "sum" }
)") ==
        R"(test.toml:5:1 Syntax 'Hit'
test.toml:6:12 UnitMismatch
test.toml:7:1 Missing 'lost' 'type' 'use' type "low_pass" use "string.toml"
test.toml:9:28 UnknownName 'nowhere'
test.toml:11:1 UnitMismatch 'y' unit "m")");
}

TEST_CASE("errors: what was reported already raises no second error", "[graph]") {
  CHECK(body_errors(R"([inputs]
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
)") ==
        R"(test.toml:3:5 WrongType 'i' [inputs] i unit "full scale"
test.toml:4:14 UnknownName 'furlong' "m/s" "N/m" "ms" "dB" "full scale"
test.toml:6:5 WrongType 'k' [controls] k value 0.5 range 0 1
test.toml:7:1 Missing 'l' 'value' value 0.5
test.toml:8:16 UnitMismatch '3 N' 'value' "12 mm"
test.toml:10:1 Missing 'n' 'type' 'use' 'typ' 'type'
test.toml:11:9 Syntax '('
test.toml:12:1 Duplicate 'j' 4
test.toml:14:1 Missing 'mass_' 'net' 'type' type "mass")");
}

TEST_CASE("errors: in a section with a wrong name, nothing is missed", "[graph]") {
  CHECK(body_errors(R"([nods]
a = { type = "clip", in = "x" }
[outputs]
y = { from = "a + b + 3 m" }
)") ==
        R"(test.toml:2:2 UnknownName 'nods' 'nodes'
test.toml:5:1 UnitMismatch 'y' unit "m")");
}

TEST_CASE("errors: units that meet in an expression", "[graph]") {
  CHECK(body_errors(R"toml([inputs]
x = { unit = "m" }
f = { unit = "N" }
[nodes]
a = "x - f"
b = "min(x, 2 s)"
c = { type = "clip", in = ["x", "f"] }
d = { type = "spring", in = "x / 1 s", stiffness = "2 N" }
k = "max(x, -0.5)"
[outputs]
y = { from = "k", unit = "N" }
z = { from = "k", unit = "parsec" }
)toml") ==
        R"(test.toml:6:10 UnitMismatch
test.toml:7:13 UnitMismatch 'min'
test.toml:8:34 UnitMismatch
test.toml:9:32 UnitMismatch 'in' 'd'
test.toml:9:53 UnitMismatch 'stiffness' 'd'
test.toml:12:1 UnitMismatch 'y' 'from' 'unit'
test.toml:13:26 UnknownName 'parsec' "m/s" "N/m" "ms" "dB" "full scale")");
}

TEST_CASE("errors: types, ports and settings", "[graph]") {
  CHECK(body_errors(R"([nodes]
a = { type = "lowpas", in = 1 }
b = { type = "delay", in = 1, time = "1 ms", interpolation = "cubik" }
c = { type = "delay", inn = 1, time = true }
d = { type = "delay", in = 1, time = "1 ms", interpolation = 3 }
k = { type = "clip", in = "b.left" }
f = { type = "clip", in = [], low = { from = 1 }, voices = 0 }
g = { type = "curve", points = [["0 s", 1], ["1 m", 2], 3] }
h = { type = "noise", seed = 1.5 }
[outputs]
y = { form = "a", kind = "sound" }
)") ==
        R"(test.toml:3:14 UnknownName 'lowpas' 'low_pass'
test.toml:4:62 UnknownName 'interpolation' 'b' 'cubik' 'none' 'linear' 'lagrange3' 'lagrange5'
test.toml:5:1 Missing 'c' 'in' in
test.toml:5:23 UnknownName 'c' 'inn' 'in'
test.toml:5:39 WrongType "15 ms" "0.5 * x"
test.toml:6:62 WrongType 'interpolation' 'd'
test.toml:7:28 UnknownName 'b' 'left' `tactus nodes`
test.toml:8:27 WrongType "15 ms" "0.5 * x"
test.toml:8:37 Missing 'to' from to curve "linear" "exponential"
test.toml:8:60 OutOfRange 'voices' 'f' 0 1 1024
test.toml:9:46 UnitMismatch '1 m' 'points' "15 ms"
test.toml:9:57 WrongType 'points' 'g'
test.toml:10:30 OutOfRange 'seed' 'h' 0 9007199254740992
test.toml:12:1 Missing 'y' 'from' from "node"
test.toml:12:7 UnknownName 'y' 'form' 'from'
test.toml:12:26 UnknownName 'kind' 'y' 'sound' 'drive' 'audio')");
}

TEST_CASE("errors: lanes", "[graph]") {
  CHECK(body_errors(R"([inputs]
x = { lanes = 2 }
many = { lanes = 0 }
[nodes]
a = "x * three"
three = { type = "clip", in = [1, 2, 3] }
b = { type = "clip", in = [[1], 2] }
c = { type = "clip", in = { from = 1, to = "2 m", curve = "round" } }
d = { type = "clip", in = { from = "1 m", to = "2 s" }, voices = 3 }
k = { type = "clip", in = { from = 0, to = 1, curve = "exponential" }, voices = 3 }
[outputs]
y = { from = "a" }
)") ==
        R"(test.toml:4:18 OutOfRange 'lanes' 'many' 0 1 1024
test.toml:6:6 OutOfRange 2 3 'mix'
test.toml:8:28 WrongType
test.toml:9:59 UnknownName 'curve' 'round' 'linear' 'exponential'
test.toml:10:48 UnitMismatch
test.toml:11:27 OutOfRange 0)");
}

TEST_CASE("errors: controls", "[graph]") {
  CHECK(body_errors(R"([controls]
a = { value = 2, range = [0, 1] }
b = { value = "-70 dB", range = ["-60 dB", "0 dB"] }
c = { value = 0.5, range = [1, 0] }
d = { value = "5 ms", range = ["1 mm", "20 mm"] }
k = { value = 0.5, range = [1] }
f = { value = "loud" }
g = { value = 1, smooth = "-1 ms" }
h = { value = 1, rnage = [0, 2] }
[delay]
tested = ["40 ms", "0 m"]
)") ==
        R"(test.toml:3:15 OutOfRange 'a' 2 0 1
test.toml:4:15 OutOfRange 'b' -70 -60 0
test.toml:5:28 OutOfRange 'range' 'c'
test.toml:6:32 UnitMismatch '1 mm' 'range' "15 ms"
test.toml:6:40 UnitMismatch '20 mm' 'range' "15 ms"
test.toml:7:28 WrongType 'range' 'k' range
test.toml:8:15 Syntax 'loud' "15 ms"
test.toml:9:27 OutOfRange 'smooth' 'g' -1 0
test.toml:10:18 UnknownName 'h' 'rnage' 'range'
test.toml:12:20 UnitMismatch '0 m' 'tested' "15 ms")");
  CompileOptions options;
  options.controls = {{"gain", 3.0}, {"loudness", 1.0}};
  CHECK(errors_of("format = 1\n[controls]\ngain = { value = \"1 V\", range = [\"0 V\", \"2 V\"] }\n",
                  options) ==
        R"(OutOfRange 'gain' 3 0 2
UnknownName 'loudness' 'gain')");
}

TEST_CASE("errors: networks", "[graph]") {
  CHECK(
      body_errors(R"([networks.drum]
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
)") ==
      R"(test.toml:3:10 UnknownName 'solver' 'fast' 'explicit' 'exact' 'implicit' 'passive' 'auto' 'reference'
test.toml:5:18 UnknownName 'mas' 'mass'
test.toml:6:48 UnknownName 'drum' 'stik' 'stick'
test.toml:8:34 UnitMismatch 'stick.mass' 'wall'
test.toml:8:46 UnknownName 'nowhere'
test.toml:11:6 UnknownName 'wall.stick.colour' 'wall.stick.velocity'
test.toml:12:10 UnknownName 'wall' 'wall.stick.position')");
}

TEST_CASE("errors: delays without bounds, changing fixed ports and loops come together", "[graph]") {
  CHECK(body_errors(R"([inputs]
x = {}
[controls]
late = { value = "1 ms" }
[nodes]
a = { type = "delay", in = "x + a", time = "late" }
b = { type = "onset", in = "x", threshold = 0.1, high_pass = "x * 1 Hz" }
p = { type = "clip", in = "q + x" }
q = { type = "clip", in = "p" }
r = { type = "clip", in = "r + x" }
[outputs]
y = { from = "a + b + p + r" }
)") ==
        R"(test.toml:7:1 OutOfRange 'a' max "..."
test.toml:8:65 WrongType 'high_pass' 'b'
test.toml:9:1 Cycle p -> q -> p 'delay'
test.toml:11:1 Cycle r -> r 'delay')");
}

TEST_CASE("errors: what is compensated for must be a node with a type", "[graph]") {
  CHECK(body_errors(R"([inputs]
x = {}
[nodes]
s = "1 * x"
b = { type = "delay", in = "x", time = "9 ms", compensate = ["nobody", "s"] }
c = { type = "delay", in = "x", time = "9 ms", compensate = [3] }
[outputs]
y = { from = "b + c" }
)") ==
        R"(test.toml:6:61 UnknownName 'nobody' 'type'
test.toml:6:61 UnknownName 's' 'type'
test.toml:7:62 WrongType 'compensate' 'c' "node" "node")");
}

TEST_CASE("errors: what is compensated for is a filter, and named once", "[graph]") {
  CHECK(body_errors(R"([inputs]
x = {}
[nodes]
tone   = { type = "low_pass", in = "x", cutoff = "200 Hz" }
string = { type = "string", in = "tone", pitch = "110 Hz" }
a = { type = "align", in = "tone", period = "9 ms", delay = "9 ms", compensate = ["tone", "tone"] }
b = { type = "align", in = "tone", period = "9 ms", delay = "9 ms", compensate = ["tone", "string"] }
c = { type = "align", in = "tone", period = "9 ms", delay = "9 ms", compensate = ["c"] }
[outputs]
y = { from = "a + b + c + string" }
)") ==
        R"(test.toml:7:82 BadArgument 'tone'
test.toml:8:82 BadArgument 'string'
test.toml:9:82 BadArgument 'c')");
  CHECK(body_errors(R"([inputs]
x = {}
[nodes]
pad = { type = "align", in = "x", period = "0 s", delay = "9 ms" }
[outputs]
y = { from = "pad" }
)") == R"(test.toml:5:1 OutOfRange 'pad' 41.6667 period "1 / pitch")");
}

TEST_CASE("errors: what is in a part that is used twice is reported once, and a loop through it by its path",
          "[graph]") {
  const TemporaryFolder folder;
  folder.write("part.toml", "format = 1\n[inputs]\nin = {}\n[outputs]\nout = { from = \"2 * in\" }\n");
  folder.write("whole.toml", R"(format = 1
[nodes]
a = { use = "part.toml", in = "b" }
b = { use = "part.toml", in = "a" }
[outputs]
y = { from = "a" }
)");
  const auto schedule = compile(load_graph_leniently(folder.path() / "whole.toml"), standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(folder.strip(test::summary(schedule)) == "part.toml:5:19 Cycle a.out -> b.out -> a.out 'delay'");
}

TEST_CASE("errors: parts", "[graph]") {
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
k = { use = "/part.toml" }
f = "a + b.froce + c.anything"
g = { use = "whole.toml" }
[outputs]
y = { from = "f" }
)");
  const auto schedule = compile(load_graph_leniently(folder.path() / "whole.toml"), standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(folder.strip(test::summary(schedule)) ==
        R"(whole.toml:5:1 Missing 'a' 'out' part.toml
whole.toml:5:32 UnitMismatch 'in'
whole.toml:5:36 UnknownName 'a' 'gian' 'gain'
whole.toml:6:51 UnitMismatch 'gain'
whole.toml:7:13 BadFile 'prat.toml' 'part.toml'
whole.toml:8:13 OutOfRange '/part.toml'
whole.toml:9:6 UnknownName 'a' 'a.force'
whole.toml:9:10 UnknownName 'b.froce' 'b.force'
whole.toml:10:13 Cycle whole.toml whole.toml
part.toml:8:15 UnitMismatch)");
}

TEST_CASE("errors: what a part is given outside the range that it declares", "[graph]") {
  const TemporaryFolder folder;
  folder.write("inner.toml", R"(format = 1
[inputs]
in = { range = [-2, 2] }
[controls]
time = { value = "1 ms", range = ["0 ms", "5 ms"] }
level = { value = "0 dB", range = ["-60 dB", "0 dB"] }
[nodes]
late = { type = "delay", in = "in", time = "time", max = "1 s" }
[outputs]
out = { from = "level * late" }
)");
  folder.write("outer.toml", R"(format = 1
[inputs]
in = { unit = "full scale" }
[controls]
time = { value = "1 ms", range = ["0 ms", "5 ms"] }
[nodes]
inside = { use = "inner.toml", in = "in", time = "time" }
[outputs]
out = { from = "inside" }
)");
  const auto errors_of_parts = [&](const std::string& given) {
    folder.write("whole.toml", R"(format = 1
[inputs]
x = {}
[controls]
free = { value = "1 ms", range = ["-1 ms", "1 ms"] }
far = { value = "7 ms", range = ["6 ms", "8 ms"] }
[nodes]
negative = "-1 ms"
p = { )" + given + R"( }
[outputs]
y = { from = "p" }
z = { from = "(free + far + negative) / 1 s" }
)");
    const auto plan = compile(load_graph_leniently(folder.path() / "whole.toml"), standard_nodes(), {});
    return plan ? "" : folder.strip(test::full_text(plan.error()));
  };
  const std::string inner = "use = \"inner.toml\", in = \"x\", ",
                    outer = "use = \"outer.toml\", in = \"x\", ";
  CHECK(errors_of_parts(inner + "time = \"5 ms\", level = \"-60 dB\"") == "");
  CHECK(errors_of_parts(inner + "time = \"-1 ms\"") ==
        "whole.toml:9:45: 'time' of part 'p' cannot be -1 ms; it runs from 0 s to 5 ms");
  CHECK(errors_of_parts(inner + "level = \"6 dB\"") ==
        "whole.toml:9:46: 'level' of part 'p' cannot be 6 dB; it runs from -60 dB to 0 dB");
  CHECK(errors_of_parts("use = \"inner.toml\", in = 3") ==
        "whole.toml:9:32: 'in' of part 'p' cannot be 3; it runs from -2 to 2");
  // A constant by its name or of an expression, and one lane of several.
  CHECK(errors_of_parts(inner + "time = \"negative\"") ==
        "whole.toml:9:45: 'time' of part 'p' cannot be -1 ms; it runs from 0 s to 5 ms");
  CHECK(errors_of_parts(inner + "time = \"2 * 4 ms\"") ==
        "whole.toml:9:47: 'time' of part 'p' cannot be 8 ms; it runs from 0 s to 5 ms");
  CHECK(errors_of_parts(inner + "time = [\"1 ms\", \"6 ms\"]") ==
        "whole.toml:9:54: 'time' of part 'p' cannot be 6 ms; it runs from 0 s to 5 ms");
  // A part in the part gets it too, and it is one error; so is a wrong unit.
  CHECK(errors_of_parts(outer + "time = \"9 ms\"") ==
        "whole.toml:9:45: 'time' of part 'p' cannot be 9 ms; it runs from 0 s to 5 ms");
  CHECK(errors_of_parts(inner + "time = \"9 m\"") ==
        "whole.toml:9:45: 'time' is in s, but this is in m; give a quantity in s");
  // A signal that may leave the range, and one that is never inside.
  CHECK(errors_of_parts(inner + "time = \"free\"") == "");
  CHECK(errors_of_parts(inner + "time = \"x * 1 s\"") == "");
  CHECK(errors_of_parts(inner + "time = \"far\"") ==
        "whole.toml:9:45: 'time' of part 'p' cannot be 6 ms; it runs from 0 s to 5 ms");
}

TEST_CASE("errors: between a length and an angle is an arm", "[graph]") {
  const auto remedy = [](const std::string& unit, const std::string& given) {
    const auto text =
        test::full_errors_of("format = 1\n[inputs]\nx = { unit = \"" + given +
                             "\" }\n[outputs]\ny = { from = \"x\", unit = \"" + unit + "\" }\n");
    return text.substr(text.find("output"));
  };
  CHECK(remedy("m", "rad") ==
        "output 'y' is in m, but its source is in rad; multiply by the length of the arm, such as 0.1 m");
  CHECK(remedy("m/s", "rad/s") ==
        "output 'y' is in m/s, but its source is in rad/s; multiply by the length of the arm, such as 0.1 m");
  CHECK(remedy("N", "N m") ==
        "output 'y' is in N, but its source is in N m; divide by the length of the arm, such as 0.1 m");
  CHECK(remedy("N/m", "N m/rad") ==
        "output 'y' is in N/m, but its source is in N m/rad; divide by the square of the length of the arm, "
        "such as 0.1 m");
  CHECK(remedy("m", "1/m") == "output 'y' is in m, but its source is in 1/m; fix 'from' or 'unit'");
  const auto of_node = test::full_errors_of(R"(format = 1
[inputs]
angle = { unit = "rad" }
[nodes]
s = { type = "terrain", profile = "sine", position = "angle", weight = "1 N", height = "1 mm", length = "1 mm" }
[outputs]
y = { from = "s / 1 N" }
)");
  CHECK(of_node ==
        "test.toml:5:55: 'position' of terrain 's' is in m, but this is in rad; multiply by the length of "
        "the arm, "
        "such as 0.1 m, or write motion = \"rotation\" for angles and torques");
}

TEST_CASE("errors: a part does not leave the folder of its instrument", "[graph]") {
  const TemporaryFolder folder;
  folder.write("part.toml", "format = 1\n");
  folder.write("drum/whole.toml", "format = 1\n[nodes]\nd = { use = \"../part.toml\", in = \"x\" }\n");
  const auto schedule =
      compile(load_graph_leniently(folder.path() / "drum/whole.toml"), standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(folder.strip(test::summary(schedule)) == "drum/whole.toml:3:13 OutOfRange '../part.toml' 'drum'");
}
