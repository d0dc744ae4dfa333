#include "backends/jack_names.h"

#include <algorithm>

namespace tactus {
namespace {

constexpr const char* kApi = "jack";

bool finds(JackSearch search, const std::string& client, const std::string& other) {
  return search == JackSearch::Anywhere ? other.find(client) != std::string::npos : other.ends_with(client);
}

}  // namespace

bool is_regular_expression(const std::string& client) {
  return client.find_first_of(".()[]+*?|^${}\\") != std::string::npos;
}

std::vector<Device> own_ports_only(std::vector<Device> devices, JackSearch search) {
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
    if (own && one->in_channels + one->out_channels > 0) usable.push_back(*one);
  }
  std::sort(usable.begin(), usable.end(), [](const Device& a, const Device& b) { return a.index < b.index; });
  return usable;
}

bool is_left_out(const std::string& id, const std::vector<Device>& listed) {
  // JACK's own backend lists every client.
  if (std::any_of(listed.begin(), listed.end(), [](const Device& one) { return one.api.empty(); }))
    return false;
  const std::string mark = std::string{":"} + kApi + ":";
  const auto at = id.find(mark);
  const auto client = at == std::string::npos ? id : id.substr(at + mark.size());
  const bool is_name = !client.empty() && client.find(':') == std::string::npos;
  return is_name && std::any_of(listed.begin(), listed.end(), [&](const Device& one) {
           return one.api == kApi &&
                  (is_regular_expression(client) || finds(JackSearch::Anywhere, client, one.library_name));
         });
}

}  // namespace tactus
