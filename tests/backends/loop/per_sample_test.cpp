#include <atomic>
#include <catch2/catch.hpp>
#include <vector>

#include "backends/loop/loop.h"
#include "tests/support/wait_until.h"

using namespace tactus;

namespace {

/// Plays a number for each frame, and compares what comes in with what was played in the frame before.
class CountingUp final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    if (io.frames != 1) wrong = true;
    if (io.in[0][0] != before_) wrong = true;
    before_ = (frames % 1000) / 32768.0;  // a step of 16 bits
    io.out[0][0] = before_;
    ++frames;
  }
  std::atomic<int> frames{0};
  std::atomic<bool> wrong{false};

 private:
  double before_ = 0.0;
};

StreamRequest request_at(double rate_hz) {
  StreamRequest request;
  request.device = "loop:per_sample";
  request.in_channels = request.out_channels = 1;
  request.sample_rate = Hertz{rate_hz};
  request.block_frames = 64;
  return request;
}

}  // namespace

TEST_CASE("per-sample card: each frame has what was played one frame before it", "[loop]") {
  LoopBackend backend;
  CountingUp counting;
  Guarded guarded{counting, {{DriveGuard::Kind::Audio, {.ceiling = 1.0}, {false, false}}}};
  const auto stream = backend.open(request_at(GENERATE(1e3, 3e3, 10e3)), guarded);
  REQUIRE(stream);
  CHECK((*stream)->granted().block_frames == 1);
  REQUIRE((*stream)->start());
  // Where frames are skipped, the one before is played on.
  REQUIRE(test::wait_until([&] { return counting.frames >= 500; }, std::chrono::seconds{20}));
  REQUIRE((*stream)->stop());
  CHECK_FALSE(counting.wrong);
  const auto& loop = dynamic_cast<PacedStream&>(**stream).loop();
  CHECK(loop.lateness().total() == loop.frames());
  CHECK((*stream)->health().lost_frames <= loop.skipped());
  CHECK((*stream)->health().longest_block == 1);
}

TEST_CASE("per-sample card: other rates are errors that list those there are", "[loop]") {
  LoopBackend backend;
  CountingUp counting;
  Guarded guarded{counting, {{DriveGuard::Kind::Audio, {}}}};
  for (const double rate : {500.0, 1500.0, 48e3}) {
    const auto stream = backend.open(request_at(rate), guarded);
    REQUIRE_FALSE(stream);
    CHECK(stream.error().code == Errc::BadArgument);
    CHECK(stream.error().remedy.find("1000, 2000, 3000") != std::string::npos);
  }
}

TEST_CASE("per-sample card: a core that is not there is an error", "[loop]") {
  LoopBackend backend;
  REQUIRE(backend.add("loop:per_sample,core=1023"));
  CountingUp counting;
  Guarded guarded{counting, {{DriveGuard::Kind::Audio, {}}}};
  auto request = request_at(1e3);
  request.device = "loop:per_sample,core=1023";
  const auto stream = backend.open(request, guarded);
  REQUIRE_FALSE(stream);
  CHECK(stream.error().code == Errc::OutOfRange);
}
