#pragma once

#include <cstdint>
#include <memory>

#include "backends/backend.h"
#include "engine/runtime/player.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// A stretch of the simulated world: what lies around the instrument, and for how long.
struct SimulatedWorld {
  Player& plant;                       ///< compiled for the rate at which the world runs
  int delay_frames = 0;                ///< system delay; 0 needs a plant compiled with `closed_outside`
  Converters converters = {};          ///< of the simulated card
  std::int64_t frames = 0;             ///< how long a run lasts
  int block_frames = 64;               ///< where the request names no block
  ClosedLoop::Listener listener = {};  ///< sees every piece as it goes by; may call `Stream::stop`
};

/// The simulated world behind the seam of all backends: one device, "simulated:world", with an input for each
/// sensor of the plant and an output for each of its drives. It has one rate, the plant's, and one format;
/// anything else is refused.
///
/// `start` plays to the end before it returns and leaves the stream Finished. `stop`, called by the listener,
/// ends it after that piece: the stream is then Stopped, and the next `start` goes on from there. Either way
/// the world hears one more block, the zeros of `Guarded::finish`, which is on top of `frames`. Blocks are no
/// longer than the delay, because the world waits for the answer: `granted` says how long.
class SimulatedBackend final : public Backend {
 public:
  /// [control] `world.plant` must outlive this and its streams.
  explicit SimulatedBackend(SimulatedWorld world) : world_(std::move(world)) {}

  std::string name() const override { return "simulated"; }
  Result<std::vector<Device>> devices() override;
  /// [control] See Backend::open. Errors besides: Device while another stream plays in this world.
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, Guarded& processor) override;

 private:
  SimulatedWorld world_;
  std::weak_ptr<void> in_use_;  ///< held by the stream that plays in this world
};

}  // namespace tactus
