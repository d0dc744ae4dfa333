#include "engine/nodes/filters/filter_node.h"

namespace tactus {
namespace {

using BiquadNode = FilterNode<2, 2>;

/// A node whose coefficients are those of one of the cookbook's designs.
template <tactus_filter_design (*Shape)(double radians, double q)>
NodeType biquad(const char* name, const char* summary, const char* transfer, const char* example,
                InputPort corner, InputPort q) {
  return {.name = name,
          .summary = summary,
          .equation = transfer,
          .source = "R. Bristow-Johnson, Cookbook formulae for audio EQ biquad filter coefficients",
          .example = example,
          .inputs = {filtered_input(), std::move(corner), std::move(q)},
          .outputs = {filtered_output("out", "filtered")},
          .make = BiquadNode::maker([](const BiquadNode::Parameters& p, Hertz sample_rate) {
            return Shape(tactus_filter_radians(p[0], sample_rate.value), tactus_filter_q(p[1]));
          })};
}

InputPort resonant_cutoff() {
  return cutoff_input(
      "cutoff frequency, where the gain is q (-3.01 dB for q = 0.7071); at most 0.49 of the sample rate");
}
InputPort q_input(std::string doc, double fallback) {
  return {"q", "", std::move(doc), fallback, 0.01, 1000};
}
InputPort resonance() {
  return q_input("gain at the cutoff frequency; 0.7071: maximally flat (Butterworth)", 0.7071067811865476);
}

}  // namespace

NodeType low_pass_type() {
  return biquad<tactus_low_pass>("low_pass", "A resonant low-pass, 12 dB per octave.",
                                 "H(s) = 1 / (s^2 + s/q + 1), bilinear, s = j at the cutoff",
                                 "{ type = \"low_pass\", in = \"string\", cutoff = \"3 kHz\" }",
                                 resonant_cutoff(), resonance());
}

NodeType high_pass_type() {
  return biquad<tactus_high_pass>("high_pass", "A resonant high-pass, 12 dB per octave.",
                                  "H(s) = s^2 / (s^2 + s/q + 1), bilinear, s = j at the cutoff",
                                  "{ type = \"high_pass\", in = \"string\", cutoff = \"3 kHz\" }",
                                  resonant_cutoff(), resonance());
}

NodeType band_pass_type() {
  return biquad<tactus_band_pass>(
      "band_pass", "A band-pass with gain 1 at its centre frequency and slopes of 6 dB per octave.",
      "H(s) = (s/q) / (s^2 + s/q + 1), bilinear, s = j at the frequency",
      "{ type = \"band_pass\", in = \"piezo\", frequency = \"3 kHz\", q = 10 }",
      {"frequency", "Hz", "centre frequency, where the gain is 1; at most 0.49 of the sample rate", {}, 0},
      q_input("frequency / bandwidth", 1));
}

}  // namespace tactus
