#include "engine/nodes/filters/filter_node.h"

namespace tactus {
NodeType dc_blocker_type() {
  return {
      .name = "dc_blocker",
      .summary = "Removes DC, as the coupling capacitor of an audio input does.",
      .equation = "out = p (out1 + in - in1),  p = 1 / (1 + 2 pi cutoff/fs)",
      .source = "RC high-pass by backward Euler",
      .example = "{ type = \"dc_blocker\", in = \"piezo\" }",
      .inputs = {filtered_input(), cutoff_input("cutoff frequency (-3 dB if far below the sample rate)", 10)},
      .outputs = {filtered_output("out", "signal without DC")},
      .make = FilterNode<1, 1>::maker(of_cutoff<tactus_dc_blocker>)};
}

}  // namespace tactus
