#pragma once
// Thread: [any, one thread: the network's]

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "remote/osc/osc_messages.h"
#include "remote/remote.h"

// What the messages for worlds share.
namespace tactus {

/// A body of a world.
struct OscObject {
  std::string controls;       ///< the beginning of the names of its controls, "pool_ball_1"
  int world = -1, body = -1;  ///< in RemoteDescription::worlds, in its looks; -1: it is not computed
  int number = 0;             ///< of the body, in the file
};

/// The orders that a message becomes.
class OscOrders {
 public:
  OscOrders(const RemoteDescription& description, std::vector<RemoteOrder>& orders)
      : description_(description), orders_(orders) {}

  const RemoteControl* find(const std::string& control) const;
  /// Within the range of the control. Where there is no such control, nothing.
  void set(const std::string& control, double value);
  /// A trigger.
  void pull(const std::string& control);
  const RemoteDescription& description() const { return description_; }

 private:
  const RemoteDescription& description_;
  std::vector<RemoteOrder>& orders_;
};

/// nullptr: it is not known now.
const BodyPose* pose_of(const RemoteBodies* bodies, const OscObject& object);

/// The values behind the first ones as finite numbers; nothing: one of them is none.
std::optional<std::vector<double>> numbers_of(const OscMessage& message, std::size_t first);
const std::string* text_at(const OscMessage& message, std::size_t at);

inline tl::unexpected<Error> world_error(Errc code, std::string what, std::string remedy = {}) {
  return tl::unexpected(Error{code, "", std::move(what), std::move(remedy)});
}

}  // namespace tactus
