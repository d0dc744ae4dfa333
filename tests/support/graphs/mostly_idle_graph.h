#pragma once

#include <string>

namespace tactus::test {

/// Twelve nodes from an input to a drive.
inline std::string twelve_nodes() {
  return R"(format = 1
name = "twelve"
[inputs]
x = {}
[controls]
gain = { value = 0.5, range = [0, 1] }
[nodes]
n1  = { type = "dc_blocker", in = "x" }
n2  = { type = "low_pass", in = "n1", cutoff = "4 kHz" }
n3  = { type = "high_pass", in = "n2", cutoff = "20 Hz" }
n4  = { type = "band_pass", in = "n3", frequency = "300 Hz", q = 2 }
n5  = { type = "delay", in = "n4", time = "3 ms" }
n6  = { type = "one_pole", in = "n5", cutoff = "1 kHz" }
n7  = { type = "clip", in = "n6", low = -0.5, high = 0.5 }
n8  = { type = "envelope", in = "n7" }
n9  = { type = "sine", frequency = "80 Hz" }
n10 = "n8 * n9"
n11 = "gain * n10"
n12 = { type = "low_pass", in = "n11", cutoff = "500 Hz" }
)";
}

inline std::string twelve_alone() { return twelve_nodes() + "[outputs]\ny = { from = \"n12\" }\n"; }

/// The same among `nodes` in all, the others of no use: a fifth each of nodes in chains that reach no output,
/// of branches that the output takes times zero, of constants, of loops that nobody hears, and of nodes that
/// only follow a control which is read nowhere else.
inline std::string twelve_among(int nodes) {
  std::string text = twelve_nodes(), zeros, controls;
  const auto add = [&text](const std::string& line) { text += line + "\n"; };
  for (int i = 0; i < nodes - 12; ++i) {
    const auto number = std::to_string(i), name = "idle" + number;
    const auto before = i < 5 ? std::string{"x"} : "idle" + std::to_string(i - 5);
    switch (i % 5) {
      case 0:
        add(name + " = { type = \"low_pass\", in = \"" + before + "\", cutoff = \"1 kHz\" }");
        break;
      case 1:
        add(name + " = { type = \"sine\", frequency = \"" + std::to_string(20 + i) + " Hz\" }");
        if (i < 2000) zeros += " + 0 * " + name;
        break;
      case 2:
        add(name + " = { type = \"clip\", in = " + number + ", high = 100 }");
        break;
      case 3:
        add(name + " = { type = \"delay\", in = \"x + 0.5 * " + name + "\", time = \"5 ms\" }");
        break;
      default:
        controls += "c" + number + " = { value = 0.5, range = [0, 1] }\n";
        add(name + " = \"x * c" + number + "\"");
        break;
    }
  }
  text.insert(text.find("[nodes]"), controls);
  return text + "[outputs]\ny = { from = \"n12" + zeros + "\" }\n";
}

}  // namespace tactus::test
