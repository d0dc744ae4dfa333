#include "engine/nodes/generators/generators.h"
#include "engine/nodes/generators/wavetable_kernel.h"
#include "engine/nodes/make.h"

namespace tactus {
namespace {

class Wavetable final : public Node {
 public:
  explicit Wavetable(const NodeSetup& setup)
      : sample_rate_(setup.sample_rate.value),
        table_(setup.setting("table").numbers),
        cubic_(setup.setting("interpolation").text == "cubic") {}

  void process(const NodeBlock& block) noexcept override {
    const Signal frequency = block.in[0], phase = block.in[1], level = block.in[2];
    const int count = static_cast<int>(table_.size());
    for (int i = 0; i < block.frames; ++i)
      block.out[0][i] = tactus_wavetable_step(&phasor_, table_.data(), count, cubic_, frequency[i], phase[i],
                                              level[i], sample_rate_);
  }
  void reset() noexcept override { phasor_ = {}; }

 private:
  double sample_rate_;
  std::vector<double> table_;
  bool cubic_;
  tactus_phasor phasor_{};
};

Result<std::unique_ptr<Node>> make(const NodeSetup& setup) {
  if (setup.setting("table").numbers.empty())
    return fail(Errc::BadArgument, {}, "'table' holds no number",
                "write one period, as in table = [0, 1, 0, -1]");
  return std::make_unique<Wavetable>(setup);
}

}  // namespace

const NodeType& wavetable_type() {
  static const NodeType type = {
      .name = "wavetable",
      .group = "generators",
      .summary =
          "Repeats one period given as numbers. Not band-limited: partials above half the rate fold back.",
      .equation =
          "out[n] = level table(N frac(p[n] + phase / 2 pi)) for N numbers; p[0] = 0, p[n+1] = p[n] + "
          "frequency[n] / rate",
      .source = "Moore, Elements of Computer Music, 1990; cubic: Catmull & Rom, 1974",
      .example = "buzz = { type = \"wavetable\", table = [0, 1, 0.5, -0.5, -1], frequency = \"60 Hz\" }",
      .inputs = {{.name = "frequency", .unit = "Hz", .doc = "periods a second; negative runs backwards"},
                 {.name = "phase", .unit = "rad", .doc = "added to the running phase", .fallback = 0},
                 {.name = "level", .unit = "any", .doc = "multiplies the table", .fallback = 1}},
      .outputs = {{.name = "out", .unit = "=level", .doc = "the wave"}},
      .settings = {{.name = "table",
                    .kind = Setting::Kind::Numbers,
                    .doc = "one period at even distances, at least one number"},
                   {.name = "interpolation",
                    .kind = Setting::Kind::Choice,
                    .doc = "between two numbers",
                    .choices = {"linear", "cubic"},
                    .fallback = "linear"}},
      .make = make,
  };
  return type;
}

}  // namespace tactus
