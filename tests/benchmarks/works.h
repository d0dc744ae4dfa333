#pragma once

#include <fmt/format.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "engine/dsp/strings/string_loop.h"
#include "tests/benchmarks/hand_written.h"

namespace tactus::bench {

using Channels = std::vector<std::vector<double>>;

/// A piece of work that every peer does: what goes in, and the graph that says it.
struct Work {
  std::string name;
  std::string graph;  ///< file in tests/benchmarks/graphs; empty: `text`
  std::string text;   ///< a graph too long to keep
  int inputs = 1, outputs = 1;
  std::string faust = {};  ///< which of Faust's programs does the same; empty: none
  int masses = 0;          ///< of a network
  int modes = 0;           ///< of a modal bank
};

/// A chain of `masses`, each joined to the next by K = 0.25 and Z = 0.01 (kg, frames), both ends to the
/// ground, 0.0005 of damping to the ground.
inline std::string chain_text(int masses) {
  std::string text = "format = 1\n[inputs]\nx = { unit = \"N\" }\n[networks.chain]\nsolver = \"explicit\"\n";
  text += "floor = { type = \"ground\" }\n";
  const double k = 0.25 * kRate * kRate, z = 0.01 * kRate, loss = 0.0005 * kRate;
  for (int i = 0; i < masses; ++i) text += fmt::format("m{} = {{ type = \"mass\", mass = 1 }}\n", i);
  for (int i = 0; i <= masses; ++i)
    text += fmt::format(
        "s{} = {{ type = \"spring\", between = [\"{}\", \"{}\"], stiffness = {:.17g}, damping = {:.17g} }}\n",
        i, i == 0 ? "floor" : fmt::format("m{}", i - 1), i == masses ? "floor" : fmt::format("m{}", i), k, z);
  for (int i = 0; i < masses; ++i)
    text += fmt::format(
        "d{0} = {{ type = \"damper\", between = [\"floor\", \"m{0}\"], damping = {1:.17g} }}\n", i, loss);
  // In this scale a force of 1 moves a mass by 1 in a frame.
  text += fmt::format("push = {{ type = \"force\", on = \"m{}\", force = \"{:.17g} * x\" }}\n", masses / 3,
                      kRate * kRate);
  text += fmt::format("[outputs]\nout = {{ from = \"chain.m{}.position\", unit = \"m\" }}\n", 2 * masses / 3);
  return text;
}

inline Work chain(int masses) {
  return {.name = fmt::format("W3 chain of {}", masses),
          .graph = {},
          .text = chain_text(masses),
          .faust = masses == 100 ? "w3" : "",
          .masses = masses};
}

/// One node; its gains are those of the damped sines that the resonators of HandW4 ring with.
inline std::string modal_bank_text(int modes) {
  std::string gains;
  for (int k = 0; k < modes; ++k) {
    using Hand = HandW4<double>;
    const double w = 2 * std::numbers::pi * Hand::mode_hz(k, modes) / kRate;
    gains +=
        fmt::format("{:.17g}, ", Hand::mode_level(k, modes) / (Hand::mode_radius(k, modes) * std::sin(w)));
  }
  return fmt::format(
      "format = 1\n[inputs]\nx = {{}}\n[nodes.bank]\ntype = \"modal\"\nin = \"x\"\nfrequency = \"60 Hz\"\n"
      "series = \"geometric\"\nspan = 200\nmodes = {}\ndecay = \"1.5 s\"\ndecay_slope = 0.5\ngains = [{}]\n"
      "[outputs]\nout = {{ from = \"bank\" }}\n",
      modes, gains);
}

inline Work modal_bank(int modes) {
  return {.name = fmt::format("W4 modal bank of {}", modes),
          .graph = {},
          .text = modal_bank_text(modes),
          .faust = fmt::format("w4_{}", modes),
          .modes = modes};
}

/// The works that have a plain loop beside them.
inline std::vector<Work> works() {
  return {{.name = "W1 node by node", .graph = "w1.toml", .text = {}, .faust = "w1"},
          {.name = "W1 string node", .graph = "w1_string.toml", .text = {}, .faust = "w1"},
          {.name = "W2 drum", .graph = "w2.toml", .text = {}, .faust = "w2"},
          chain(100),
          modal_bank(16),
          modal_bank(128),
          modal_bank(1024),
          {.name = "W5 64 strings", .graph = "w5.toml", .text = {}, .faust = "w5"},
          {.name = "W6 8 walls", .graph = "w6.toml", .text = {}, .inputs = 8, .outputs = 8, .faust = "w6"}};
}

/// Strokes that die away, for the drum; noise; for walls positions around them, in metres.
inline Channels excitation(const Work& work, int frames) {
  std::mt19937 bits(1);
  const auto noise = [&bits] { return static_cast<double>(bits()) / 2147483648.0 - 1; };
  Channels channels(static_cast<std::size_t>(work.inputs),
                    std::vector<double>(static_cast<std::size_t>(frames)));
  for (std::size_t c = 0; c < channels.size(); ++c)
    for (int n = 0; n < frames; ++n) {
      auto& x = channels[c][static_cast<std::size_t>(n)];
      if (work.faust == "w2")
        x = noise() * (0.01 + 0.8 * std::exp(-(n % 6000) / 1200.0));
      else if (work.faust == "w6")
        x = 0.02 * std::sin(0.002 * n + static_cast<double>(c)) + 1e-6 * noise();
      else
        x = 0.1 * noise();
    }
  return channels;
}

template <class Number>
std::unique_ptr<HandWritten<Number>> make_hand_written(const Work& work) {
  if (work.graph == "w1.toml") return std::make_unique<HandW1<Number>>();
  if (work.graph == "w1_string.toml") {
    const StringDesign design{
        {.pitch_hz = 220, .gain = 0.99, .loss = 0.3}, LossFilter::OnePole, Hertz{kRate}};
    std::array<double, 6> taps;
    // The design's taps hold gain and zero of the losses, which the loop applies itself.
    for (std::size_t k = 0; k < taps.size(); ++k) taps[k] = design.taps[k] / (0.99 * 0.7);
    return std::make_unique<HandW1String<Number>>(design.newest, taps);
  }
  if (work.graph == "w2.toml") return std::make_unique<HandW2<Number>>();
  if (work.graph == "w5.toml") return std::make_unique<HandW5<Number>>();
  if (work.graph == "w6.toml") return std::make_unique<HandW6<Number>>();
  if (work.modes > 0) return std::make_unique<HandW4<Number>>(work.modes);
  return std::make_unique<HandW3<Number>>(work.masses);
}

}  // namespace tactus::bench
