#pragma once
// Thread: [control]

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/play/live/remote/live_remote.h"
#include "engine/rig/rig.h"

namespace tactus::app {

struct RemoteOptions {
  std::string osc;                        ///< [ADDRESS:]PORT; empty: no server
  bool osc_arm = false;                   ///< clients of other hosts may arm
  std::vector<std::string> serial{};      ///< DEVICE[@BAUD]
  std::optional<std::string> hid{};       ///< a part of a device's name; empty: all
  std::optional<std::string> midi_out{};  ///< a part of a port's name; empty: a port of our own
  std::string midi_api{};
  bool midi_by_rig = false;                 ///< only the rig asks for MIDI messages
  std::vector<RigMidiOut> midi_messages{};  ///< none: a note for each event
  std::optional<std::string> panel{};       ///< [ADDRESS:]PORT, or empty: any port; nothing: no server
  bool panel_arm = false;
  bool open_browser = true;
};

/// The servers through which clients reach a session, with the target of their orders.
class RemoteServer {
 public:
  virtual ~RemoteServer() = default;
  virtual LiveRemote& target() = 0;
  /// Where it can be reached, a line for each server.
  virtual std::vector<std::string> announcements() const = 0;
  /// What clients did, a line for each server.
  virtual std::vector<std::string> summaries() const = 0;
};

/// nullptr: none is asked for. Throws a CommandError: an address is wrong or in use, or this program was
/// built without a server.
std::unique_ptr<RemoteServer> make_remote_server(const RemoteOptions& options, Session& session,
                                                 Performer& performer, Hertz sample_rate);

}  // namespace tactus::app
