#pragma once
// Thread: [any, one thread: the network's]

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "remote/osc/osc_joints.h"
#include "remote/osc/osc_world_orders.h"

namespace tactus {

/// Messages of DIMPLE (Sinclair & Wanderley, NIME 2007; its documentation of messages) that change a world
/// whose elements are `remote` in the graph file: a body is created by making one of them present that is
/// not, and destroyed by making it absent; a joint is created from a link. Everything is done by their
/// controls, as orders of one frame.
class OscWorld {
 public:
  static constexpr std::string_view kBeginning = "/world/", kCursor = "cursor", kMagnitude = "/magnitude";

  /// Whether the instrument has bodies for these messages.
  static bool has_bodies(const RemoteDescription& description);
  /// Appends the orders of a message. `bodies`: as they are now, or nullptr. Errors: UnknownName for objects
  /// and messages that do not exist, BadArgument for wrong values, OutOfRange where nothing is free.
  Status obey(const OscMessage& message, const RemoteDescription& description, const RemoteBodies* bodies,
              std::vector<RemoteOrder>& orders);

  /// A body by the name that a message created, or by that in the graph file.
  OscObject find(const std::string& name, const RemoteDescription& description) const;
  /// The other way; "": there is no such body.
  std::string name_of(int world, int body, const RemoteDescription& description) const;
  /// The controls that say what "mass" of a body or "response/spring" of a joint is; empty: none do. Those of
  /// "gravity" belong to the name "".
  std::vector<std::string> controls_of(const std::string& name, std::string_view value,
                                       const RemoteDescription& description) const;

 private:
  Status create(std::string_view shape, const OscMessage& message, OscOrders& orders);
  Status change(const std::string& name, std::string_view what, const OscMessage& message,
                const RemoteBodies* bodies, OscOrders& orders);
  Status set_magnitude(const std::string& name, std::string_view what, const OscMessage& message,
                       const RemoteBodies* bodies, OscOrders& orders);
  Status grab(const std::string& name, OscOrders& orders);
  void clear(OscOrders& orders);
  std::string present_body(const std::string& name, const RemoteDescription& description) const;

  std::map<std::string, std::string> created_;  ///< objects: the beginning of their controls' names
  OscJoints joints_;
};

}  // namespace tactus
