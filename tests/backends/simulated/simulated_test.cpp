#include "backends/simulated/simulated.h"

#include <catch2/catch.hpp>

#include "tests/support/graph_runner.h"

using namespace tactus;

namespace {

constexpr const char* kMirror = R"(
format = 1
[inputs]
drive = { unit = "full scale" }
[nodes]
past = { type = "delay", in = "drive", time = "0 s", interpolation = "none" }
[outputs]
sensor = { from = "past + 0.5" }
)";

/// y = half of what comes in.
class Half final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    for (int n = 0; n < io.frames; ++n) io.out[0][n] = 0.5 * io.in[0][n];
  }
};

/// The drives of a run.
struct Listener {
  std::vector<double> drives;
  void operator()(const ClosedLoop::Block& piece) {
    drives.insert(drives.end(), piece.drives[0], piece.drives[0] + piece.frames);
  }
};

StreamRequest one_in_one_out() {
  StreamRequest request;
  request.in_channels = request.out_channels = 1;
  return request;
}
const StreamRequest kRequest = one_in_one_out();
const std::vector<GuardedChannel> kGuards = {{DriveGuard::Kind::Audio, {}}};

}  // namespace

TEST_CASE("simulated: blocks are no longer than the delay, and the result is the same for all of them",
          "[backends]") {
  const auto run = [](int delay, int block) {
    const auto plant = test::engine_of(kMirror);
    Half half;
    Guarded guarded{half, kGuards};
    Listener heard;
    SimulatedBackend backend{{.plant = *plant,
                              .delay_frames = delay,
                              .converters = {.on = false},
                              .frames = 1000,
                              .listener = std::ref(heard)}};
    auto request = kRequest;
    request.block_frames = block;
    const auto stream = backend.open(request, guarded);
    REQUIRE(stream);
    CHECK((*stream)->granted().block_frames == std::min(block, delay));
    CHECK((*stream)->granted().output_latency_frames == delay);
    REQUIRE((*stream)->start());
    REQUIRE(heard.drives.size() == static_cast<std::size_t>(1000 + std::min(block, delay)));
    CHECK(heard.drives.back() == 0.0);
    heard.drives.resize(1000);  // without the last block
    return heard.drives;
  };
  const auto reference = run(100, 100);
  REQUIRE(reference.size() == 1000);
  CHECK(reference.back() > 0.1);
  for (const int block : {1, 33, 64, 4096}) CHECK(run(100, block) == reference);
  CHECK(run(10, 64) != reference);
}

TEST_CASE("simulated: stopped by its listener it hears zeros, and goes on with the frames that are left",
          "[backends]") {
  const auto plant = test::engine_of(kMirror);
  Half half;
  Guarded guarded{half, kGuards};
  Stream* playing = nullptr;
  std::vector<double> drives;
  SimulatedBackend backend{
      {.plant = *plant, .delay_frames = 50, .frames = 300, .listener = [&](const ClosedLoop::Block& piece) {
         drives.insert(drives.end(), piece.drives[0], piece.drives[0] + piece.frames);
         if (drives.size() == 100) CHECK(playing->stop());
       }}};
  const auto stream = backend.open(kRequest, guarded);
  REQUIRE(stream);
  playing = stream->get();
  REQUIRE(playing->start());
  CHECK(playing->state() == StreamState::Stopped);
  CHECK(guarded.frame() == 100);
  REQUIRE(playing->start());
  CHECK(playing->state() == StreamState::Finished);
  CHECK(guarded.frame() == 300);
  REQUIRE(drives.size() == 400);  // 100, a block of zeros, the other 200, a block of zeros
  const auto part = [&](int from, int to) {
    return std::vector<double>(drives.begin() + from, drives.begin() + to);
  };
  CHECK(drives[99] > 0.2);
  CHECK(part(100, 150) == std::vector<double>(50, 0.0));
  CHECK(drives[349] > 0.2);
  CHECK(part(350, 400) == std::vector<double>(50, 0.0));
}

TEST_CASE("simulated: refuses in words what the world does not have", "[backends]") {
  const auto plant = test::engine_of(kMirror);
  Half half;
  Guarded guarded{half, kGuards};
  SimulatedBackend backend{{.plant = *plant, .delay_frames = 50, .frames = 300}};
  const auto said = [&](auto change) {
    auto request = kRequest;
    change(request);
    return to_string(backend.open(request, guarded).error());
  };
  CHECK(said([](auto& request) { request.device = "simulated:moon"; }) ==
        "there is no device 'simulated:moon'; the only one here is 'simulated:world'");
  CHECK(said([](auto& request) { request.sample_rate = 44.1_kHz; }) ==
        "simulated:world: 44100 Hz is not to be had, the world runs at 48000 Hz; compile both sides for the "
        "rate you want");
  CHECK(said([](auto& request) { request.in_channels = 2; }) ==
        "simulated:world: 2 inputs and 1 outputs are wanted, but the world has 1 sensors and 1 drives; join "
        "every port of the instrument with one of the plant");
  CHECK(said([](auto& request) { request.block_frames = 0; }) ==
        "simulated:world: a block of 0 frames is out of range; give 1 to 65536 frames");
  const auto stream = backend.open(kRequest, guarded);
  REQUIRE(stream);
  CHECK(said([](auto&) {}) == "simulated:world: another stream plays in this world; close that one first");
}
