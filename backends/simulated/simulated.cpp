#include "backends/simulated/simulated.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace tactus {
namespace {

constexpr const char* kDeviceId = "simulated:world";
constexpr int kLongestBlock = 1 << 16;

int sensors_of(const SimulatedWorld& world) { return world.plant.out_channels(); }
int drives_of(const SimulatedWorld& world) { return world.plant.in_channels(); }

Status check(const SimulatedWorld& world, const StreamRequest& request) {
  if (!request.device.empty() && request.device != kDeviceId)
    return fail(Errc::UnknownName, "", fmt::format("there is no device '{}'", request.device),
                fmt::format("the only one here is '{}'", kDeviceId));
  const auto rate = world.plant.plan().sample_rate;
  if (request.sample_rate && *request.sample_rate != rate)
    return fail(Errc::BadArgument, kDeviceId,
                fmt::format("{} Hz is not to be had, the world runs at {} Hz", request.sample_rate->value,
                            rate.value),
                "compile both sides for the rate you want");
  if (request.in_channels != sensors_of(world) || request.out_channels != drives_of(world))
    return fail(Errc::BadArgument, kDeviceId,
                fmt::format("{} inputs and {} outputs are wanted, but the world has {} sensors and {} drives",
                            request.in_channels, request.out_channels, sensors_of(world), drives_of(world)),
                "join every port of the instrument with one of the plant");
  const int block = request.block_frames.value_or(world.block_frames);
  if (block < 1 || block > kLongestBlock)
    return fail(Errc::BadArgument, kDeviceId, fmt::format("a block of {} frames is out of range", block),
                fmt::format("give 1 to {} frames", kLongestBlock));
  return {};
}

/// The caller's processor with a clock around it: the loop runs plant and instrument, health is about the
/// instrument. The plant is an engine, whose outputs are finite, so there is no bad input to count.
class Metered final : public BlockProcessor {
 public:
  explicit Metered(Guarded& inner) : inner_(inner) {}

  Status prepare(const StreamFormat& format) override {
    format_ = format;
    auto status = inner_.prepare(format);
    inner_.skip_soft_start();
    return status;
  }
  void process(const BlockIo& io) noexcept override {
    if (last_) return inner_.finish(io);
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    inner_.process(io);
    const std::chrono::duration<double> busy = Clock::now() - begin;
    meter_.block(io.frames, busy.count() * format_.sample_rate.value / io.frames);
  }
  /// Blocks are the last ones before a stop, or they are not.
  void set_last(bool last) { last_ = last; }
  const StreamFormat& format() const { return format_; }
  Health read() const { return meter_.read(); }

 private:
  Guarded& inner_;
  bool last_ = false;
  StreamFormat format_;
  HealthMeter meter_;
};

class SimulatedStream final : public Stream {
 public:
  SimulatedStream(const SimulatedWorld& world, Guarded& processor, std::shared_ptr<void> use)
      : processor_(processor),
        loop_(processor_, world.plant, drives_of(world), world.delay_frames, world.converters),
        listener_(world.listener),
        frames_(world.frames),
        use_(std::move(use)) {
    granted_.device = kDeviceId;
    // The delay is one exact number for both ways together; it counts as the way out.
    granted_.input_latency_frames = 0.0;
    granted_.output_latency_frames = world.delay_frames;
  }

  Status prepare(Hertz sample_rate, int block) {
    if (auto status = loop_.prepare(sample_rate, block); !status) return status;
    granted_.format = processor_.format();
    granted_.block_frames = granted_.format.max_frames;
    return {};
  }

  const StreamGranted& granted() const override { return granted_; }
  Status start() override {
    if (state_ != StreamState::Stopped)
      return fail(Errc::Device, kDeviceId, "this run is over", "open the device again");
    state_ = StreamState::Running;
    while (state_ == StreamState::Running && done_ < frames_) {
      const auto piece = std::min<std::int64_t>(granted_.block_frames, frames_ - done_);
      done_ += piece;
      loop_.run(static_cast<int>(piece), listener_);
    }
    if (state_ == StreamState::Running) state_ = StreamState::Finished;
    processor_.set_last(true);
    loop_.run(granted_.block_frames, listener_);
    processor_.set_last(false);
    return {};
  }
  Status stop() override {
    if (state_ == StreamState::Running) state_ = StreamState::Stopped;
    return {};
  }
  StreamState state() const override { return state_; }
  Health health() const override { return processor_.read(); }

 private:
  Metered processor_;
  ClosedLoop loop_;
  ClosedLoop::Listener listener_;
  std::int64_t frames_;
  std::int64_t done_ = 0;
  std::shared_ptr<void> use_;
  StreamGranted granted_;
  StreamState state_ = StreamState::Stopped;
};

}  // namespace

Result<std::vector<Device>> SimulatedBackend::devices() {
  Device device;
  device.id = kDeviceId;
  device.name = "the simulated world";
  device.in_channels = sensors_of(world_);
  device.out_channels = drives_of(world_);
  device.default_rate = world_.plant.plan().sample_rate;
  device.sample_rates = {device.default_rate};
  device.is_default = true;
  return std::vector<Device>{device};
}

Result<std::unique_ptr<Stream>> SimulatedBackend::open(const StreamRequest& request, Guarded& processor) {
  if (auto status = check(world_, request); !status) return tl::unexpected(status.error());
  if (!in_use_.expired())
    return fail(Errc::Device, kDeviceId, "another stream plays in this world", "close that one first");
  std::shared_ptr<void> use = std::make_shared<int>();
  auto stream = std::make_unique<SimulatedStream>(world_, processor, use);
  const auto rate = world_.plant.plan().sample_rate;
  if (auto status = stream->prepare(rate, request.block_frames.value_or(world_.block_frames)); !status)
    return tl::unexpected(status.error());
  in_use_ = use;
  return stream;
}

}  // namespace tactus
