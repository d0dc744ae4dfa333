#include "engine/nodes/filters/filter_node.h"

namespace tactus {
NodeType one_pole_type() {
  return {
      .name = "one_pole",
      .summary = "A low-pass and its complementary high-pass, 6 dB per octave.",
      .equation =
          "low = (1-p)/2 (in + in1) + p low1,  high = in - low,\n"
          "p = (1 - tan(pi cutoff/fs)) / (1 + tan(pi cutoff/fs)): both are exactly -3.01 dB at the cutoff.\n"
          "matched: low = (1-p) in + p low1,  p^2 - 2 c p + 1 = 0 with c = 2 - cos(2 pi cutoff/fs): low is "
          "exactly -3.01 dB there",
      .source = "Oppenheim & Schafer, Discrete-Time Signal Processing, 7.1.2 (bilinear transform, prewarped)",
      .example = "{ type = \"one_pole\", in = \"hand\", cutoff = \"80 Hz\" }",
      .inputs = {filtered_input(),
                 cutoff_input("cutoff frequency (-3.01 dB); at most 0.49 of the sample rate")},
      .outputs = {filtered_output("low", "low-pass output"),
                  filtered_output("high", "high-pass output: in - low")},
      .settings = {choice(
          "form",
          "matched: half a frame less delay, but a small gain at half the sample rate; for feedback loops",
          {"bilinear", "matched"}, "bilinear")},
      .make = [](const NodeSetup& setup) -> Result<std::unique_ptr<Node>> {
        const bool matched = setup.setting("form").text == "matched";
        return FilterNode<1, 1>::maker(matched ? of_cutoff<tactus_matched_one_pole>
                                               : of_cutoff<tactus_one_pole>)(setup);
      },
      .skips_unused_outputs = true};
}

}  // namespace tactus
