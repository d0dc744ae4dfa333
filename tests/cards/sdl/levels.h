#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/sdl/wave_effect.h"
#include "engine/core/named.h"
#include "tests/support/wait_until.h"

namespace tactus::test {

/// Motors, forces and effects, and the settings of four waves.
inline constexpr int kMostOutputs = 12 + 4 * static_cast<int>(kWaveSettings.size());

/// All outputs of a force-feedback device have the levels that a test gives.
class Levels final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& granted) override {
    outputs_ = granted.out_channels;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    input = io.in[0][io.frames - 1];
    const double gain = changes > 0 && changes-- % 2 == 0 ? 0.9 : 1.0;
    for (int c = 0; c < outputs_; ++c)
      std::fill_n(io.out[c], io.frames, gain * levels[static_cast<std::size_t>(c)]);
  }
  std::array<std::atomic<double>, kMostOutputs> levels{};
  std::atomic<int> changes{0};     ///< blocks that still follow in which all levels change
  std::atomic<double> input{0.0};  ///< the first

 private:
  int outputs_ = 0;
};

/// The guard lets everything through to all outputs of a device.
inline std::vector<GuardedChannel> unguarded(const Device& device) {
  return {static_cast<std::size_t>(device.out_channels),
          {DriveGuard::Kind::Audio, {.ceiling = 1.0}, {false, false}}};
}

/// In the virtual machine, which is slow.
inline bool waits(const std::function<bool()>& holds) { return wait_until(holds, std::chrono::seconds{120}); }

inline std::unique_ptr<Backend> sdl() { return find_named(haptic_backends(), "sdl")->make(); }

/// The device of this id, as soon as it has so many outputs: a driver adds force feedback to a device that is
/// there already.
inline Device listed(Backend& backend, const std::string& id, int outputs) {
  Device device;
  std::string all;
  const bool found = waits([&] {
    const auto devices = backend.devices();
    if (!devices) return false;
    all.clear();
    for (const auto& each : *devices)
      all += each.id + " with " + std::to_string(each.out_channels) + " outputs\n";
    const auto at = std::ranges::find(*devices, id, &Device::id);
    if (at == devices->end() || at->out_channels != outputs) return false;
    device = *at;
    return true;
  });
  INFO("devices:\n" << all);
  REQUIRE(found);
  return device;
}

/// All of its inputs and outputs.
inline StreamRequest request_for(const Device& device) {
  StreamRequest request;
  request.device = device.id;
  request.in_channels = device.in_channels;
  request.out_channels = device.out_channels;
  return request;
}

}  // namespace tactus::test
