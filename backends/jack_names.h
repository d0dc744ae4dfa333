#pragma once

#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// Where a library that reaches JACK looks for a client's name in those of the others: it asks the server for
/// the ports whose full names match the name as a POSIX regular expression.
enum class JackSearch {
  Anywhere,     ///< RtAudio: "NAME"
  AtEndOfName,  ///< PortAudio: "NAME:.*"
};

/// [any] Whether a character of the name has a meaning in a regular expression: it matches other names than
/// itself, or not even itself.
bool is_regular_expression(const std::string& client);

/// A port for audio on a JACK server.
struct JackPort {
  std::string name;   ///< with its client's: "system:playback_1"
  bool takes = true;  ///< sound, as an output of the card does; else it gives some
};

/// [control] Those of the server that runs, in its order; none if there is no server or it does not let a
/// client in. Empty without JACK's library. May hang as long as the server does.
std::optional<std::vector<JackPort>> jack_ports();

/// [any] Of the devices that a library lists over JACK (Device::api "jack"), the clients whose own ports it
/// opens, with their own numbers of channels; other devices are kept. Left out are those whose names are
/// regular expressions, and those whose names match another client's, or a port of another client. With
/// `Anywhere` a client whose ports come before those of all that match stays, since the first ports that
/// match are opened. `devices` has every client, also those for which the library finds no port; `ports`
/// those of the same server. Where they are not known, names of ports are not looked at.
std::vector<Device> own_ports_only(std::vector<Device> devices, JackSearch search,
                                   const std::optional<std::vector<JackPort>>& ports);

/// [any] Whether this is the id of a JACK client as RtAudio or PortAudio lists it: "rtaudio:jack:card".
bool is_jack_client_of_library(const std::string& id);

/// [any] Whether the device that a person or a file calls `id` ("rtaudio:jack:a.c", or the name of a client)
/// is one that `own_ports_only` would have left out of `listed`, the list of such a library.
bool is_left_out(const std::string& id, const std::vector<Device>& listed);

}  // namespace tactus
