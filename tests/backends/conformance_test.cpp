#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>

#include "backends/offline/offline.h"
#include "backends/simulated/simulated.h"
#include "tests/support/graph_runner.h"

// The contract of backends/backend.h, for every backend that needs no hardware. A new one is a line in
// `every_backend`.

using namespace tactus;

namespace {

constexpr int kFrames = 500;
constexpr Hertz kRate = 48_kHz;

/// A backend that plays `kFrames` frames, what it stands on, and a request that it must grant.
struct Subject {
  std::unique_ptr<Engine> plant;
  std::unique_ptr<Backend> backend;
  StreamRequest request;
  std::shared_ptr<std::vector<double>> heard;  ///< by what the first output moves
};

StreamRequest two_in_one_out() {
  StreamRequest request;
  request.in_channels = 2;
  request.out_channels = 1;
  return request;
}

Subject offline() {
  OfflineJob job;
  job.frames = kFrames;
  auto heard = std::make_shared<std::vector<double>>();
  job.sink.channels = 1;
  job.sink.write = job.sink.finish = [heard](const double* const* channels, int frames) -> Status {
    heard->insert(heard->end(), channels[0], channels[0] + frames);
    return {};
  };
  return {nullptr, std::make_unique<OfflineBackend>(job), two_in_one_out(), heard};
}

Subject simulated() {
  auto plant = test::engine_of(R"(
format = 1
[inputs]
drive = { unit = "full scale" }
[nodes]
cone = { type = "one_pole", in = "drive", cutoff = "100 Hz" }
[outputs]
microphone = { from = "cone + 0.25" }
ribbon     = { from = "cone" }
)");
  auto heard = std::make_shared<std::vector<double>>();
  const auto listener = [heard](const ClosedLoop::Piece& piece) {
    heard->insert(heard->end(), piece.drives[0], piece.drives[0] + piece.frames);
  };
  auto backend = std::make_unique<SimulatedBackend>(
      SimulatedWorld{.plant = *plant, .delay_frames = 100, .frames = kFrames, .listener = listener});
  return {std::move(plant), std::move(backend), two_in_one_out(), heard};
}

/// Writes down what is asked of it.
class Witness final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& granted) override {
    ++prepared;
    format = granted;
    return refuse ? fail(Errc::BadArgument, "", "not in this format") : Status{};
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
  int prepared = 0, before_prepare = 0, wrong_length = 0, not_finite = 0, blocks = 0, frames = 0;
};

/// Runs `check(subject, witness, guarded)` on a fresh one of each backend.
template <class Check>
void for_every_backend(Check check) {
  for (Subject (*make)() : {offline, simulated}) {
    Subject subject = make();
    INFO(subject.backend->name());
    Witness witness;
    Guarded guarded{witness, {}};
    check(subject, witness, guarded);
  }
}

std::string refusal(const Subject& subject, const StreamRequest& request) {
  Witness witness;
  Guarded guarded{witness, {}};
  const auto stream = subject.backend->open(request, guarded);
  CHECK(witness.prepared == 0);
  return stream ? "" : to_string(stream.error());
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
      CHECK(device.in_channels >= subject.request.in_channels);
      CHECK(device.out_channels >= subject.request.out_channels);
      CHECK(device.default_rate > Hertz{0});
      if (!device.sample_rates.empty())
        CHECK(std::count(device.sample_rates.begin(), device.sample_rates.end(), device.default_rate) == 1);
      defaults += device.is_default ? 1 : 0;
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
    CHECK(granted.block_frames == 32);
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
    CHECK((*stream)->granted().device == subject.backend->devices()->front().id);
    CHECK((*stream)->granted().format.sample_rate == kRate);
    CHECK((*stream)->granted().format.max_frames >= 1);
  });
}

TEST_CASE("backends: a run goes from Stopped to Finished with every frame in a block that fits",
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
      REQUIRE((*stream)->start());
      CHECK((*stream)->state() == StreamState::Finished);
      CHECK(witness.before_prepare == 0);
      CHECK(witness.wrong_length == 0);
      CHECK(witness.not_finite == 0);
      CHECK(witness.frames == kFrames);
      CHECK(guarded.frame() == kFrames);
    });
  }
}

TEST_CASE("backends: health counts what was played", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    auto request = subject.request;
    request.block_frames = 64;
    const auto stream = subject.backend->open(request, guarded);
    REQUIRE(stream);
    REQUIRE((*stream)->start());
    const auto health = (*stream)->health();
    CHECK(health.frames == kFrames);
    CHECK(health.blocks == witness.blocks);
    CHECK(health.blocks == 8);  // 7 * 64 = 448, and 52 are left
    CHECK(health.longest_block == 64);
    CHECK(health.shortest_block == 52);
    CHECK(health.xruns == 0);
    CHECK(health.lost_frames == 0);
    CHECK(health.bad_input == 0);
    CHECK(health.peak_load >= health.mean_load);
  });
}

TEST_CASE("backends: stopping is fine at any time, and a run that is over is told from one that is not",
          "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    const auto stream = subject.backend->open(subject.request, guarded);
    REQUIRE(stream);
    CHECK((*stream)->stop());
    CHECK((*stream)->state() == StreamState::Stopped);
    REQUIRE((*stream)->start());  // stopped before it began: it may still begin
    CHECK((*stream)->stop());
    CHECK((*stream)->stop());
    CHECK((*stream)->state() == StreamState::Finished);
    const auto again = (*stream)->start();
    REQUIRE_FALSE(again);
    CHECK(again.error().code == Errc::Device);
    CHECK_FALSE(again.error().remedy.empty());
    CHECK(witness.frames == kFrames);
  });
}

TEST_CASE("backends: a run that is over ends on a block of zeros", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded& guarded) {
    auto request = subject.request;
    request.block_frames = 64;
    const auto stream = subject.backend->open(request, guarded);
    REQUIRE(stream);
    REQUIRE((*stream)->start());
    const auto& heard = *subject.heard;
    REQUIRE(heard.size() == kFrames + 64);
    CHECK(heard[kFrames - 1] != 0.0);
    CHECK(std::vector<double>(heard.begin() + kFrames, heard.end()) == std::vector<double>(64, 0.0));
  });
}

TEST_CASE("backends: an open device can be closed and opened again from the start", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    for (int turn = 1; turn <= 2; ++turn) {
      const auto stream = subject.backend->open(subject.request, guarded);
      REQUIRE(stream);
      CHECK(guarded.frame() == 0);
      REQUIRE((*stream)->start());
      CHECK(witness.prepared == turn);
      CHECK(witness.frames == turn * kFrames);
    }
  });
}

TEST_CASE("backends: an unknown device is an error that lists what there is", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded&) {
    auto request = subject.request;
    request.device = subject.backend->name() + ":nothing";
    const auto said = refusal(subject, request);
    CHECK(said.find("there is no device '" + request.device + "'") == 0);
    CHECK(said.find("'" + subject.backend->devices()->front().id + "'") != std::string::npos);
  });
}

TEST_CASE("backends: a request that cannot be granted is refused in words", "[backends]") {
  for_every_backend([](Subject& subject, Witness&, Guarded&) {
    const auto refused = [&](auto change) {
      auto request = subject.request;
      change(request);
      const auto said = refusal(subject, request);
      CHECK(said.size() > 20);
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

TEST_CASE("backends: a processor that refuses the format is heard", "[backends]") {
  for_every_backend([](Subject& subject, Witness& witness, Guarded& guarded) {
    witness.refuse = true;
    const auto stream = subject.backend->open(subject.request, guarded);
    REQUIRE_FALSE(stream);
    CHECK(to_string(stream.error()) == "not in this format");
    witness.refuse = false;
    CHECK(subject.backend->open(subject.request, guarded));
  });
}
