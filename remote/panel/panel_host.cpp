#include "remote/panel/panel_host.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine/rig/preset.h"
#include "remote/panel/panel_messages.h"

namespace tactus {
namespace {

using Json = nlohmann::json;
using namespace std::chrono_literals;

constexpr std::size_t kMostScopeChunks = 64;  // in a tick
constexpr int kMostBin = 1 << 20;
constexpr double kLongestRamp_s = 3600.0, kLongestDelay_s = 1.0;
constexpr auto kStateInterval = 50ms;

}  // namespace

/// One order of a client.
struct PanelHost::Message {
  int number;
  Client& client;
  const Json& json;
  Clock::time_point now;

  std::string text(const char* key) const {
    const auto found = json.find(key);
    return found != json.end() && found->is_string() ? found->get<std::string>() : std::string{};
  }
  std::optional<double> value(const char* key) const {
    const auto found = json.find(key);
    if (found == json.end() || !found->is_number()) return std::nullopt;
    const auto value = found->get<double>();
    return std::isfinite(value) ? std::optional{value} : std::nullopt;
  }
  bool flag(const char* key) const {
    const auto found = json.find(key);
    return found == json.end() || !found->is_boolean() || found->get<bool>();
  }
};

PanelHost::PanelHost(RemoteTarget& target, Sender sender, bool arm_from_elsewhere)
    : target_(target), sender_(std::move(sender)), arm_from_elsewhere_(arm_from_elsewhere) {}

PanelHost::~PanelHost() = default;

// Clients.

void PanelHost::connected(int client, bool local) {
  clients_[client].local = local;
  if (description_ == nullptr) description_ = target_.description();
  sender_.text(client, description_text(*description_));
  if (edit_ != nullptr) sender_.text(client, edit_text(*edit_));
}

void PanelHost::disconnected(int client) {
  clients_.erase(client);
  if (owner_ == client) {
    target_.disarm();
    owner_.reset();
  }
  if (scope_client_ == client) {
    target_.order_scope(0, 1, {});
    scope_client_.reset();
  }
  if (level_clients_.erase(client) > 0 && level_clients_.empty()) target_.order_levels(false);
  if (body_clients_.erase(client) > 0 && body_clients_.empty()) target_.watch_bodies({});
}

void PanelHost::received(int number, std::string_view text, Clock::time_point now) {
  const auto found = clients_.find(number);
  if (found == clients_.end()) return;
  ++counts_.messages;
  const auto json = text.size() > kLongestMessage ? Json(Json::value_t::discarded)
                                                  : Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const Message message{number, found->second, json, now};
  const auto act = json.is_object() ? act_of(message.text("do")) : nullptr;
  // What stops the drives is never one too many.
  const bool stops = act == &PanelHost::disarm || act == &PanelHost::mute || act == &PanelHost::alive;
  if (!stops && found->second.messages_left < 1) return void(++counts_.refused);
  found->second.messages_left -= 1;
  if (act == nullptr) return error(message, "this is no order");
  (this->*act)(message);
}

PanelHost::Act PanelHost::act_of(std::string_view name) {
  static constexpr std::pair<std::string_view, Act> kOrders[] = {
      {"set", &PanelHost::set},          {"trigger", &PanelHost::trigger},
      {"gesture", &PanelHost::gesture},  {"arm_request", &PanelHost::request_arm},
      {"arm", &PanelHost::arm},          {"alive", &PanelHost::alive},
      {"disarm", &PanelHost::disarm},    {"mute", &PanelHost::mute},
      {"scope", &PanelHost::scope},      {"levels", &PanelHost::levels},
      {"bodies", &PanelHost::bodies},    {"delay", &PanelHost::judge},
      {"preset_save", &PanelHost::save}, {"preset_recall", &PanelHost::recall},
      {"learn", &PanelHost::learn},
  };
  for (const auto& [order, act] : kOrders)
    if (order == name) return act;
  return nullptr;
}

// Orders.

/// nullptr, with an error: there is none that can be changed.
const RemoteControl* PanelHost::control_of(const Message& message) {
  const auto name = message.text("name");
  const int place = description_->find_control(name);
  if (place < 0) return error(message, fmt::format("there is no control '{}'", name)), nullptr;
  const auto& control = description_->controls[static_cast<std::size_t>(place)];
  if (control.constant) return error(message, control.name + " cannot be changed during playback"), nullptr;
  return &control;
}

void PanelHost::set(const Message& message) {
  const auto* control = control_of(message);
  if (control == nullptr) return;
  const auto value = message.value("value");
  const double ramp_s = message.value("ramp").value_or(0.0);
  const auto si = value ? control->unit.to_si(*value) : std::numeric_limits<double>::infinity();
  if (!std::isfinite(si)) return error(message, control->name + ": give a number");
  if (!(ramp_s >= 0 && ramp_s <= kLongestRamp_s))
    return error(message, control->name + ": a ramp takes 0 to 3600 s");
  post(message, {.number = control->number,
                 .value = std::clamp(si, control->low, control->high),
                 .ramp_s = ramp_s,
                 .received = {}});
}

void PanelHost::trigger(const Message& message) {
  if (const int gesture = description_->find_gesture(message.text("name")); gesture >= 0)
    return post(message, {.kind = RemoteOrder::Kind::Strike, .number = gesture, .received = {}});
  if (const auto* control = control_of(message))
    post(message, {.kind = RemoteOrder::Kind::Trigger, .number = control->number, .received = {}});
}

void PanelHost::gesture(const Message& message) {
  const int gesture = description_->find_gesture(message.text("name"));
  const auto value = message.value("value");
  if (gesture < 0 || !value) return error(message, "give the name of a gesture, and a number");
  post(message, {.kind = RemoteOrder::Kind::Gesture, .number = gesture, .value = *value, .received = {}});
}

void PanelHost::post(const Message& message, RemoteOrder order) {
  order.received = message.now;
  if (!target_.post({&order, 1})) return error(message, "too many changes wait: this one is dropped");
  ++counts_.orders;
}

void PanelHost::request_arm(const Message& message) {
  if (!may_arm(message.client)) return error(message, "arming from another host needs --panel-arm");
  sender_.text(message.number,
               answer_text("arm_request", message.client.arming.begin(target_, random_(), message.now)));
}

void PanelHost::arm(const Message& message) {
  if (!may_arm(message.client)) return error(message, "arming from another host needs --panel-arm");
  const auto arming = message.client.arming.arm(target_, message.value("number"), message.now);
  if (!arming) return error(message, "not armed: " + to_string(arming.error()));
  owner_ = message.number;
  arming_ = *arming;
  owner_armed_ = false;
  const RemoteOrder order{.kind = RemoteOrder::Kind::Arm, .received = message.now};
  if (target_.post({&order, 1})) return;
  target_.disarm();
  error(message, "not armed: too many changes wait");
}

void PanelHost::alive(const Message& message) {
  if (owner_ == message.number) target_.keep_alive(arming_);
}

void PanelHost::disarm(const Message&) { target_.disarm(); }

/// Only a plain `false` takes it back, which is as much as arming.
void PanelHost::mute(const Message& message) {
  const bool on = message.flag("on");
  if (on || may_arm(message.client)) return target_.mute(on);
  error(message, "unmuting from another host needs --panel-arm");
}

/// There is one scope: the last client that asks has it.
void PanelHost::scope(const Message& message) {
  std::vector<std::string> names;
  if (const auto signals = message.json.find("signals"); signals != message.json.end() && signals->is_array())
    for (const auto& name : *signals)
      if (name.is_string() && names.size() < ScopeChunk::kMostTraces)
        names.push_back(name.get<std::string>());
  const double bin = std::clamp(message.value("bin").value_or(1.0), 1.0, double{kMostBin});
  const double id = message.value("id").value_or(0.0);
  if (!(id >= 0 && id < 4294967296.0)) return error(message, "an id is a number from 0 to 4294967295");
  if (scope_client_ && *scope_client_ != message.number)
    sender_.text(*scope_client_, error_text("scope", "another panel has taken the scope"));
  scope_client_ = message.number;
  target_.order_scope(static_cast<std::uint32_t>(id), static_cast<int>(bin), std::move(names));
}

void PanelHost::levels(const Message& message) {
  const bool before = !level_clients_.empty();
  if (message.flag("on"))
    level_clients_.insert(message.number);
  else
    level_clients_.erase(message.number);
  if (before == level_clients_.empty()) target_.order_levels(!level_clients_.empty());
}

void PanelHost::bodies(const Message& message) {
  const bool on = message.flag("on");
  if (on && description_->worlds.empty()) return error(message, "there are no rigid bodies");
  if (on)
    body_clients_.insert(message.number);
  else
    body_clients_.erase(message.number);
  target_.watch_bodies({.poses = !body_clients_.empty()});
}

void PanelHost::judge(const Message& message) {
  const auto delay_s = message.value("seconds");
  if (!description_->world_delay_s) return error(message, "there is no simulated world");
  if (!delay_s || !(*delay_s >= 0 && *delay_s <= kLongestDelay_s))
    return error(message, "a delay takes 0 to 1 s");
  target_.order_verdict(*delay_s);
}

void PanelHost::recall(const Message& message) {
  const double ramp_s = message.value("ramp").value_or(0.0);
  if (!(ramp_s >= 0 && ramp_s <= kLongestRamp_s)) return error(message, "a ramp takes 0 to 3600 s");
  request(message, RemoteRequest::Kind::RecallPreset, ramp_s);
}

void PanelHost::save(const Message& message) { request(message, RemoteRequest::Kind::SavePreset, 0.0); }

void PanelHost::learn(const Message& message) { request(message, RemoteRequest::Kind::Learn, 0.0); }

void PanelHost::request(const Message& message, RemoteRequest::Kind kind, double ramp_s) {
  const auto name = message.text("name");
  if (kind != RemoteRequest::Kind::Learn)
    if (const auto status = check_preset_name(name); !status)
      return error(message, to_string(status.error()));
  if (!target_.request({kind, name, ramp_s})) error(message, "too many requests wait");
}

void PanelHost::error(const Message& message, const std::string& text) {
  ++counts_.refused;
  sender_.text(message.number, error_text(message.json.is_object() ? message.text("do") : "", text));
}

// Messages to the browsers.

void PanelHost::tick(Clock::time_point now) {
  const std::chrono::duration<double> passed = now - std::exchange(refilled_, now);
  for (auto& [number, client] : clients_)
    client.messages_left =
        std::min<double>(kMostMessages, client.messages_left + kMostMessages * std::min(1.0, passed.count()));
  if (owner_) {
    const bool armed = target_.armed();
    if (!armed && std::exchange(owner_armed_, armed)) owner_.reset();
    owner_armed_ = armed;
  }
  describe();
  send_events();
  if (clients_.empty()) return;
  if (now - state_sent_ >= kStateInterval) send_state(now);
  send_scope();
}

void PanelHost::send_all(const std::string& text) {
  for (const auto& [number, client] : clients_) sender_.text(number, text);
}

void PanelHost::describe() {
  if (auto description = target_.description(); description != description_) {
    description_ = std::move(description);
    if (!clients_.empty()) send_all(description_text(*description_));
  }
  if (auto edit = target_.edit(); edit != edit_) {
    edit_ = std::move(edit);
    send_all(edit_text(*edit_));
  }
  if (auto verdict = target_.verdict(); verdict != verdict_) {
    verdict_ = std::move(verdict);
    send_all(verdict_text(*verdict_));
  }
  if (auto scope = target_.scope(); scope != scope_) {
    scope_ = std::move(scope);
    if (scope_client_) sender_.text(*scope_client_, scope_text(*scope_));
  }
}

void PanelHost::send_events() {
  for (RemoteEvent event; target_.take_event(event);) {
    if (event.kind == RemoteEvent::Kind::Impact) continue;
    if (event.kind != RemoteEvent::Kind::NotArmed) {
      send_all(event_text(event));
      continue;
    }
    if (owner_) sender_.text(*owner_, error_text("arm", std::string{"not armed: "} + event.text));
    owner_.reset();
  }
}

void PanelHost::send_state(Clock::time_point now) {
  state_sent_ = now;
  const auto meters = target_.take_meters();
  const auto last_state = target_.state();
  const RemoteState state = last_state ? *last_state : RemoteState{};
  PanelState panel{target_.armed(), target_.muted(), false, !level_clients_.empty()};
  const auto bodies = body_clients_.empty() ? nullptr : target_.bodies();
  for (const auto& [client, unused] : clients_) {
    panel.owner = owner_ == client;
    panel.bodies = body_clients_.contains(client) ? bodies.get() : nullptr;
    sender_.text(client, state_text(*description_, meters, state, panel));
  }
}

void PanelHost::send_scope() {
  ScopeChunk chunk;
  for (std::size_t taken = 0; taken < kMostScopeChunks && target_.take_scope(chunk); ++taken) {
    if (!scope_client_) continue;
    ++counts_.scope_frames;
    sender_.scope(*scope_client_, scope_bytes(chunk));
  }
}

}  // namespace tactus
