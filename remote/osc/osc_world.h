#pragma once
// Thread: [any, one thread: the network's]

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/error.h"
#include "remote/osc/osc_messages.h"
#include "remote/remote.h"

namespace tactus {

/// Messages of DIMPLE (Sinclair & Wanderley, NIME 2007; its documentation of messages) for the bodies of a
/// world that are `remote` in the graph file: a body is created by making one of them present that is not,
/// and destroyed by making it absent. Everything is done by their controls, as orders of one frame.
class OscWorld {
 public:
  static constexpr std::string_view kBeginning = "/world/";

  /// Whether the instrument has bodies for these messages.
  static bool has_bodies(const RemoteDescription& description);
  /// Appends the orders of a message. Errors: UnknownName for objects and messages that do not exist,
  /// BadArgument for wrong values, OutOfRange where no body is free.
  Status obey(const OscMessage& message, const RemoteDescription& description,
              std::vector<RemoteOrder>& orders);

 private:
  Status create(std::string_view shape, const OscMessage& message, const RemoteDescription& description,
                std::vector<RemoteOrder>& orders);
  Status change(const std::string& object, std::string_view what, const OscMessage& message,
                const RemoteDescription& description, std::vector<RemoteOrder>& orders);
  std::string body_of(const std::string& object, const RemoteDescription& description) const;

  std::map<std::string, std::string> created_;  ///< objects: the beginning of their controls' names
};

}  // namespace tactus
