#include "engine/nodes/filters/band_pass.h"

#include "engine/dsp/filters/biquad_design.h"
#include "engine/nodes/filters/filter_node.h"
#include "engine/nodes/filters/filter_ports.h"

namespace tactus {
namespace {

using BiquadNode = FilterNode<2, 2>;

FilterCoefficients<2> design(const BiquadNode::Parameters& p, Hertz sample_rate) {
  return BiquadDesign{clamped_radians(p[0], sample_rate), clamped_q(p[1])}.band_pass();
}

}  // namespace

const NodeType& band_pass_type() {
  static const NodeType type{
      .name = "band_pass",
      .group = "filters",
      .summary = "A band-pass with gain 1 at its centre, 6 dB an octave to both sides.",
      .equation = "H(s) = (s/q) / (s^2 + s/q + 1), bilinear, s = j at the frequency",
      .source = "R. Bristow-Johnson, Cookbook formulae for audio EQ biquad filter coefficients",
      .example = "{ type = \"band_pass\", in = \"piezo\", frequency = \"3 kHz\", q = 10 }",
      .inputs = {filtered_input(),
                 {.name = "frequency",
                  .unit = "Hz",
                  .doc = "gain 1 here; at most 0.49 of the sample rate",
                  .fallback = std::nullopt,
                  .low = 0},
                 q_input("frequency / bandwidth", 1)},
      .outputs = {filtered_output("out", "filtered")},
      .settings = {},
      .make = BiquadNode::maker(design),
      .range = {}};
  return type;
}

}  // namespace tactus
