#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/graphs/graph_runner.h"

using namespace tactus;

namespace {

struct BadFile {
  const char* what;
  std::string text;
  std::string expected;
};

// clang-format off
const BadFile kBadFiles[] = {
    {"empty",
     R"()",
     "test.toml:1:1 Missing 'format' format 1"},
    {"only a comment",
     R"(# nothing yet
)",
     "test.toml:1:1 Missing 'format' format 1"},
    {"the format is missing",
     R"([nodes]
a = 1
)",
     "test.toml:1:1 Missing 'format' format 1"},
    {"a format of the future",
     R"(format = 2
)",
     "test.toml:1:10 OutOfRange format 1"},
    {"a format in quotes",
     R"(format = "1"
)",
     "test.toml:1:10 OutOfRange format 1"},
    {"a name that is a number",
     R"(format = 1
name = 3
)",
     "test.toml:2:8 WrongType 'name'"},
    {"a section that is a list",
     R"(format = 1
nodes = [1, 2]
)",
     "test.toml:2:9 WrongType 'nodes' [nodes]"},
    {"a scene's section in a graph",
     R"(format = 1
[gestures]
a = { points = [[0, 0]] }
)",
     "test.toml:2:2 UnknownName 'gestures'"},
    {"an unknown section, nothing like it",
     R"(format = 1
[weather]
rain = true
)",
     "test.toml:2:2 UnknownName 'weather' 'format' 'name' 'about' 'source' 'inputs' 'controls' 'nodes' 'networks' 'worlds' 'outputs' 'delay'"},
    {"an input in quotes",
     R"(format = 1
[inputs]
x = "full scale"
)",
     R"(test.toml:3:5 WrongType 'x' [inputs] x unit "full scale")"},
    {"a unit that is a number",
     R"(format = 1
[inputs]
x = { unit = 3 }
)",
     R"(test.toml:3:14 WrongType 'unit' 'x' "m/s" "N/m" "ms" "dB" "full scale")"},
    {"an empty unit with a slash",
     R"(format = 1
[inputs]
x = { unit = "m/" }
)",
     R"(test.toml:3:14 UnknownName 'm/' "m/s" "N/m" "ms" "dB" "full scale")"},
    {"lanes in quotes",
     R"(format = 1
[inputs]
x = { lanes = "two" }
)",
     "test.toml:3:15 WrongType 'lanes' 'x' 1 1024"},
    {"too many lanes",
     R"(format = 1
[inputs]
x = { lanes = 1000000 }
)",
     "test.toml:3:15 OutOfRange 'lanes' 'x' 1e+06 1 1024"},
    {"an unknown field of an input",
     R"(format = 1
[inputs]
x = { units = "m" }
)",
     "test.toml:3:7 UnknownName 'x' 'units' 'unit'"},
    {"a control that is a list",
     R"(format = 1
[controls]
g = { value = [1, 2] }
)",
     R"(test.toml:3:15 WrongType "15 ms")"},
    {"a control that is not finite",
     R"(format = 1
[controls]
g = { value = "7000 dB" }
)",
     "test.toml:3:15 OutOfRange '7000 dB' 1e300"},
    {"a quantity that no number can hold",
     R"(format = 1
[controls]
g = { value = "1e999 m" }
)",
     "test.toml:3:15 OutOfRange '1e999 m' 1e300"},
    {"a quantity that is not a number",
     R"(format = 1
[controls]
g = { value = "nan m" }
)",
     "test.toml:3:15 OutOfRange 'nan m' 1e300"},
    {"infinity",
     R"(format = 1
[controls]
g = { value = inf }
)",
     "test.toml:3:15 OutOfRange"},
    {"not a number",
     R"(format = 1
[controls]
g = { value = -nan }
)",
     "test.toml:3:15 OutOfRange"},
    {"a range in another unit",
     R"(format = 1
[controls]
g = { value = "3 mm", range = ["0 N", "5 N"] }
)",
     R"(test.toml:3:32 UnitMismatch '0 N' 'range' "12 mm"
test.toml:3:39 UnitMismatch '5 N' 'range' "12 mm")"},
    {"a start outside its range, in its own unit",
     R"(format = 1
[controls]
g = { value = "30 mm", range = ["0 mm", "20 mm"] }
)",
     "test.toml:3:15 OutOfRange 'g' 30 0 20"},
    {"a date",
     R"(format = 1
[controls]
g = { value = 2008-06-05 }
)",
     "test.toml:3:15 WrongType"},
    {"a capital",
     R"(format = 1
[nodes]
Mix = "1"
)",
     "test.toml:3:1 Syntax 'Mix'"},
    {"a name in UTF-8",
     R"(format = 1
[nodes]
"größe" = "1"
)",
     "test.toml:3:1 Syntax 'größe'"},
    {"a letter with an accent outside of quotes",
     R"(format = 1
[controls]
gain = { value ßoss, range = [0, 1] }
)",
     "test.toml:3:16 Syntax 'ß' U+00DF"},
    {"a name in UTF-8 without quotes",
     R"(format = 1
[nodes]
größe = "1"
)",
     "test.toml:3:3 Syntax 'ö' U+00F6"},
    {"a blank that is none",
     "format = 1\n[nodes]\na\xC2\xA0= 1\n",
     "test.toml:3:2 Syntax '\xC2\xA0' U+00A0"},
    {"a name with a dot",
     R"(format = 1
[nodes]
"a.b" = "1"
)",
     "test.toml:3:1 Syntax 'a.b'"},
    {"a reserved name",
     R"(format = 1
[nodes]
system = { type = "noise" }
)",
     "test.toml:3:1 Syntax 'system'"},
    {"a name that is a unit",
     R"(format = 1
[nodes]
ms = "1"
)",
     "test.toml:3:1 Syntax 'ms'"},
    {"a control called like an input",
     R"(format = 1
[inputs]
x = {}
[controls]
x = { value = 1 }
)",
     "test.toml:5:1 Duplicate 'x' 3"},
    {"the same node twice",
     R"(format = 1
[nodes]
a = "1"
a = "2"
)",
     "test.toml:4:5 Duplicate 'a'"},
    {"two headings of one name",
     R"(format = 1
[nodes]
a = "1"
[controls]
g = { value = 1 }
[nodes]
b = "2"
)",
     "test.toml:6:1 Duplicate 'nodes'"},
    {"both type and use",
     R"(format = 1
[nodes]
a = { type = "clip", use = "part.toml", in = 1 }
)",
     R"(test.toml:3:1 Duplicate 'a' 'type' 'use'
test.toml:3:28 BadFile 'part.toml')"},
    {"a type that is a number",
     R"(format = 1
[nodes]
a = { type = 3 }
)",
     "test.toml:3:14 WrongType 'type'"},
    {"an empty type",
     R"(format = 1
[nodes]
a = { type = "" }
)",
     "test.toml:3:14 Missing 'type'"},
    {"a type in French",
     R"(format = 1
[nodes]
a = { type = "écrêteur", in = 1 }
)",
     "test.toml:3:14 UnknownName 'écrêteur' `tactus nodes`"},
    {"an unknown type, nothing like it",
     R"(format = 1
[nodes]
a = { type = "xyzzy" }
)",
     "test.toml:3:14 UnknownName 'xyzzy' `tactus nodes`"},
    {"an input that is not named",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x" }
)",
     "test.toml:5:1 Missing 'a' 'cutoff' cutoff -3.01 q 0.7071 0.49"},
    {"an unknown port",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutof = "100 Hz" }
)",
     R"(test.toml:5:1 Missing 'a' 'cutoff' cutoff -3.01 q 0.7071 0.49
test.toml:5:36 UnknownName 'a' 'cutof' 'cutoff')"},
    {"the wrong unit at a port",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutoff = "10 ms" }
)",
     "test.toml:5:46 UnitMismatch 'cutoff' 'a'"},
    {"a number without its quotes",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "low_pass", in = "x", cutoff = 100 Hz }
)",
     R"(test.toml:5:45 Syntax '100 Hz' "100 Hz")"},
    {"a negative time",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "delay", in = "x", time = "-5 ms" }
)",
     "test.toml:5:41 OutOfRange 'time' 'a' -5 0"},
    {"a delay of years",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "delay", in = "x", time = "1e9 s" }
[outputs]
y = { from = "a" }
)",
     "test.toml:5:1 OutOfRange 'a' 1000000000 350 'time' 'max'"},
    {"many voices",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "clip", in = "x", voices = 1000000000 }
)",
     "test.toml:5:41 OutOfRange 'voices' 'a' 1e+09 1 1024"},
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
     "test.toml:5:1 OutOfRange 'a' 512"},
    {"clip upside down",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "clip", in = "x", low = 1, high = -1 }
[outputs]
y = { from = "a" }
)",
     "test.toml:5:1 OutOfRange 'a' 'low' 'high' 'low'"},
    {"a step of nothing",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "quantiser", in = "x", step = 0 }
[outputs]
y = { from = "a" }
)",
     "test.toml:5:1 OutOfRange 'a' 'step' 0 0"},
    {"points that go back",
     R"(format = 1
[nodes]
a = { type = "curve", points = [["0 s", 0], ["2 s", 1], ["1 s", 0]] }
[outputs]
y = { from = "a" }
)",
     "test.toml:3:1 BadArgument 'a' 'points'"},
    {"an unknown choice",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = { type = "quantiser", in = "x", step = 0.1, rounding = "up" }
)",
     "test.toml:5:60 UnknownName 'rounding' 'a' 'up' 'nearest' 'floor'"},
    {"a seed in words",
     R"(format = 1
[nodes]
a = { type = "noise", seed = "seven" }
)",
     "test.toml:3:30 WrongType 'seed' 'a' 0 9007199254740992"},
    {"an expression that stops",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "x +"
)",
     "test.toml:5:9 Syntax '('"},
    {"an expression with a bracket too many",
     R"toml(format = 1
[inputs]
x = {}
[nodes]
a = "(x + 1))"
)toml",
     "test.toml:5:13 Syntax ')' '('"},
    {"an expression with a power",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "x ^ 2"
)",
     "test.toml:5:8 Syntax '^'"},
    {"an unknown function",
     R"toml(format = 1
[inputs]
x = {}
[nodes]
a = "sinh(x)"
)toml",
     "test.toml:5:6 Syntax 'sinh' 'sin'"},
    {"a comma for a point",
     R"(format = 1
[inputs]
x = {}
[nodes]
a = "0,5 * x"
)",
     "test.toml:5:7 Syntax ','"},
    {"an empty expression",
     R"(format = 1
[nodes]
a = ""
)",
     "test.toml:3:6 Syntax '('"},
    {"an unknown unit behind a number",
     R"(format = 1
[nodes]
a = "3 furlongs"
)",
     "test.toml:3:8 Syntax 'furlongs' 3"},
    {"a number too large",
     R"(format = 1
[nodes]
a = "1e999"
)",
     "test.toml:3:6 Syntax 1e999 1e-300 1e300"},
    {"a typing slip in a name",
     R"(format = 1
[inputs]
microphone = {}
[nodes]
a = "2 * micropone"
)",
     "test.toml:5:10 UnknownName 'micropone' 'microphone'"},
    {"a node that names only itself",
     R"(format = 1
[nodes]
a = "a"
[outputs]
y = { from = "a" }
)",
     "test.toml:3:1 Cycle a -> a 'delay'"},
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
     "test.toml:5:8 Cycle a -> b -> a 'delay'"},
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
     "test.toml:7:1 Cycle a -> a 'a' 'min'"},
    {"an output in quotes",
     R"(format = 1
[outputs]
y = "x"
)",
     R"(test.toml:3:5 WrongType 'y' [outputs] y from "node")"},
    {"an output in the wrong unit",
     R"(format = 1
[inputs]
f = { unit = "N" }
[outputs]
y = { from = "f" }
)",
     R"(test.toml:5:1 UnitMismatch 'y' unit "N")"},
    {"an output of nothing",
     R"(format = 1
[outputs]
y = { from = "" }
)",
     "test.toml:3:15 Syntax '('"},
    {"an element of no kind",
     R"(format = 1
[networks.n]
a = { mass = "1 kg" }
)",
     R"(test.toml:3:1 Missing 'a' 'n' 'type' type "mass")"},
    {"a mass of nothing",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = 0 }
)",
     "test.toml:3:29 OutOfRange 'a.mass' 'n' 0 0.001 1e+30"},
    {"a spring with one end",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a"], stiffness = "1 N/m" }
)",
     R"(test.toml:4:34 WrongType 's' 1 between "cone" "stick")"},
    {"a spring to itself",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a", "a"], stiffness = "1 N/m" }
)",
     "test.toml:4:34 Duplicate 's'"},
    {"a network of a million steps",
     R"(format = 1
[networks.n]
oversample = 1000000
a = { type = "mass", mass = "1 kg" }
)",
     "test.toml:3:14 OutOfRange 'oversample' 1e+06 1 64"},
    {"a stiffness in the wrong unit",
     R"(format = 1
[networks.n]
a = { type = "mass", mass = "1 kg" }
b = { type = "mass", mass = "1 kg" }
s = { type = "spring", between = ["a", "b"], stiffness = "1 N" }
)",
     "test.toml:5:59 UnitMismatch 's.stiffness' 'n'"},
    {"tested delays upside down",
     R"(format = 1
[delay]
tested = ["40 ms", "0 ms"]
)",
     "test.toml:3:10 OutOfRange 'tested' [delay]"},
    {"Windows lines",
     "format = 1\r\n[nodes]\r\na = { type = \"clip\" }\r\n",
     "test.toml:3:1 Missing 'a' 'in' in"},
    {"a byte order mark",
     "\xEF\xBB\xBF" "format = 1\n[nodes]\na = { typ = \"clip\" }\n",
     "test.toml:3:1 Missing 'a' 'type' 'use' 'typ' 'type'"},
};
// clang-format on

}  // namespace

TEST_CASE("bad files: a graph that is wrong says where, what, and what to do", "[graph]") {
  for (const auto& file : kBadFiles) {
    INFO(file.what);
    CHECK(test::errors_of(file.text) == file.expected);
  }
}
