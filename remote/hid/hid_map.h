#pragma once
// Thread: [any, one thread]

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/rig/rig.h"
#include "remote/remote.h"

namespace tactus {

/// An axis or a button that moved.
struct HidEvent {
  std::string device;
  HidPart part = HidPart::Axis;
  int number = 0;         ///< from 0 on
  double position = 0.0;  ///< 0 to 1; of a button 0 or 1
};

/// Turns what moves on joysticks, pedals and gamepads into orders, as the controls of the description say.
class HidMap {
 public:
  /// Learning: an axis must move by this share, so that one that is noisy or at rest is not taken.
  static constexpr double kLearnShare = 0.25;

  /// The orders that this event gives, without a time. While `target` learns, what moves far enough is
  /// learnt and gives none.
  std::vector<RemoteOrder> handle(const HidEvent& event, RemoteTarget& target);
  /// The device is gone: its axes are at rest where they are when it returns.
  void forget(const std::string& device);

 private:
  using Place = std::pair<std::string, int>;

  bool moved_far(const HidEvent& event);

  std::map<Place, double> first_;  ///< of axes: where they were when they had last moved so far
};

}  // namespace tactus
