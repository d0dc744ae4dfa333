#include <catch2/catch.hpp>

#include "tests/support/graphs/graph_runner.h"
#include "tests/support/messages.h"

using namespace tactus;

namespace {

struct BadFile {
  const char* what;
  std::string text;
  std::string told;
};

// clang-format off
const BadFile kBadFiles[] = {
    {"empty",
     R"()",
     R"(test.toml:1:1: 'format' is missing; begin the file with format = 1)"},
    {"only a comment",
     R"(# nothing yet
)",
     R"(test.toml:1:1: 'format' is missing; begin the file with format = 1)"},
    {"the format is missing",
     R"([nodes]
a = 1
)",
     R"(test.toml:1:1: 'format' is missing; begin the file with format = 1)"},
    {"a format of the future",
     R"(format = 2
)",
     R"(test.toml:1:10: this format is unknown; write format = 1)"},
    {"a format in quotes",
     R"(format = "1"
)",
     R"(test.toml:1:10: this format is unknown; write format = 1)"},
    {"a name that is a number",
     R"(format = 1
name = 3
)",
     R"(test.toml:2:8: 'name' must be a string, not a number; put it in quotes)"},
    {"a section that is a list",
     R"(format = 1
nodes = [1, 2]
)",
     R"(test.toml:2:9: 'nodes' must be a table, not a list; begin it with [nodes])"},
    {"a scene's section in a graph",
     R"(format = 1
[gestures]
a = { points = [[0, 0]] }
)",
     R"(test.toml:2:2: 'gestures' is a key of scenes, but this is a graph; move it to the scene's file)"},
    {"an unknown section, nothing like it",
     R"(format = 1
[weather]
rain = true
)",
     R"(test.toml:2:2: unknown key 'weather'; there are 'format', 'name', 'about', 'source', 'inputs', 'controls', 'nodes', 'networks', 'outputs' and 'delay')"},
    {"an input in quotes",
     R"(format = 1
[inputs]
x = "full scale"
)",
     R"(test.toml:3:5: 'x' in [inputs] must be a table, not a string; write x = { unit = "full scale" })"},
    {"a unit that is a number",
     R"(format = 1
[inputs]
x = { unit = 3 }
)",
     R"(test.toml:3:14: 'unit' of input 'x' must be a string, not a number; write units as "m/s", "N/m", "ms", "dB" or "full scale")"},
    {"an empty unit with a slash",
     R"(format = 1
[inputs]
x = { unit = "m/" }
)",
     R"(test.toml:3:14: 'm/' is not a unit; write units as "m/s", "N/m", "ms", "dB" or "full scale")"},
    {"lanes in quotes",
     R"(format = 1
[inputs]
x = { lanes = "two" }
)",
     R"(test.toml:3:15: 'lanes' of input 'x' must be a whole number; give one from 1 to 1024)"},
    {"too many lanes",
     R"(format = 1
[inputs]
x = { lanes = 1000000 }
)",
     R"(test.toml:3:15: 'lanes' of input 'x' cannot be 1e+06; give one from 1 to 1024)"},
    {"an unknown field of an input",
     R"(format = 1
[inputs]
x = { units = "m" }
)",
     R"(test.toml:3:7: input 'x' has no 'units'; did you mean 'unit'?)"},
    {"a control that is a list",
     R"(format = 1
[controls]
g = { value = [1, 2] }
)",
     R"(test.toml:3:15: a number with a unit cannot be a list; give a number, or a number with its unit in quotes, such as "15 ms")"},
    {"a control that is not finite",
     R"(format = 1
[controls]
g = { value = "7000 dB" }
)",
     R"(test.toml:3:15: '7000 dB' is not finite; give a number below 1e300 in SI units)"},
    {"a quantity that no number can hold",
     R"(format = 1
[controls]
g = { value = "1e999 m" }
)",
     R"(test.toml:3:15: '1e999 m' is not finite; give a number below 1e300 in SI units)"},
    {"a quantity that is not a number",
     R"(format = 1
[controls]
g = { value = "nan m" }
)",
     R"(test.toml:3:15: 'nan m' is not finite; give a number below 1e300 in SI units)"},
    {"infinity",
     R"(format = 1
[controls]
g = { value = inf }
)",
     R"(test.toml:3:15: inf and nan are not allowed; give a finite number)"},
    {"not a number",
     R"(format = 1
[controls]
g = { value = -nan }
)",
     R"(test.toml:3:15: inf and nan are not allowed; give a finite number)"},
    {"a range in another unit",
     R"(format = 1
[controls]
g = { value = "3 mm", range = ["0 N", "5 N"] }
)",
     R"(test.toml:3:32: '0 N' is in N, but 'range' is in m; give "12 mm"
test.toml:3:39: '5 N' is in N, but 'range' is in m; give "12 mm")"},
    {"a start outside its range, in its own unit",
     R"(format = 1
[controls]
g = { value = "30 mm", range = ["0 mm", "20 mm"] }
)",
     R"(test.toml:3:15: control 'g' starts at 30 mm, which is outside its range; it runs from 0 m to 20 mm)"},
    {"a date",
     R"(format = 1
[controls]
g = { value = 2008-06-05 }
)",
     R"(test.toml:3:15: dates and times are not allowed here; put it in quotes if it is a string)"},
    {"a capital",
     R"(format = 1
[nodes]
Mix = "1"
)",
     R"(test.toml:3:1: 'Mix' cannot name a node; names begin with a lower-case letter, followed by lower-case letters, digits and _)"},
    {"a name in UTF-8",
     R"(format = 1
[nodes]
"größe" = "1"
)",
     R"(test.toml:3:1: 'größe' cannot name a node; names begin with a lower-case letter, followed by lower-case letters, digits and _)"},
    {"a letter with an accent outside of quotes",
     R"(format = 1
[controls]
gain = { value ßoss, range = [0, 1] }
)",
     R"(test.toml:3:16: 'ß' (U+00DF) is not allowed outside quotes; put the text around it in quotes, or remove it)"},
    {"a name in UTF-8 without quotes",
     R"(format = 1
[nodes]
größe = "1"
)",
     R"(test.toml:3:3: 'ö' (U+00F6) is not allowed outside quotes; put the text around it in quotes, or remove it)"},
    {"a blank that is none",
     "format = 1\n[nodes]\na\xC2\xA0= 1\n",
     "test.toml:3:2: '\xC2\xA0' (U+00A0) is not allowed outside quotes; put the text around it in quotes, or remove it"},
    {"a name with a dot",
     R"(format = 1
[nodes]
"a.b" = "1"
)",
     R"(test.toml:3:1: 'a.b' cannot name a node; names begin with a lower-case letter, followed by lower-case letters, digits and _)"},
    {"a reserved name",
     R"(format = 1
[nodes]
system = { type = "noise" }
)",
     R"(test.toml:3:1: 'system' is reserved and cannot name a node; choose another name)"},
    {"a name that is a unit",
     R"(format = 1
[nodes]
ms = "1"
)",
     R"(test.toml:3:1: 'ms' is a unit and cannot name a node; choose another name)"},
    {"a control called like an input",
     R"(format = 1
[inputs]
x = {}
[controls]
x = { value = 1 }
)",
     R"(test.toml:5:1: 'x' cannot name a control: it names an input in line 3; choose another name)"},
    {"the same node twice",
     R"(format = 1
[nodes]
a = "1"
a = "2"
)",
     R"(test.toml:4:5: cannot redefine existing string 'a'; rename or remove one of the two)"},
    {"two headings of one name",
     R"(format = 1
[nodes]
a = "1"
[controls]
g = { value = 1 }
[nodes]
b = "2"
)",
     R"(test.toml:6:1: cannot redefine existing table 'nodes'; put all its entries under one heading, or rename one of the two)"},
    {"both type and use",
     R"(format = 1
[nodes]
a = { type = "clip", use = "part.toml", in = 1 }
)",
     R"(test.toml:3:1: node 'a' has both 'type' and 'use'; remove one of them
test.toml:3:28: there is no file 'part.toml'; paths are relative to this file)"},
    {"a type that is a number",
     R"(format = 1
[nodes]
a = { type = 3 }
)",
     R"(test.toml:3:14: 'type' must be a string, not a number; put it in quotes)"},
    {"an empty type",
     R"(format = 1
[nodes]
a = { type = "" }
)",
     R"(test.toml:3:14: 'type' is empty; give a name)"},
    {"a type in French",
     R"(format = 1
[nodes]
a = { type = "écrêteur", in = 1 }
)",
     R"(test.toml:3:14: there is no node type 'écrêteur'; `tactus nodes` lists them all)"},
    {"an unknown type, nothing like it",
     R"(format = 1
[nodes]
a = { type = "xyzzy" }
)",
     R"(test.toml:3:14: there is no node type 'xyzzy'; `tactus nodes` lists them all)"},
    {"an input that is not named",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x" }
)",
     R"(test.toml:5:1: low_pass 'a' lacks 'cutoff'; write cutoff = … (cutoff frequency, where the gain is q (-3.01 dB for q = 0.7071); at most 0.49 of the sample rate))"},
    {"an unknown port",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutof = "100 Hz" }
)",
     R"(test.toml:5:1: low_pass 'a' lacks 'cutoff'; write cutoff = … (cutoff frequency, where the gain is q (-3.01 dB for q = 0.7071); at most 0.49 of the sample rate)
test.toml:5:36: low_pass 'a' has no 'cutof'; did you mean 'cutoff'?)"},
    {"the wrong unit at a port",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutoff = "10 ms" }
)",
     R"(test.toml:5:46: 'cutoff' of low_pass 'a' is in Hz, but this is in s; give a quantity in Hz)"},
    {"a number without its quotes",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutoff = 100 Hz }
)",
     R"(test.toml:5:45: '100 Hz' needs quotes; write "100 Hz")"},
    {"a negative time",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "delay", in = "x", time = "-5 ms" }
)",
     R"(test.toml:5:41: 'time' of delay 'a' cannot be -5 ms; it must be at least 0 s)"},
    {"a delay of years",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "delay", in = "x", time = "1e9 s" }
[outputs]
y = { from = "a" }
)",
     R"(test.toml:5:1: delay 'a': it can be 1000000000 s long, but the longest possible delay is 350 s; shorten 'time', or give 'max')"},
    {"many voices",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "clip", in = "x", voices = 1000000000 }
)",
     R"(test.toml:5:41: 'voices' of clip 'a' cannot be 1e+09; give one from 1 to 1024)"},
    {"voices that keep much",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "delay", in = "x", time = "10 s", voices = 1024 }
b = { type = "mix", in = "a" }
[outputs]
y = { from = "b" }
)",
     R"(test.toml:5:1: delay 'a': the graph would need more than 512 MB; use shorter delays and recordings, or fewer voices)"},
    {"clip upside down",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "clip", in = "x", low = 1, high = -1 }
[outputs]
y = { from = "a" }
)",
     R"(test.toml:5:1: clip 'a': 'low' is above 'high', so the output is always 'low'; exchange them)"},
    {"a step of nothing",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "quantiser", in = "x", step = 0 }
[outputs]
y = { from = "a" }
)",
     R"(test.toml:5:1: quantiser 'a': its 'step' is 0, so nothing is rounded; give a step above 0, or remove the node)"},
    {"points that go back",
     R"(format = 1
[nodes]
a = { type = "curve", points = [["0 s", 0], ["2 s", 1], ["1 s", 0]] }
[outputs]
y = { from = "a" }
)",
     R"(test.toml:3:1: curve 'a': 'points' is not a curve: the points are not in ascending order; write [[time, value], ...] with ascending times)"},
    {"an unknown choice",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "quantiser", in = "x", step = 0.1, rounding = "up" }
)",
     R"(test.toml:5:60: 'rounding' of quantiser 'a' cannot be 'up'; there are 'nearest' and 'floor')"},
    {"a seed in words",
     R"(format = 1
[nodes]
a = { type = "noise", seed = "seven" }
)",
     R"(test.toml:3:30: 'seed' of noise 'a' must be a whole number; give one from 0 to 9007199254740992)"},
    {"an expression that stops",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "x +"
)",
     R"(test.toml:5:9: the expression is incomplete; write a number, a name or '(' here)"},
    {"an expression with a bracket too many",
     R"toml(format = 1
[inputs]
x = {}
[nodes]
a = "(x + 1))"
)toml",
     R"(test.toml:5:13: ')' has no '(' before it; remove it)"},
    {"an expression with a power",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "x ^ 2"
)",
     R"(test.toml:5:8: '^' is not an operator; multiply instead)"},
    {"an unknown function",
     R"toml(format = 1
[inputs]
x = {}
[nodes]
a = "sin(x)"
)toml",
     R"(test.toml:5:6: there is no function 'sin'; the functions are min, max and abs)"},
    {"a comma for a point",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "0,5 * x"
)",
     R"(test.toml:5:7: ',' is only allowed in min( , ) and max( , ); write decimals with a point)"},
    {"an empty expression",
     R"(format = 1
[nodes]
a = ""
)",
     R"(test.toml:3:6: the expression is empty; write a number, a name or '(' here)"},
    {"an unknown unit behind a number",
     R"(format = 1
[nodes]
a = "3 furlongs"
)",
     R"(test.toml:3:8: 'furlongs' is not a unit; to multiply, write 3 * furlongs)"},
    {"a number too large",
     R"(format = 1
[nodes]
a = "1e999"
)",
     R"(test.toml:3:6: the number 1e999 is too large or too small; use a number between 1e-300 and 1e300)"},
    {"a typing slip in a name",
     R"(format = 1
[inputs]
microphone = {}
[nodes]
a = "2 * micropone"
)",
     R"(test.toml:5:10: there is no 'micropone'; did you mean 'microphone'?)"},
    {"a node that names only itself",
     R"(format = 1
[nodes]
a = "a"
[outputs]
y = { from = "a" }
)",
     R"(test.toml:3:1: a -> a contains no delay; insert a 'delay' node in one of these connections)"},
    {"a loop over expressions",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "x + b"
b = "0.5 * c"
c = "a"
[outputs]
y = { from = "a" }
)",
     R"(test.toml:5:8: a -> b -> a contains no delay; insert a 'delay' node in one of these connections)"},
    {"a loop whose delay can be too short",
     R"(format = 1
[inputs]
x = {}
[controls]
t = { value = "1 ms", range = ["0 ms", "2 ms"] }
[nodes]
a = { type = "delay", in = "x + 0.5 * a", time = "t" }
[outputs]
y = { from = "a" }
)",
     R"(test.toml:7:1: a -> a contains no delay; 'a' can be shorter than one frame: keep its time at one frame or more, with 'min' if necessary)"},
    {"an output in quotes",
     R"(format = 1
[outputs]
y = "x"
)",
     R"(test.toml:3:5: 'y' in [outputs] must be a table, not a string; write y = { from = "node" })"},
    {"an output in the wrong unit",
     R"(format = 1
[inputs]
f = { unit = "N" }
[outputs]
y = { from = "f" }
)",
     R"(test.toml:5:1: output 'y' is a plain number, but its source is in N; give it a unit, as in unit = "N", or scale it to full scale)"},
    {"an output of nothing",
     R"(format = 1
[outputs]
y = { from = "" }
)",
     R"(test.toml:3:15: the expression is empty; write a number, a name or '(' here)"},
    {"an element of no kind",
     R"(format = 1
[networks.n]
a = { mass = "1 kg" }
)",
     R"(test.toml:3:1: element 'a' of network 'n' has no 'type'; give its type, as in type = "mass")"},
    {"a mass of nothing",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = 0 }
)",
     R"(test.toml:3:29: 'a.mass' of network 'n' cannot be 0 kg; it must be at least 0.001 mg)"},
    {"a spring with one end",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a"], stiffness = "1 N/m" }
)",
     R"(test.toml:4:34: spring 's' has 1 end; give two points, the lower one first, as in between = ["cone", "stick"])"},
    {"a spring to itself",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a", "a"], stiffness = "1 N/m" }
)",
     R"(test.toml:4:34: both ends of spring 's' are one point; give two different points)"},
    {"a network of a million steps",
     R"(format = 1
[networks.n]
oversample = 1000000
a = { type = "mass", mass = "1 kg" }
)",
     R"(test.toml:3:14: 'oversample' cannot be 1e+06; give one from 1 to 64)"},
    {"a stiffness in the wrong unit",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
b = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a", "b"], stiffness = "1 N" }
)",
     R"(test.toml:5:59: 's.stiffness' of network 'n' is in N/m, but this is in N; give a quantity in N/m)"},
    {"tested delays upside down",
     R"(format = 1
[delay]
tested = ["40 ms", "0 ms"]
)",
     R"(test.toml:3:10: 'tested' of [delay] has its limits in the wrong order; write the lower limit first)"},
    {"Windows lines",
     "format = 1\r\n[nodes]\r\na = { type = \"clip\" }\r\n",
     R"(test.toml:3:1: clip 'a' lacks 'in'; write in = … (signal))"},
    {"a byte order mark",
     "\xEF\xBB\xBF" "format = 1\n[nodes]\na = { typ = \"clip\" }\n",
     R"(test.toml:3:1: node 'a' has neither 'type' nor 'use'; is 'typ' a misspelling of 'type'?)"},
};
// clang-format on

}  // namespace

TEST_CASE("bad files: a graph that is wrong says where, what, and what to do", "[graph]") {
  for (const auto& file : kBadFiles) {
    INFO(file.what);
    CHECK(test::mistakes(file.text) == file.told);
  }
}
