#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "engine/guard/guarded.h"
#include "tests/backends/every_backend.h"
#include "tests/support/error_summary.h"
#include "tests/support/wait_until.h"

// The contract of backends/backend.h, for every backend: `tactus_tests` has those that need no hardware,
// `tactus_card_tests` all that were built.

using namespace tactus;
using test::Subject;

namespace {

constexpr int kFrames = 500;
constexpr Hertz kRate = 48_kHz;

/// Writes down what is asked of it.
class Witness final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& granted) override {
    ++prepared;
    format = granted;
    return refuse ? fail(Errc::BadArgument, "", "BadArgument") : Status{};
  }
  void process(const BlockIo& io) noexcept override {
    if (prepared == 0) ++before_prepare;
    if (io.frames < 1 || io.frames > format.max_frames) ++wrong_length;
    for (int c = 0; c < format.in_channels; ++c)
      for (int n = 0; n < io.frames; ++n) not_finite += std::isfinite(io.in[c][n]) ? 0 : 1;
    for (int c = 0; c < format.out_channels; ++c)
      for (int n = 0; n < io.frames; ++n) io.out[c][n] = 0.01 * (c + 1);
    frames += io.frames;
    ++blocks;
  }

  StreamFormat format;
  bool refuse = false;
  int prepared = 0, before_prepare = 0, wrong_length = 0, not_finite = 0, blocks = 0;
  std::atomic<int> frames = 0;
};

/// Runs `check(subject, witness, guarded)` on a fresh one of each backend.
template <class Check>
void for_every_backend(Check check) {
  for (const auto& make : test::every_backend()) {
    auto subject = make();
    if (!subject) continue;
    INFO(subject->backend->name());
    Witness witness;
    Guarded guarded{witness, {}};
    check(*subject, witness, guarded);
  }
}

/// Plays at least `kFrames` frames, and stops.
void play(Stream& stream, const Witness& witness) {
  const int before = witness.frames;
  REQUIRE(stream.start());
  CHECK(stream.state() == StreamState::Running);
  REQUIRE(test::wait_until([&] { return witness.frames - before >= kFrames; }));
  REQUIRE(stream.stop());
}

Error refusal(const Subject& subject, const StreamRequest& request) {
  Witness witness;
  Guarded guarded{witness, {}};
  const auto stream = subject.backend->open(request, guarded);
  CHECK(witness.prepared == 0);
  REQUIRE_FALSE(stream);
  return stream.error();
}

}  // namespace

TEST_CASE("backends: devices have stable names that begin with the backend's, and one is the default",
          "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded&) {
    const auto devices = subject.backend->devices();
    REQUIRE(devices);
    REQUIRE_FALSE(devices->empty());
    int defaults = 0;
    for (const auto& device : *devices) {
      CHECK(device.id.starts_with(subject.backend->name() + ":"));
      CHECK_FALSE(device.name.empty());
      CHECK(device.in_channels + device.out_channels > 0);
      CHECK(device.default_rate > Hertz{0});
      if (!device.sample_rates.empty())
        CHECK(std::count(device.sample_rates.begin(), device.sample_rates.end(), device.default_rate) == 1);
      if (device.is_default) {
        ++defaults;
        CHECK(device.in_channels >= subject.request.in_channels);
        CHECK(device.out_channels >= subject.request.out_channels);
      }
    }
    CHECK(defaults == 1);
    CHECK(subject.backend->devices()->front().id == devices->front().id);
  });
}

TEST_CASE("backends: what is granted fits what was asked, and the processor hears it once", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    const auto device = subject.backend->devices()->front();
    auto request = subject.request;
    request.device = device.id;
    request.sample_rate = device.default_rate;
    request.block_frames = 32;
    const auto stream = subject.backend->open(request, guarded);
    REQUIRE(stream);
    const auto& granted = (*stream)->granted();
    CHECK(granted.device == device.id);
    CHECK(granted.format.sample_rate == device.default_rate);
    CHECK(granted.format.in_channels == request.in_channels);
    CHECK(granted.format.out_channels == request.out_channels);
    CHECK(granted.block_frames <= granted.format.max_frames);
    CHECK(witness.prepared == 1);
    CHECK(witness.format.sample_rate == granted.format.sample_rate);
    CHECK(witness.format.in_channels == granted.format.in_channels);
    CHECK(witness.format.out_channels == granted.format.out_channels);
    CHECK(witness.format.max_frames == granted.format.max_frames);
    REQUIRE((*stream)->start());
    CHECK(witness.prepared == 1);
  });
}

TEST_CASE("backends: what is left out is chosen: the default device, its rate, some block", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded& guarded) {
    const auto stream = subject.backend->open(subject.request, guarded);
    REQUIRE(stream);
    const auto& asked = subject.request.device;
    CHECK((*stream)->granted().device == (asked.empty() ? subject.backend->devices()->front().id : asked));
    CHECK((*stream)->granted().format.sample_rate == kRate);
    CHECK((*stream)->granted().format.max_frames >= 1);
  });
}

TEST_CASE("backends: every frame of a stream is in a block that fits, and its states follow each other",
          "[backends]") {
  for (const int block : {1, 7, 64, 499, 500, 4096}) {
    for_every_backend([&](Subject& subject, Witness& witness, Guarded& guarded) {
      CAPTURE(block);
      auto request = subject.request;
      request.block_frames = block;
      const auto stream = subject.backend->open(request, guarded);
      REQUIRE(stream);
      CHECK((*stream)->state() == StreamState::Stopped);
      CHECK((*stream)->health() == Health{});
      CHECK(witness.blocks == 0);
      play(**stream, witness);
      CHECK((*stream)->state() == StreamState::Stopped);
      CHECK(witness.before_prepare == 0);
      CHECK(witness.wrong_length == 0);
      CHECK(witness.not_finite == 0);
      CHECK(guarded.frame() == witness.frames);
    });
  }
}

TEST_CASE("backends: health counts what was played", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    auto request = subject.request;
    request.block_frames = 64;
    const auto stream = subject.backend->open(request, guarded);
    REQUIRE(stream);
    play(**stream, witness);
    const auto health = (*stream)->health();
    CHECK(health.frames == witness.frames);
    CHECK(health.bad_input == 0);
    CHECK(health.peak_load >= health.mean_load);
    CHECK(health.shortest_block <= health.longest_block);
  });
}

TEST_CASE("backends: stopping is fine at any time", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    const auto stream = subject.backend->open(subject.request, guarded);
    REQUIRE(stream);
    CHECK((*stream)->stop());
    CHECK((*stream)->state() == StreamState::Stopped);
    play(**stream, witness);  // stopped before it began: it may still begin
    CHECK((*stream)->stop());
    CHECK((*stream)->stop());
    const int played = witness.frames;
    play(**stream, witness);
    CHECK(witness.frames > played);
  });
}

TEST_CASE("backends: an open device can be closed and opened again from the start", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    for (int turn = 1; turn <= 2; ++turn) {
      const auto stream = subject.backend->open(subject.request, guarded);
      REQUIRE(stream);
      CHECK(guarded.frame() == 0);
      play(**stream, witness);
      CHECK(witness.prepared == turn);
      CHECK(witness.frames >= turn * kFrames);
    }
  });
}

TEST_CASE("backends: an unknown device is an error that lists what there is", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded&) {
    auto request = subject.request;
    request.device = subject.backend->name() + ":nothing";
    const auto error = test::summary(refusal(subject, request));
    CHECK(error.starts_with("UnknownName '" + request.device + "'"));
    CHECK(error.find("'" + subject.backend->devices()->front().id + "'") != std::string::npos);
  });
}

TEST_CASE("backends: a request that cannot be granted is refused with the reason", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded&) {
    const auto refused = [&](auto change) {
      auto request = subject.request;
      change(request);
      CHECK(refusal(subject, request).what.size() > 20);
    };
    const auto device = subject.backend->devices()->front();
    for (const double rate :
         {0.0, -48e3, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      CAPTURE(rate);
      refused([&](StreamRequest& request) { request.sample_rate = Hertz{rate}; });
    }
    if (!device.sample_rates.empty())
      refused([&](StreamRequest& request) { request.sample_rate = Hertz{device.default_rate.value + 1}; });
    refused([](StreamRequest& request) { request.in_channels = -1; });
    refused([](StreamRequest& request) { request.out_channels = -1; });
    refused([&](StreamRequest& request) { request.in_channels = device.in_channels + 1; });
    refused([&](StreamRequest& request) { request.out_channels = device.out_channels + 1; });
    refused([](StreamRequest& request) { request.block_frames = 0; });
    refused([](StreamRequest& request) { request.block_frames = -64; });
    refused([](StreamRequest& request) { request.block_frames = std::numeric_limits<int>::max(); });
  });
}

TEST_CASE("backends: the error of a processor that refuses the format is passed on", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    witness.refuse = true;
    const auto stream = subject.backend->open(subject.request, guarded);
    REQUIRE_FALSE(stream);
    CHECK(test::summary(stream) == "BadArgument");
    witness.refuse = false;
    CHECK(subject.backend->open(subject.request, guarded));
  });
}
