#include "engine/rig/rig_inputs.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/support/allocation_count.h"

using namespace tactus;

namespace {

/// Gives out what comes in.
class Wire final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override {
    channels_ = format.in_channels;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < channels_; ++c) std::copy_n(io.in[c], io.frames, io.out[c]);
  }

 private:
  int channels_ = 0;
};

using Signals = std::vector<std::vector<double>>;

Signals run(const Signals& in, const std::vector<double>& scales, int padding, int block) {
  Wire wire;
  RigInputs inputs{wire, scales, padding};
  const int channels = static_cast<int>(in.size()), frames = static_cast<int>(in[0].size());
  REQUIRE(inputs.prepare({48_kHz, channels, channels, block}));
  Signals out = in;
  for (int done = 0; done < frames;) {
    const int now = std::min(block, frames - done);
    std::vector<const double*> from;
    std::vector<double*> to;
    for (auto& channel : in) from.push_back(channel.data() + done);
    for (auto& channel : out) to.push_back(channel.data() + done);
    const auto before = test::allocation_count();
    inputs.process({from.data(), to.data(), now});
    REQUIRE(test::allocation_count() == before);
    done += now;
  }
  return out;
}

}  // namespace

TEST_CASE("rig_inputs: value[n] = scale * sample[n - padding], whatever the block", "[rig]") {
  const int padding = GENERATE(0, 1, 7, 64, 300);
  const int block = GENERATE(1, 5, 64, 200);
  Signals in(2, std::vector<double>(200));
  for (int f = 0; f < 200; ++f) {
    in[0][static_cast<std::size_t>(f)] = 0.001 * f + 0.1;
    in[1][static_cast<std::size_t>(f)] = -0.002 * f;
  }
  const auto out = run(in, {20.0}, padding, block);
  for (int f = 0; f < 200; ++f) {
    const auto n = static_cast<std::size_t>(f);
    const auto past = static_cast<std::size_t>(f - padding);
    CHECK(out[0][n] == (f < padding ? 0.0 : 20.0 * in[0][past]));
    CHECK(out[1][n] == (f < padding ? 0.0 : in[1][past]));
  }
}

TEST_CASE("rig_inputs: are left out where samples would come through as they are", "[rig]") {
  CHECK_FALSE(RigInputs::needed({}, 0));
  CHECK_FALSE(RigInputs::needed({1.0, 1.0}, 0));
  CHECK(RigInputs::needed({1.0, 2.0}, 0));
  CHECK(RigInputs::needed({}, 1));
}
