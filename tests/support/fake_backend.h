#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backends/backend.h"

namespace tactus::test {

/// What a test decides about a device and what its backend did.
struct FakeWorld {
  StreamState state = StreamState::Stopped;
  bool there = true, starts = true, comes_back = true;
  Health health;
  std::vector<std::string> notes;
  std::string default_device = "fake:one";
  DeviceIdentity input, output;
  int block = 64;      ///< at the next opening
  int block_now = 64;  ///< of a running stream
  int periods = 2;
  std::vector<OtherWriter> writers;
  bool writers_unknown = false;

  std::vector<std::string> opened;
  std::vector<StreamRequest> requests;
  int destroyed = 0, tried = 0;
};

class FakeStream final : public Stream {
 public:
  FakeStream(FakeWorld& world, StreamGranted granted) : world_(world), granted_(std::move(granted)) {}
  ~FakeStream() override { ++world_.destroyed; }
  const StreamGranted& granted() const override { return granted_; }
  Status start(const std::function<void()>& ready) override {
    if (!world_.starts) return fail(Errc::Device, "", "it does not start");
    ready();
    world_.state = StreamState::Running;
    return {};
  }
  Status stop() override { return world_.state = StreamState::Stopped, Status{}; }
  StreamState state() const override { return world_.state; }
  Health health() const override { return world_.health; }
  int block_frames() const override { return world_.block_now; }
  std::vector<OtherWriter> other_writers() const override { return world_.writers; }
  std::string take_note() override {
    if (world_.notes.empty()) return {};
    auto note = world_.notes.front();
    world_.notes.erase(world_.notes.begin());
    return note;
  }

 private:
  FakeWorld& world_;
  StreamGranted granted_;
};

/// A backend that fails on request. The test brings the blocks.
class FakeBackend : public Backend {
 public:
  explicit FakeBackend(FakeWorld& world) : world_(world) {}
  std::string name() const override { return "fake"; }
  Result<std::vector<Device>> devices() override { return std::vector<Device>{}; }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    ++world_.tried;
    world_.requests.push_back(request);
    if (!world_.there) return fail(Errc::UnknownName, "", "there is no device '" + request.device + "'");
    StreamGranted granted;
    granted.device = request.device.empty() ? world_.default_device : request.device;
    granted.input = world_.input;
    granted.output = world_.output;
    granted.format = {request.sample_rate.value_or(48_kHz), request.in_channels,
                      std::max(1, request.out_channels), world_.block};
    granted.block_frames = world_.block_now = world_.block;
    granted.periods = world_.periods;
    granted.comes_back = world_.comes_back;
    granted.writers_unknown = world_.writers_unknown;
    if (auto status = processor.prepare(granted.format); !status) return tl::unexpected(status.error());
    guarded = &processor;
    world_.opened.push_back(granted.device);
    world_.state = StreamState::Stopped;
    world_.health = {};
    return std::make_unique<FakeStream>(world_, granted);
  }

  GuardedBlocks* guarded = nullptr;  ///< of the last opening

 private:
  FakeWorld& world_;
};

}  // namespace tactus::test
