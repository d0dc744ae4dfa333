#pragma once

#include <string>
#include <vector>

#include "backends/backend.h"
#include "backends/jack/client.h"

namespace tactus::jack {

/// A client of the server with audio ports, by their full names, in the server's order.
struct Card {
  std::string client;
  std::vector<std::string> captures;   ///< that sound comes out of
  std::vector<std::string> playbacks;  ///< that sound goes into
};

/// [control] All clients with audio ports, those with real hardware behind them first.
std::vector<Card> cards(const Client& client);
/// [control] The same as devices; the first one is the default.
std::vector<Device> devices(const Client& client, const std::vector<Card>& cards);

}  // namespace tactus::jack
