#include "remote/osc/osc_query.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "remote/osc/osc_host.h"

namespace tactus {
namespace {

using Json = nlohmann::json;

enum Access { kRead = 1, kWrite = 2 };

/// Adds a node at an address, and the folders on the way to it.
void add(Json& root, const std::string& address, Json node) {
  auto* at = &root;
  for (std::size_t begin = 1; begin <= address.size();) {
    const auto end = std::min(address.find('/', begin), address.size());
    auto& contents = (*at)["CONTENTS"];
    at = &contents[address.substr(begin, end - begin)];
    (*at)["FULL_PATH"] = address.substr(0, end);
    if (!at->contains("ACCESS")) (*at)["ACCESS"] = 0;
    begin = end + 1;
  }
  at->update(node);
}

Json method(int access, const char* type, const std::string& description) {
  return {{"ACCESS", access}, {"TYPE", type}, {"DESCRIPTION", description}};
}

Json reading(double value, const std::string& unit, const std::string& description) {
  auto node = method(kRead, "f", description);
  node["VALUE"] = Json::array({value});
  if (!unit.empty()) node["UNIT"] = Json::array({unit});
  return node;
}

void add_controls(Json& root, const RemoteDescription& description) {
  for (const auto& control : description.controls) {
    const auto& unit = control.unit;
    const std::string about = (control.about.empty() ? "" : control.about + "; ") +
                              (control.constant ? "cannot be changed during playback"
                                                : "a second argument is the duration of a ramp in seconds");
    auto node = reading(unit.from_si(control.value), control.unit_name, about);
    node["ACCESS"] = control.constant ? kRead : kRead | kWrite;
    Json range = Json::object();
    if (std::isfinite(control.low)) range["MIN"] = unit.from_si(control.low);
    if (std::isfinite(control.high)) range["MAX"] = unit.from_si(control.high);
    node["RANGE"] = Json::array({range});
    node["CLIPMODE"] = Json::array({"both"});
    add(root, "/control/" + control.name, node);
    if (!control.constant)
      add(root, "/trigger/" + control.name, method(kWrite, "N", "the control is 1 for one frame"));
  }
  for (const auto& gesture : description.gestures) {
    add(root, "/gesture/" + gesture, method(kWrite, "f", "the signal of a gesture of the plant"));
    add(root, "/trigger/" + gesture, method(kWrite, "N", "the gesture once"));
  }
}

void add_readings(Json& root, const RemoteTarget& remote, const RemoteDescription& description) {
  using Kind = OscReading::Kind;
  for (const auto& entry : osc_readings(description)) {
    if (entry.kind == Kind::Control) continue;
    const bool level = entry.kind == Kind::Input || entry.kind == Kind::Output;
    auto node = method(kRead, "f",
                       level ? "the highest sample since the last message, full scale = 1; subscribe to it"
                       : entry.kind == Kind::Guard ? "frames that this stage of the guard has changed"
                       : entry.kind == Kind::Load  ? "share of a block's time in use, 99.9th percentile"
                       : entry.kind == Kind::Late  ? "bundles that came after the time of their tag"
                                                   : "1 or 0");
    if (entry.kind == Kind::Armed) node["VALUE"] = Json::array({remote.armed() ? 1.0 : 0.0});
    if (entry.kind == Kind::Muted) node["VALUE"] = Json::array({remote.muted() ? 1.0 : 0.0});
    add(root, entry.address, node);
  }
}

void add_orders(Json& root, const RemoteDescription& description) {
  for (const auto& [address, type, about] :
       {std::tuple{"/arm/request", "N", "answered with /arm/number and a number"},
        {"/arm", "i", "arms the drives: the number of the answer, within 3 s; then send /alive every 100 ms"},
        {"/alive", "N", "without it for 500 ms the drives that this client armed fade and are disarmed"},
        {"/disarm", "N", "fades the drives and disarms them, at once"},
        {"/mute", "i", "1 or nothing mutes, 0 takes it back"},
        {"/preset/recall", "sf", "a preset and the duration of a ramp in seconds"},
        {"/preset/save", "s", "the values of all controls under a name"},
        {"/subscribe", "sf", "an address pattern and a rate, 1 to 100 Hz"},
        {"/unsubscribe", "s", "a pattern; without it all subscriptions end"},
        {"/list", "N",
         "answered with /list/control for every control: name, value, low, high, unit, constant"}})
    add(root, address, method(kWrite, type, about));
  for (const auto* event : {"/event/message", "/event/guard"})
    add(root, event, method(kRead, "is", "frame and text; subscribe to it"));
  for (const auto* event : {"/event/armed", "/event/muted"})
    add(root, event, method(kRead, "ii", "frame, and 1 or 0; subscribe to it"));
  for (const auto& event : description.events)
    add(root, osc_event(event), method(kRead, "if", "frame, and how strong it was; subscribe to it"));
}

Json tree(const RemoteTarget& remote) {
  const auto description = remote.description();
  Json root = {{"FULL_PATH", "/"},
               {"ACCESS", 0},
               {"DESCRIPTION", description->instrument},
               {"CONTENTS", Json::object()}};
  add_controls(root, *description);
  add_readings(root, remote, *description);
  add_orders(root, *description);
  return root;
}

Json host_info(const RemoteTarget& remote, int port) {
  return {{"NAME", remote.description()->instrument},
          {"OSC_PORT", port},
          {"OSC_TRANSPORT", "UDP"},
          {"EXTENSIONS",
           {{"ACCESS", true},
            {"VALUE", true},
            {"RANGE", true},
            {"DESCRIPTION", true},
            {"UNIT", true},
            {"CLIPMODE", true},
            {"LISTEN", false}}}};
}

const Json* find(const Json& root, std::string_view path) {
  const auto* at = &root;
  while (path.starts_with('/')) path.remove_prefix(1);
  while (!path.empty()) {
    const auto part = std::string{path.substr(0, path.find('/'))};
    const auto contents = at->find("CONTENTS");
    if (contents == at->end() || !contents->contains(part)) return nullptr;
    at = &(*contents)[part];
    path.remove_prefix(std::min(path.size(), part.size() + 1));
  }
  return at;
}

/// Names come from a file: bytes that are no UTF-8 are replaced.
std::string text(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace); }

}  // namespace

HttpAnswer osc_query(const RemoteTarget& remote, std::string_view target, int port) {
  const auto question = std::min(target.find('?'), target.size());
  const auto attribute = std::string{target.substr(std::min(question + 1, target.size()))};
  if (attribute == "HOST_INFO") return {200, text(host_info(remote, port))};
  const auto root = tree(remote);
  const auto* node = find(root, target.substr(0, question));
  if (node == nullptr) return {404};
  if (attribute.empty()) return {200, text(*node)};
  if (!node->contains(attribute)) return {204};
  return {200, text({{attribute, (*node)[attribute]}})};
}

HttpAnswer answer_http(const RemoteTarget& remote, std::string_view head, int port) {
  const auto line = head.substr(0, head.find('\r'));
  if (!line.starts_with("GET /")) return {line.starts_with("GET ") ? 400 : 405};
  const auto target = line.substr(4);
  const auto end = target.find(' ');
  if (end == std::string_view::npos) return {400};
  return osc_query(remote, target.substr(0, end), port);
}

std::string http_bytes(const HttpAnswer& answer) {
  const char* reason = answer.status == 200   ? "OK"
                       : answer.status == 204 ? "No Content"
                       : answer.status == 404 ? "Not Found"
                       : answer.status == 405 ? "Method Not Allowed"
                                              : "Bad Request";
  return fmt::format(
      "HTTP/1.1 {} {}\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
      answer.status, reason, answer.body.size(), answer.body);
}

}  // namespace tactus
