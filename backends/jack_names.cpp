#include "backends/jack_names.h"

#if defined(TACTUS_HAS_JACK)
#include <jack/jack.h>
#endif

#include <algorithm>
#include <string_view>

#include "backends/library_calls.h"

namespace tactus {
namespace {

constexpr const char* kApi = "jack";
constexpr std::string_view kMark = ":jack:";  ///< in the id, before the client's name

bool finds(JackSearch search, const std::string& client, const std::string& other) {
  return search == JackSearch::Anywhere ? other.find(client) != std::string::npos : other.ends_with(client);
}

/// The same of a port of another client.
bool finds_port(JackSearch search, const std::string& client, const std::string& port) {
  return port.find(search == JackSearch::Anywhere ? client : client + ":") != std::string::npos;
}

/// How many ports of one direction a client has; empty where the library would open those of others instead.
std::optional<int> own_ports(const std::vector<JackPort>& ports, bool takes, JackSearch search,
                             const std::string& client) {
  int own = 0;
  bool others_first = false, others = false;
  for (const auto& port : ports) {
    if (port.takes != takes || !finds_port(search, client, port.name)) continue;
    const bool is_own = port.name.starts_with(client + ":");
    own += is_own ? 1 : 0;
    others_first = others_first || (is_own && others);
    others = others || !is_own;
  }
  const bool exchanged = search == JackSearch::Anywhere ? others_first : others;
  return own > 0 && exchanged ? std::nullopt : std::optional{own};
}

}  // namespace

std::optional<std::vector<JackPort>> jack_ports() {
#if defined(TACTUS_HAS_JACK)
  silence_library_logs();
  std::vector<JackPort> ports;
  auto* const client = jack_client_open("tactus-ports", JackNoStartServer, nullptr);
  if (client == nullptr) return ports;
  if (const char** const names = jack_get_ports(client, nullptr, JACK_DEFAULT_AUDIO_TYPE, 0)) {
    for (auto name = names; *name != nullptr; ++name)
      if (const auto* const port = jack_port_by_name(client, *name))
        ports.push_back({*name, (jack_port_flags(port) & JackPortIsInput) != 0});
    jack_free(names);
  }
  jack_client_close(client);
  return ports;
#else
  return std::nullopt;
#endif
}

bool is_regular_expression(const std::string& client) {
  return client.find_first_of(".()[]+*?|^${}\\") != std::string::npos;
}

std::vector<Device> own_ports_only(std::vector<Device> devices, JackSearch search,
                                   const std::optional<std::vector<JackPort>>& ports) {
  const auto clients = std::stable_partition(devices.begin(), devices.end(),
                                             [](const Device& one) { return one.api != kApi; });
  std::vector<Device> usable{devices.begin(), clients};
  // What a name matches besides its own client has a longer name, or is the same client, whose ports do not
  // lie together and which is there twice.
  std::stable_sort(clients, devices.end(), [](const Device& a, const Device& b) {
    return a.library_name.size() > b.library_name.size();
  });
  for (auto one = clients; one != devices.end(); ++one) {
    bool own = !is_regular_expression(one->library_name);
    for (auto other = clients; other != one; ++other) {
      if (!finds(search, one->library_name, other->library_name)) continue;
      // Of a name that is a regular expression the number of channels is not known.
      own = own && search == JackSearch::Anywhere && one->index < other->index &&
            !is_regular_expression(other->library_name);
      if (other->library_name == one->library_name) continue;
      one->in_channels -= other->in_channels;
      one->out_channels -= other->out_channels;
    }
    if (own && ports) {
      const auto gives = own_ports(*ports, false, search, one->library_name),
                 takes = own_ports(*ports, true, search, one->library_name);
      own = gives && takes;
      one->in_channels = gives.value_or(0);
      one->out_channels = takes.value_or(0);
    }
    if (own && one->in_channels + one->out_channels > 0) usable.push_back(*one);
  }
  std::sort(usable.begin(), usable.end(), [](const Device& a, const Device& b) { return a.index < b.index; });
  return usable;
}

bool is_jack_client_of_library(const std::string& id) { return id.find(kMark) != std::string::npos; }

bool is_left_out(const std::string& id, const std::vector<Device>& listed) {
  // JACK's own backend lists every client.
  if (std::any_of(listed.begin(), listed.end(), [](const Device& one) { return one.api.empty(); }))
    return false;
  const auto client = is_jack_client_of_library(id) ? id.substr(id.find(kMark) + kMark.size()) : id;
  const bool is_name = !client.empty() && client.find(':') == std::string::npos;
  return is_name && std::any_of(listed.begin(), listed.end(), [&](const Device& one) {
           return one.api == kApi &&
                  (is_regular_expression(client) || finds(JackSearch::Anywhere, client, one.library_name));
         });
}

}  // namespace tactus
