#include "engine/nodes/filters/high_pass.h"

#include "engine/dsp/filters/biquad_design.h"
#include "engine/nodes/filters/filter_node.h"
#include "engine/nodes/filters/filter_ports.h"

namespace tactus {
namespace {

using BiquadNode = FilterNode<2, 2>;

FilterCoefficients<2> design(const BiquadNode::Parameters& p, Hertz sample_rate) {
  return BiquadDesign{clamped_radians(p[0], sample_rate), clamped_q(p[1])}.high_pass();
}

}  // namespace

const NodeType& high_pass_type() {
  static const NodeType type{
      .name = "high_pass",
      .group = "filters",
      .summary = "A resonant high-pass, 12 dB an octave.",
      .equation = "H(s) = s^2 / (s^2 + s/q + 1), bilinear, s = j at the cutoff",
      .source = "R. Bristow-Johnson, Cookbook formulae for audio EQ biquad filter coefficients",
      .example = "{ type = \"high_pass\", in = \"string\", cutoff = \"3 kHz\" }",
      .inputs = {filtered_input(),
                 cutoff_input("gain q here (-3.01 dB for q = 0.7071); at most 0.49 of the sample rate"),
                 q_input("gain at the cutoff; 0.7071 is flattest (Butterworth)", 0.7071067811865476)},
      .outputs = {filtered_output("out", "filtered")},
      .settings = {},
      .make = BiquadNode::maker(design),
      .range = {}};
  return type;
}

}  // namespace tactus
