#include "engine/nodes/fir.h"

#include "engine/dsp/fir.h"
#include "engine/nodes/filter_ports.h"
#include "engine/nodes/group_steps.h"

namespace tactus {
namespace {

class FirNode : public Node {
 public:
  explicit FirNode(const NodeSetup& setup)
      : sample_rate_(setup.sample_rate), fir_(setup.setting("taps").numbers) {}

  void process(const NodeBlock& block) noexcept override {
    InARow in_a_row;
    fir_.run(in_a_row(block.in[0], block.frames), block.out[0], block.frames);
  }

  void reset() noexcept override { fir_.reset(); }
  void adopt(Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const FirNode*>(&before)) fir_.adopt(other->fir_);
  }

  std::optional<std::complex<double>> response(int, int, Hertz frequency,
                                               std::span<const double>) const override {
    return fir_.response(radians_at(frequency, sample_rate_));
  }

 private:
  Hertz sample_rate_;
  Fir fir_;
};

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  if (setup.setting("taps").numbers.empty())
    return fail(Errc::OutOfRange, {}, "a filter without taps is silent",
                "give at least one number in 'taps'");
  return std::make_unique<FirNode>(setup);
}

}  // namespace

const NodeType& fir_type() {
  static const NodeType type{.name = "fir",
                             .group = "filters",
                             .summary = "A filter of any shape by its impulse response, one sample a tap.",
                             .equation = "out[n] = sum over k of taps[k] in[n-k]",
                             .source = "direct convolution",
                             .example = "{ type = \"fir\", in = \"piezo\", taps = [0.25, 0.5, 0.25] }",
                             .inputs = {filtered_input()},
                             .outputs = {filtered_output("out", "filtered")},
                             .settings = {{.name = "taps",
                                           .kind = Setting::Kind::Numbers,
                                           .doc = "impulse response at the sample rate; plain numbers",
                                           .choices = {},
                                           .fallback = {}}},
                             .make = make,
                             .range = {}};
  return type;
}

}  // namespace tactus
