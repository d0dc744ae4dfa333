#include "engine/dsp/filters/filter_kernel.h"
#include "engine/nodes/filters/filter_node.h"
#include "engine/nodes/kernel_node.h"

namespace tactus {
namespace {

struct DifferenceNode final : KernelNode<tactus_difference_step, 1> {
  using KernelNode::KernelNode;
  std::optional<std::complex<double>> response(int, int, std::complex<double> z,
                                               std::span<const double>) const override {
    return (1.0 - 1.0 / z) * further_;
  }
};

tactus_filter_design velocity_design(const std::array<double, 1>& parameters, Hertz rate) {
  return tactus_filtered_velocity(tactus_filter_radians(parameters[0], rate.value), rate.value);
}

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
          .silencers = {{"in"}},
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
      .silencers = {{"in"}},
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

NodeType dc_blocker_type() {
  return {
      .name = "dc_blocker",
      .summary = "Removes DC, as the coupling capacitor of an audio input does.",
      .equation = "out = p (out1 + in - in1),  p = 1 / (1 + 2 pi cutoff/fs)",
      .source = "RC high-pass by backward Euler",
      .example = "{ type = \"dc_blocker\", in = \"piezo\" }",
      .inputs = {filtered_input(), cutoff_input("cutoff frequency (-3 dB if far below the sample rate)", 10)},
      .outputs = {filtered_output("out", "signal without DC")},
      .silencers = {{"in"}},
      .make = FilterNode<1, 1>::maker(of_cutoff<tactus_dc_blocker>)};
}

NodeType difference_type() {
  return {.name = "difference",
          .summary = "Rate of change from frame to frame.",
          .equation = "out = (in - in1) fs, in1 = 0 before the first frame",
          .source = "backward difference",
          .example = "{ type = \"difference\", in = \"position\" }",
          .inputs = {filtered_input("signal, usually a position")},
          .outputs = {{"out", "=in/s", "rate of change, delayed by half a frame"}},
          .silencers = {{"in"}},
          .make = make_node<DifferenceNode>};
}

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
          .silencers = {{"in"}},
          .make = FilterNode<1, 1>::maker(velocity_design)};
}

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
