#pragma once
// Thread: [control]

#include <map>
#include <memory>
#include <string>

#include "backends/backend.h"
#include "backends/described_devices.h"
#include "backends/loop/loop_card.h"

namespace tactus {

/// A sound card that is only simulated, with a cable from its outputs to its inputs: what goes out comes in
/// again, in the ways that `LoopCard` has. Its devices are those of `loop_cards` and whatever is added, with
/// two inputs and two outputs at any rate. For trying out what measures a card, and for testing it.
///
/// A thread of its own brings the blocks; `Health::seconds` counts by the clock of the card.
class LoopBackend final : public Backend, public DescribedDevices {
 public:
  enum class Pace {
    RealTime,
    AsFastAsPossible,  ///< the same frames, without waiting, whatever `LoopCard::real_time` says
  };
  explicit LoopBackend(Pace pace = Pace::RealTime) : pace_(pace) {}

  /// [control] One more device, called `id`, "loop:" included.
  void add(const std::string& id, const LoopCard& card) { cards_[id] = card; }
  /// [control] The same for an id that describes the card, such as "loop:delay=960.25". Errors: UnknownName.
  Status add(const std::string& id) override;

  std::string name() const override { return "loop"; }
  Result<std::vector<Device>> devices() override;
  /// [control] See Backend::open. Blocks are never longer than the delay, because a card cannot record what
  /// has not been played yet: `granted` has the length. Errors besides: OutOfRange for a delay that is too
  /// short.
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override;

 private:
  LoopCard card(const std::string& id) const;

  Pace pace_;
  std::map<std::string, LoopCard> cards_;
  int openings_ = 0;  ///< so far; what is unstable is different in each
};

}  // namespace tactus
