#pragma once
// Thread: [any, one thread: the network's]

#include <string>
#include <string_view>

#include "remote/remote.h"

namespace tactus {

struct HttpAnswer {
  int status = 200;
  std::string body = {};  ///< JSON, or empty
};

/// OSCQuery (Vidvox, "OSCQueryProposal"): the description of an address space, and of what is below a path,
/// as JSON. `target`: of the request, "/control/strength?VALUE". What cannot be read with OSC messages alone:
/// ranges (RANGE), units (UNIT), which addresses can be read (ACCESS 1), set (2) or both (3).
HttpAnswer osc_query(const RemoteTarget& remote, std::string_view target, int port);
/// To a whole HTTP request: its head. Only GET.
HttpAnswer answer_http(const RemoteTarget& remote, std::string_view head, int port);
/// The bytes of an answer in HTTP 1.1; the connection is closed behind it.
std::string http_bytes(const HttpAnswer& answer);

}  // namespace tactus
