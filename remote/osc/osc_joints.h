#pragma once
// Thread: [any, one thread: the network's]

#include <functional>
#include <map>
#include <string>
#include <string_view>

#include "remote/osc/osc_world_orders.h"

namespace tactus {

/// DIMPLE's messages for joints between bodies, made from the `link` elements of a world that are `remote`.
class OscJoints {
 public:
  using FindObject = std::function<OscObject(const std::string& name)>;

  /// Whether it is a kind of joint: "hinge", "slide".
  static bool is_kind(std::string_view kind);
  bool exists(const std::string& name) const { return links_.contains(name); }
  /// "/world/hinge/create NAME OBJECT OBJECT …". Errors: BadArgument for wrong values, UnknownName for
  /// objects that do not exist, OutOfRange where no link is free.
  Status create(std::string_view kind, const OscMessage& message, const FindObject& find_object,
                OscOrders& orders);
  /// Of a joint that exists: "response/spring", "destroy". Errors: UnknownName, BadArgument.
  Status change(const std::string& name, std::string_view what, const OscMessage& message, OscOrders& orders);
  /// The controls that say what "response/spring" is now. Empty: there is no such value.
  std::vector<std::string> controls_of(const std::string& name, std::string_view what) const;
  /// Those of a body that is destroyed; "": all.
  void destroy_of(const std::string& body, OscOrders& orders);

 private:
  struct Link {
    std::string controls;    ///< the beginning of their names
    std::string one, other;  ///< the controls of its bodies
  };

  static void remove(const Link& link, OscOrders& orders);

  std::map<std::string, Link> links_;  ///< by the name of the joint
};

}  // namespace tactus
