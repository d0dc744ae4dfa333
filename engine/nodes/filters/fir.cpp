#include "engine/dsp/filters/fir.h"

#include "engine/dsp/delays/resample.h"
#include "engine/nodes/declare.h"
#include "engine/nodes/process.h"

namespace tactus {
namespace {

class FirNode : public Node {
 public:
  explicit FirNode(std::vector<double> taps) : fir_(std::move(taps)) {}

  void process(const NodeBlock& block) noexcept override {
    Contiguous in;
    fir_.run(in(block.in[0], block.frames), block.out[0], block.frames);
  }

  void reset() noexcept override { fir_.reset(); }
  void copy(const Node& other) noexcept override { assign(*this, other); }
  void adopt(const Node& before) noexcept override {
    if (const auto* other = dynamic_cast<const FirNode*>(&before)) fir_.adopt(other->fir_);
  }

  std::optional<std::complex<double>> response(int, int, std::complex<double> z,
                                               std::span<const double>) const override {
    return fir_.response(1.0 / z);
  }

 private:
  Fir fir_;
};

Result<std::unique_ptr<Node>> make_fir(const NodeSetup& setup) {
  const auto& taps = setup.setting("taps").numbers;
  if (taps.empty())
    return fail(Errc::OutOfRange, {}, "a filter without taps is silent",
                "give at least one number in 'taps'");
  const auto& rate = setup.setting("rate");
  const Hertz from = rate.given ? Hertz{rate.number} : setup.sample_rate;
  const auto fits = setup.take_memory(length_at_rate(taps.size(), from, setup.sample_rate));
  if (!fits) return tl::unexpected(fits.error());
  return std::make_unique<FirNode>(taps_at_rate(taps, from, setup.sample_rate));
}

}  // namespace

NodeType fir_type() {
  return {.name = "fir",
          .summary = "An FIR filter, given by its impulse response.",
          .equation = "out[n] = sum over k of taps[k] in[n-k]",
          .source = "direct convolution; another rate: J. O. Smith, Digital Audio Resampling Home Page, 2002",
          .example = "{ type = \"fir\", in = \"piezo\", rate = \"48 kHz\", taps = [0.25, 0.5, 0.25] }",
          .inputs = {filtered_input()},
          .outputs = {filtered_output("out", "filtered")},
          .silencers = {{"in"}},
          .settings = {required({"taps", Setting::Kind::Numbers, "impulse response, one number per sample"}),
                       within(1000, 1e6,
                              {"rate",
                               Setting::Kind::Quantity,
                               "sample rate of the taps; they are resampled if the engine runs at "
                               "another rate; default: the engine's",
                               {"Hz"}})},
          .make = make_fir};
}

}  // namespace tactus
