#pragma once

#include <cmath>
#include <string>

namespace tactus::test {

/// Plucked or bowed strings side by side, each with a pitch and a brightness of its own: low-pass, tuned
/// loop, clip, summed. `loop` is the string as one node, or a delay and its losses node by node.
inline std::string voices_graph(int voices, bool one_node, const std::string& rest = "") {
  const auto number = [](double x) { return std::to_string(x); };
  const auto count = "voices = " + std::to_string(voices);
  const int last = voices - 1;
  const double highest = 82.4 * std::pow(2.0, 3.0 * last / 64);
  std::string loop;
  if (one_node)
    loop = "s = { type = \"string\", in = \"u\", loss_filter = \"one_pole\", loss = 0.3, gain = 0.99, " +
           count + ", pitch = { from = \"82.4 Hz\", to = \"" + number(highest) +
           " Hz\", curve = \"exponential\" } }\n";
  else
    loop = "d = { type = \"delay\", in = \"s\", " + count + ", time = { from = " + number(1 / 82.4) +
           ", to = " + number(1 / highest) +
           ", curve = \"exponential\" } }\n"
           "l = { type = \"one_pole\", in = \"d\", cutoff = \"7547 Hz\" }\n"
           "s = \"u + 0.99 * l\"\n";
  return "format = 1\n[inputs]\nx = {}\n[nodes]\n"
         "u = { type = \"low_pass\", in = \"x\", " +
         count + ", cutoff = { from = \"1500 Hz\", to = \"" + std::to_string(1500 + 50 * last) +
         " Hz\" } }\n" + loop +
         "y = { type = \"clip\", in = \"s\", low = -0.5, high = 0.5 }\n"
         "sum = { type = \"mix\", in = \"y\" }\n" +
         rest + "[outputs]\nout = { from = \"sum / 8\" }\n";
}

}  // namespace tactus::test
