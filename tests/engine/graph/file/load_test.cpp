#include "engine/graph/file/load.h"

#include <catch2/catch.hpp>

#include "tests/support/error_summary.h"
#include "tests/support/parse_graph.h"

using namespace tactus;
using tactus::test::parse_graph;

namespace {

std::string errors_of(std::string_view text) {
  const auto spec = parse_graph(text, "drum.toml");
  return test::summary(spec);
}

template <class Entries>
std::string names(const Entries& entries) {
  std::string text;
  for (const auto& entry : entries) text += entry.name + " ";
  return text;
}

}  // namespace

TEST_CASE("graph: the drum of the manual becomes plain data in the order of the file", "[graph]") {
  const auto read = parse_graph(R"(format = 1
name   = "haptic drum"
about  = "Throws a pulse at the stick each time it lands."
source = "Berdahl, Steiner, Oldham, NIME 2008, section 7.1"
[inputs]
microphone = { unit = "full scale" }
[controls]
strength    = { value = 0.6, range = [0, 1] }
sensitivity = { value = "-34 dB", range = ["-60 dB", "0 dB"] }
[nodes]
pulse = { type = "decay", trigger = "hit", time = "12 ms" }
hit   = { type = "onset", in = "microphone", threshold = "sensitivity", hold = "15 ms" }
sum   = "x + 2"
half  = 0.5
[outputs]
woofer = { from = "strength * pulse" }
hit    = { from = "microphone", kind = "audio" }
[delay]
tested = ["0 ms", "40 ms"]
)",
                                "drum.toml");
  REQUIRE(read);
  const auto& spec = **read;
  CHECK(spec.file.text() == "drum.toml");
  CHECK(spec.name == "haptic drum");
  CHECK(spec.source == "Berdahl, Steiner, Oldham, NIME 2008, section 7.1");
  CHECK(names(spec.inputs) == "microphone ");
  CHECK(names(spec.controls) == "strength sensitivity ");
  CHECK(names(spec.nodes) == "pulse hit sum half ");
  CHECK(names(spec.outputs) == "woofer hit ");
  const auto& pulse = spec.nodes[0];
  CHECK(pulse.type == "decay");
  CHECK(pulse.at.text() == "drum.toml:11:1");
  CHECK(pulse.type_at.text() == "drum.toml:11:18");
  REQUIRE(pulse.fields.size() == 2);  // without `type`
  CHECK(pulse.fields[0].key == "trigger");
  CHECK(*spec.nodes[2].value->text() == "x + 2");
  CHECK(*spec.nodes[3].value->number() == 0.5);
  REQUIRE(spec.tested);
  CHECK(spec.tested->low == 0.0);
  CHECK(spec.tested->high == Approx(0.040));
}

TEST_CASE("graph: a table of its own and a table in a line are the same", "[graph]") {
  const auto read = parse_graph(
      "format = 1\n[nodes.a]\ntype = \"gain\"\n[nodes]\nb = { type = \"gain\" }\n[nodes.c]\n"
      "type = \"gain\"\n",
      "a.toml");
  REQUIRE(read);
  CHECK(names((*read)->nodes) == "a b c ");
}

TEST_CASE("graph: a network's tables are its elements, the rest its options", "[graph]") {
  const auto read = parse_graph(R"(format = 1
[networks.drum]
oversample = 2
stick = { type = "mass", mass = "20 g" }
[networks.drum.head]
type = "contact"
between = ["stick", "ground"]
)",
                                "a.toml");
  REQUIRE(read);
  const auto& drum = (*read)->networks.at(0);
  CHECK(drum.name == "drum");
  REQUIRE(drum.fields.size() == 1);
  CHECK(drum.fields[0].key == "oversample");
  CHECK(names(drum.elements) == "stick head ");
  CHECK(drum.elements[1].type == "contact");
  CHECK(drum.elements[1].fields.size() == 1);
}

TEST_CASE("graph: all errors come in one go, in file order", "[graph]") {
  CHECK(errors_of(R"(name = 5
[nods]
[nodes]
Hit = { type = "onset" }
ms = 1
min = 2
x = { typ = "gain" }
y = { in = "x" }
z = { type = "gain", use = "gain.toml" }
w = { type = 3 }
v = { type = "" }
mic = 1
[inputs]
mic = 3
[outputs]
mic = "mic"
[networks.n]
a = { mass = 3 }
[controls]
a = { value = 1 }
[gestures]
)") ==
        R"(drum.toml:1:1 Missing 'format' format 1
drum.toml:1:8 WrongType 'name'
drum.toml:2:2 UnknownName 'nods' 'nodes'
drum.toml:4:1 Syntax 'Hit'
drum.toml:5:1 Syntax 'ms'
drum.toml:6:1 Syntax 'min'
drum.toml:7:1 Missing 'x' 'type' 'use' 'typ' 'type'
drum.toml:8:1 Missing 'y' 'type' 'use' type "low_pass" use "string.toml"
drum.toml:9:1 Duplicate 'z' 'type' 'use'
drum.toml:9:28 BadFile 'gain.toml'
drum.toml:10:14 WrongType 'type'
drum.toml:11:14 Missing 'type'
drum.toml:14:1 Duplicate 'mic' 12
drum.toml:14:7 WrongType 'mic' [inputs] mic unit "full scale"
drum.toml:16:7 WrongType 'mic' [outputs] mic from "node"
drum.toml:18:1 Missing 'a' 'n' 'type' type "mass"
drum.toml:21:2 UnknownName 'gestures')");
}

TEST_CASE("graph: sections must be tables, and the format must be known", "[graph]") {
  CHECK(errors_of("format = 2\nnodes = 3\ninputs = \"mic\"\nxyz = 1") ==
        R"(drum.toml:1:10 OutOfRange format 1
drum.toml:2:9 WrongType 'nodes' [nodes]
drum.toml:3:10 WrongType 'inputs' [inputs]
drum.toml:4:1 UnknownName 'xyz' 'format' 'name' 'about' 'source' 'inputs' 'controls' 'nodes' 'networks' 'worlds' 'outputs' 'delay')");
}

TEST_CASE("graph: one letter may name a node although it is a unit, and an output may be called like a node",
          "[graph]") {
  CHECK(errors_of("format = 1\n[nodes]\ns = 1\ng = \"s\"\nm_2 = 3\n[outputs]\ns = { from = \"s\" }\n") == "");
}

TEST_CASE("graph: a syntax error comes alone", "[graph]") {
  CHECK(errors_of("[nods]\nx = 12 ms") == R"(drum.toml:2:5 Syntax '12 ms' "12 ms")");
}
