#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/messages.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using test::mistakes;
using test::TemporaryFolder;

namespace {

/// Line 1 is the format; line 2 is the first of `text`.
test::Messages told(const std::string& text) { return mistakes("format = 1\n" + text); }

}  // namespace

TEST_CASE("mistakes: those of the text and those of its meaning come together, in file order", "[graph]") {
  CHECK(
      told(R"([inputs]
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
      R"(test.toml:5:1: 'Hit' cannot name a node; names begin with a lower-case letter, followed by lower-case letters, digits and _
test.toml:6:12: this is in N, but it is added to what is in m; multiply one of them by a quantity that turns its unit into the other's
test.toml:7:1: node 'lost' has neither 'type' nor 'use'; give a node type, as in type = "low_pass", or the file of a part, as in use = "string.toml"
test.toml:9:28: there is no 'nowhere'; write an input, a control or a node of this file
test.toml:11:1: output 'y' is a plain number, but its source is in m; give it a unit, as in unit = "m", or scale it to full scale)");
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
j = "2 N"
[networks.net]
mass_ = { mass = "1 kg" }
[outputs]
y = { from = "i + j + k + l + m_ + n + o + net.mass_.position" }
)") ==
        R"(test.toml:3:5: 'i' in [inputs] must be a table, not a number; write i = { unit = "full scale" }
test.toml:4:14: 'furlong' is not a unit; write units as "m/s", "N/m", "ms", "dB" or "full scale"
test.toml:6:5: 'k' in [controls] must be a table, not a number; write k = { value = 0.5, range = [0, 1] }
test.toml:7:1: control 'l' lacks 'value'; give its initial value, as in value = 0.5
test.toml:8:16: '3 N' is in N, but 'value' is in m; give "12 mm"
test.toml:10:1: node 'n' has neither 'type' nor 'use'; is 'typ' a misspelling of 'type'?
test.toml:11:9: the expression is incomplete; write a number, a name or '(' here
test.toml:12:1: 'j' cannot name a node: it names an input in line 4; choose another name
test.toml:14:1: element 'mass_' of network 'net' has no 'type'; give its type, as in type = "mass")");
}

TEST_CASE("mistakes: in a section with a wrong name, nothing is missed", "[graph]") {
  CHECK(told(R"([nods]
a = { type = "clip", in = "x" }
[outputs]
y = { from = "a + b + 3 m" }
)") ==
        R"(test.toml:2:2: unknown key 'nods'; did you mean 'nodes'?
test.toml:5:1: output 'y' is a plain number, but its source is in m; give it a unit, as in unit = "m", or scale it to full scale)");
}

TEST_CASE("mistakes: units that meet in an expression", "[graph]") {
  CHECK(
      told(R"toml([inputs]
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
)toml") ==
      R"(test.toml:6:10: this is in N, but it is taken from what is in m; multiply one of them by a quantity that turns its unit into the other's
test.toml:7:13: this is in s, but it is compared with what is in m; multiply one of them by a quantity that turns its unit into the other's
test.toml:8:34: this is in N, but it is in a list with what is in m; give both the same unit
test.toml:9:32: 'in' of spring 'd' is in m, but this is in m/s; give a quantity in m
test.toml:9:53: 'stiffness' of spring 'd' is in N/m, but this is in N; give a quantity in N/m
test.toml:12:1: output 'y' is in N, but its source is in m; fix 'from' or 'unit'
test.toml:13:26: 'parsec' is not a unit; write units as "m/s", "N/m", "ms", "dB" or "full scale")");
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
)") ==
        R"(test.toml:3:14: there is no node type 'lowpas'; did you mean 'low_pass'?
test.toml:4:62: 'interpolation' of delay 'b' cannot be 'cubik'; there are 'none', 'linear', 'lagrange3' and 'lagrange5'
test.toml:5:1: delay 'c' lacks 'in'; write in = … (signal to delay)
test.toml:5:23: delay 'c' has no 'inn'; did you mean 'in'?
test.toml:5:39: a signal cannot be true or false; give a number, a quantity such as "15 ms", or an expression such as "0.5 * x"
test.toml:6:62: 'interpolation' of delay 'd' must be a string, not a number; put it in quotes
test.toml:7:28: 'b' has no output 'left'; `tactus nodes` lists the outputs of every type
test.toml:8:27: a signal cannot be an empty list; give a number, a quantity such as "15 ms", or an expression such as "0.5 * x"
test.toml:8:37: a spread over lanes lacks 'to'; write { from = …, to = …, curve = "linear" or "exponential" }
test.toml:8:60: 'voices' of clip 'f' cannot be 0; give one from 1 to 1024
test.toml:9:46: '1 m' is in m, but 'points' is in s; give "15 ms"
test.toml:9:57: 'points' of curve 'g' must hold pairs; write [[x, y], [x, y], …]
test.toml:10:30: 'seed' of noise 'h' must be a whole number; give one from 0 to 9007199254740992
test.toml:12:1: output 'y' lacks 'from'; give its source, as in from = "node"
test.toml:12:7: output 'y' has no 'form'; did you mean 'from'?
test.toml:12:26: 'kind' of output 'y' cannot be 'sound'; there are 'drive' and 'audio')");
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
d = { type = "clip", in = { from = "1 m", to = "2 s" }, voices = 3 }
e = { type = "clip", in = { from = 0, to = 1, curve = "exponential" }, voices = 3 }
[outputs]
y = { from = "a" }
)") ==
        R"(test.toml:4:18: 'lanes' of input 'many' cannot be 0; give one from 1 to 1024
test.toml:6:6: 2 lanes are combined with 3; give both the same number of lanes, or put a 'mix' between them
test.toml:8:28: a lane cannot be a list; a list must have one number, quantity or expression for each lane
test.toml:9:59: 'curve' of a spread over lanes cannot be 'round'; there are 'linear' and 'exponential'
test.toml:10:48: this is in s, but it is in a spread with what is in m; give both the same unit
test.toml:11:27: an exponential spread cannot start at, end at or cross 0; give both ends the same sign, or use the linear curve)");
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
)") ==
        R"(test.toml:3:15: control 'a' starts at 2, which is outside its range; it runs from 0 to 1
test.toml:4:15: control 'b' starts at -70 dB, which is outside its range; it runs from -60 dB to 0 dB
test.toml:5:28: 'range' of control 'c' has its limits in the wrong order; write the lower limit first
test.toml:6:32: '1 mm' is in m, but 'range' is in s; give "15 ms"
test.toml:6:40: '20 mm' is in m, but 'range' is in s; give "15 ms"
test.toml:7:28: 'range' of control 'e' must have two limits; write range = [low, high]
test.toml:8:15: 'loud' is not a number with a unit; write a number and its unit, such as "15 ms"
test.toml:9:27: 'smooth' of control 'g' cannot be -1 ms; it must be at least 0 s
test.toml:10:18: control 'h' has no 'rnage'; did you mean 'range'?
test.toml:12:20: '0 m' is in m, but 'tested' is in s; give "15 ms")");
  CompileOptions options;
  options.controls = {{"gain", 3.0}, {"loudness", 1.0}};
  CHECK(
      mistakes("format = 1\n[controls]\ngain = { value = \"1 V\", range = [\"0 V\", \"2 V\"] }\n", options) ==
      R"(control 'gain' cannot be set to 3 V; it runs from 0 V to 2 V
there is no control 'loudness'; this graph has 'gain')");
}

TEST_CASE("mistakes: networks", "[graph]") {
  CHECK(
      told(R"([networks.drum]
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
      R"(test.toml:3:10: 'solver' cannot be 'fast'; there are 'explicit', 'exact', 'implicit', 'passive', 'auto' and 'reference'
test.toml:5:18: there is no element type 'mas'; did you mean 'mass'?
test.toml:6:48: network 'drum' has no element 'stik'; did you mean 'stick'?
test.toml:8:34: 'stick.mass' of network 'wall' is in kg, but this is in m; give a quantity in kg
test.toml:8:46: there is no 'nowhere'; write an input, a control or a node of this file
test.toml:11:6: there is no 'wall.stick.colour'; did you mean 'wall.stick.velocity'?
test.toml:12:10: 'wall' is not a signal; write an element of the network, such as 'wall.stick.position')");
}

TEST_CASE("mistakes: delays without bounds, changing fixed ports and loops come together", "[graph]") {
  CHECK(told(R"([inputs]
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
        R"(test.toml:7:1: delay 'a': the maximum delay cannot be determined; give max = "..." a time
test.toml:8:65: 'high_pass' of onset 'b' must not change during playback; give a number, a quantity, or an expression of controls
test.toml:9:1: p -> q -> p contains no delay; insert a 'delay' node in one of these connections
test.toml:11:1: r -> r contains no delay; insert a 'delay' node in one of these connections)");
}

TEST_CASE("mistakes: what is compensated for must be a node with a type", "[graph]") {
  CHECK(
      told(R"([inputs]
x = {}
[nodes]
s = "1 * x"
b = { type = "delay", in = "x", time = "9 ms", compensate = ["nobody", "s"] }
c = { type = "delay", in = "x", time = "9 ms", compensate = [3] }
[outputs]
y = { from = "b + c" }
)") ==
      R"(test.toml:6:61: there is no node 'nobody' to compensate; list nodes that this file declares with 'type'; expressions and parts cannot be compensated
test.toml:6:61: there is no node 's' to compensate; list nodes that this file declares with 'type'; expressions and parts cannot be compensated
test.toml:7:62: 'compensate' of delay 'c' must be a list of node names; write ["node", "node"])");
}

TEST_CASE("mistakes: what is compensated for is a filter, and named once", "[graph]") {
  CHECK(told(R"([inputs]
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
        R"(test.toml:7:82: 'tone' is compensated twice; list it once
test.toml:8:82: 'string' cannot be compensated: it is not a filter; omit it; list only nodes that change the phase
test.toml:9:82: 'c' cannot be compensated: it is not a filter; omit it; list only nodes that change the phase)");
  CHECK(
      told(R"([inputs]
x = {}
[nodes]
pad = { type = "align", in = "x", period = "0 s", delay = "9 ms" }
[outputs]
y = { from = "pad" }
)") ==
      "test.toml:5:1: align 'pad': its period is always shorter than two frames, 41.6667 us; give the period "
      "of the note, "
      "as in "
      "period = \"1 / pitch\"");
}

TEST_CASE("mistakes: what is in a part that is used twice is told once, and a loop through it by its path",
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
  CHECK(
      folder.strip(to_string(schedule.error())) ==
      R"(part.toml:5:19: a.out -> b.out -> a.out contains no delay; insert a 'delay' node in one of these connections)");
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
e = { use = "/part.toml" }
f = "a + b.froce + c.anything"
g = { use = "whole.toml" }
[outputs]
y = { from = "f" }
)");
  const auto schedule = compile(load_graph_leniently(folder.path() / "whole.toml"), standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(folder.strip(to_string(schedule.error())) ==
        R"(whole.toml:5:1: part 'a' lacks 'out'; it is an input of part.toml
whole.toml:5:32: 'in' is in m, but this is in V; give a quantity in m
whole.toml:5:36: part 'a' has no 'gian'; did you mean 'gain'?
whole.toml:6:51: 'gain' is in N/m, but this is in m; give a quantity in N/m
whole.toml:7:13: there is no file 'prat.toml'; did you mean 'part.toml'?
whole.toml:8:13: '/part.toml' is an absolute path; give the path relative to this file
whole.toml:9:6: 'a' is not a signal; write one of its outputs, such as 'a.force'
whole.toml:9:10: there is no 'b.froce'; did you mean 'b.force'?
whole.toml:10:13: a file includes itself: whole.toml -> whole.toml; remove one of these parts from its file
part.toml:8:15: this is in s, but it is added to what is in m; multiply one of them by a quantity that turns its unit into the other's)");
}

TEST_CASE("mistakes: a part does not leave the folder of its instrument", "[graph]") {
  const TemporaryFolder folder;
  folder.write("part.toml", "format = 1\n");
  folder.write("drum/whole.toml", "format = 1\n[nodes]\nd = { use = \"../part.toml\", in = \"x\" }\n");
  const auto schedule =
      compile(load_graph_leniently(folder.path() / "drum/whole.toml"), standard_nodes(), {});
  REQUIRE(!schedule);
  CHECK(
      folder.strip(to_string(schedule.error())) ==
      R"(drum/whole.toml:3:13: '../part.toml' is outside the folder 'drum'; keep the files of an instrument inside it)");
}
