#include "engine/nodes/filters/filter_node.h"

namespace tactus {
namespace {

using VelocityNode = FilterNode<1, 1>;

FilterCoefficients<1> design(const VelocityNode::Parameters& p, Hertz sample_rate) {
  const double rate = sample_rate.value;
  return FilterCoefficients<1>{tactus_filtered_velocity(tactus_filter_radians(p[0], rate), rate)};
}

}  // namespace

NodeType velocity_type() {
  return {.name = "velocity",
          .summary = "Rate of change of a signal, with less noise than `difference`.",
          .equation =
              "d = (in - in1) fs,  out = p out1 + (1-p) d,\n"
              "p^2 - 2 c p + 1 = 0 with c = 2 - cos(2 pi cutoff/fs): the low-pass is exactly -3.01 dB at the "
              "cutoff.\n"
              "in1 = 0 before the first frame",
          .source = "pole matched to the half-power frequency",
          .example = "{ type = \"velocity\", in = \"position\", cutoff = \"200 Hz\" }",
          .inputs =
              {filtered_input("signal, usually a position"),
               cutoff_input(
                   "cutoff frequency of the low-pass after the difference; at most 0.49 of the sample rate")},
          .outputs = {{"out", "=in/s", "filtered rate of change"}},
          .make = VelocityNode::maker(design)};
}

}  // namespace tactus
