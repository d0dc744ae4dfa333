#pragma once
// Thread: [any]

#include <cstdint>
#include <string>

#include "remote/remote.h"

// The messages from the program to a panel: docs/panel_protocol.md.

namespace tactus {

std::string description_text(const RemoteDescription& description);
std::string edit_text(const RemoteEdit& edit);
std::string verdict_text(const RemoteVerdict& verdict);
std::string scope_text(const RemoteScope& scope);
std::string event_text(const RemoteEvent& event);
/// To a client, which gave the order `to`.
std::string answer_text(const std::string& to, std::int64_t number);
std::string error_text(const std::string& to, const std::string& error);

/// What a state contains besides what is measured.
struct PanelState {
  bool armed = false, muted = false;
  bool owner = false;                    ///< this client armed the drives
  bool levels = false;                   ///< the levels of all signals are asked for
  const RemoteBodies* bodies = nullptr;  ///< that this client asked for; nullptr: none
};
std::string state_text(const RemoteDescription& description, const RemoteMeters& meters,
                       const RemoteState& state, const PanelState& panel);

/// A binary message: "Scope frames" of the protocol.
std::string scope_bytes(const ScopeChunk& chunk);

}  // namespace tactus
