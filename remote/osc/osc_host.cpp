#include "remote/osc/osc_host.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/graph/file/quantity.h"
#include "engine/rig/preset.h"

namespace tactus {
namespace {

constexpr std::string_view kControl = "/control/", kTrigger = "/trigger/", kGesture = "/gesture/";
/// By RemoteEvent::Kind; behind the last one is the name of the event.
constexpr std::array kEvents = {"/event/message", "/event/guard", "/event/armed", "/event/muted",
                                "/event/trigger/"};
constexpr std::string_view kDisarm = "/disarm", kMute = "/mute";
constexpr double kLeastRate_hz = 1.0, kMostRate_hz = 100.0, kDefaultRate_hz = 10.0;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-6;  // of a limit, that float32 may be beyond it

std::optional<double> number_of(const OscValue& value) {
  if (const auto* number = std::get_if<double>(&value)) return *number;
  if (const auto* number = std::get_if<std::int64_t>(&value)) return static_cast<double>(*number);
  return std::nullopt;
}

/// The first value as a finite number, or NaN.
double first_number(const std::vector<OscValue>& values) {
  const double number = values.empty() ? kNoNumber : number_of(values.front()).value_or(kNoNumber);
  return std::isfinite(number) ? number : kNoNumber;
}

const std::string* text_of(const OscValue& value) { return std::get_if<std::string>(&value); }

/// SI; numbers are in the control's own unit, and so is a text without one. Nothing: it is no such value.
std::optional<double> si_of(const OscValue& value, const RemoteControl& control) {
  if (const auto number = number_of(value)) return control.unit.to_si(*number);
  const auto* text = text_of(value);
  const auto quantity = text != nullptr ? parse_quantity(*text) : std::nullopt;
  if (!quantity) return std::nullopt;
  if (quantity->bare) return control.unit.to_si(quantity->si);
  if (!(quantity->unit.dimension == control.unit.dimension)) return std::nullopt;
  return converted(quantity->si, quantity->unit.dimension, control.unit.dimension);
}

std::optional<double> seconds_of(const OscValue& value) {
  if (const auto number = number_of(value)) return number;
  const auto* text = text_of(value);
  const auto quantity = text != nullptr ? parse_quantity(*text) : std::nullopt;
  if (!quantity) return std::nullopt;
  const bool time = quantity->unit.dimension == Dimension{.second = 1};
  return quantity->bare || time ? std::optional{quantity->si} : std::nullopt;
}

std::string example_of(const RemoteControl& control) {
  return control.unit_name.empty()
             ? "a number"
             : fmt::format("a number in {0}, or a text with its unit", control.unit_name);
}

std::string underscored(std::string name) {
  std::ranges::replace(name, ' ', '_');
  return name;
}

}  // namespace

std::vector<OscReading> osc_readings(const RemoteDescription& description) {
  using Kind = OscReading::Kind;
  std::vector<OscReading> readings;
  const auto add_all = [&](const auto& names, Kind kind, const auto& address) {
    for (std::size_t i = 0; i < names.size(); ++i) readings.push_back({address(names[i]), kind, i});
  };
  add_all(description.controls, Kind::Control, [](const auto& c) { return "/control/" + c.name; });
  add_all(description.inputs, Kind::Input, [](const auto& name) { return "/level/in/" + name; });
  add_all(description.outputs, Kind::Output, [](const auto& name) { return "/level/out/" + name; });
  std::size_t place = 0;
  for (const auto& output : description.outputs)
    for (const auto& stage : description.guard_stages)
      readings.push_back({"/guard/" + output + "/" + underscored(stage), Kind::Guard, place++});
  for (const auto& [address, kind] : {std::pair{"/load", Kind::Load},
                                      {"/state/armed", Kind::Armed},
                                      {"/state/muted", Kind::Muted},
                                      {"/state/late", Kind::Late}})
    readings.push_back({address, kind});
  return readings;
}

std::string osc_event(const std::string& name) { return kEvents.back() + name; }

OscHost::OscHost(RemoteTarget& target, Send send, bool arm_from_elsewhere)
    : target_(target), send_(std::move(send)), arm_from_elsewhere_(arm_from_elsewhere) {
  renew();
}

// Packets.

void OscHost::receive(const OscPeer& from, std::span<const char> packet, Clock::time_point now,
                      double now_s) {
  ++counts_.packets;
  renew();
  Context context{from, now};
  const auto bundles = parse_osc(packet, now_s);
  if (!bundles) {
    ++counts_.refused_packets;
    if (contains_text(packet, kDisarm)) target_.disarm();
    if (contains_text(packet, kMute)) target_.mute(true);
    return error(context, to_string(bundles.error()));
  }
  (void)find_client(from, now);
  for (const auto& bundle : *bundles) {
    context.orders.clear();
    context.refused = bundle.time_s > now_s + kMostAhead_s;
    if (context.refused) error(context, "a time tag is more than 10 s ahead: the bundle is refused");
    for (const auto& message : bundle.messages) obey(message, context);
    for (auto& order : context.orders) {
      order.time_s = bundle.time_s;
      order.received = now;
    }
    counts_.orders += std::ssize(context.orders);
    if (!context.orders.empty() && !target_.post(context.orders))
      error(context, "too many changes wait: this one is dropped");
  }
}

void OscHost::obey(const OscMessage& message, Context& context) {
  if (obey_at_once(message, context) || context.refused) return;
  const std::string_view address = message.address;
  const auto behind = [&](std::string_view beginning) { return address.substr(beginning.size()); };
  if (address.starts_with(kControl)) return set(behind(kControl), message.values, context);
  if (address.starts_with(kTrigger)) return trigger(behind(kTrigger), message.values, context);
  if (address.starts_with(kGesture)) return gesture(behind(kGesture), message.values, context);
  if (address == "/preset/recall") return preset(RemoteRequest::Kind::RecallPreset, message.values, context);
  if (address == "/preset/save") return preset(RemoteRequest::Kind::SavePreset, message.values, context);
  if (address == "/arm/request") return request_arm(context);
  if (address == "/arm") return arm(message.values, context);
  if (address == "/subscribe") return subscribe(message.values, context);
  if (address == "/unsubscribe") return unsubscribe(message.values, context);
  if (address == "/list") return list(context);
  if (address.starts_with(OscWorld::kBeginning) && OscWorld::has_bodies(*description_))
    return change_world(message, context);
  if (turn(message, context)) return;
  error(context, "there is no message " + message.address);
}

/// Whatever the time tag of the bundle and the state of the control thread.
bool OscHost::obey_at_once(const OscMessage& message, Context& context) {
  if (message.address == kDisarm) return target_.disarm(), true;
  if (message.address == kMute) return obey_mute(message.values, context), true;
  if (message.address != "/alive") return false;
  if (owner_ == context.from) target_.keep_alive(arming_);
  return true;
}

/// Only 0 takes it back, which is as much as arming.
void OscHost::obey_mute(const Values& values, Context& context) {
  const bool on = values.empty() || number_of(values.front()) != 0.0;
  if (on || may_arm(context.from)) return target_.mute(on);
  error(context, "unmuting from another host needs --osc-arm");
}

template <class Act>
void OscHost::each_control(std::string_view name, Context& context, Act act) {
  const auto& controls = description_->controls;
  const int only = description_->find_control(name);
  if (only >= 0) return act(controls[static_cast<std::size_t>(only)]);
  bool any = false;
  if (is_osc_pattern(name))
    for (const auto& control : controls)
      if (matches_osc("/" + std::string{name}, "/" + control.name)) {
        any = true;
        act(control);
      }
  if (!any) error(context, fmt::format("there is no control '{}'", name));
}

void OscHost::set(std::string_view name, const Values& values, Context& context) {
  each_control(name, context, [&](const auto& control) { set_one(control, values, context); });
}

void OscHost::set_one(const RemoteControl& control, const Values& values, Context& context) {
  if (control.constant) return error(context, control.name + " cannot be changed during playback");
  const auto value = values.empty() ? std::nullopt : si_of(values[0], control);
  if (!value || !std::isfinite(*value))
    return error(context, fmt::format("{}: give {}", control.name, example_of(control)));
  const auto ramp_s = values.size() > 1 ? seconds_of(values[1]) : std::optional{0.0};
  if (!ramp_s || !(*ramp_s >= 0 && *ramp_s <= kMostRamp_s))
    return error(context, fmt::format("{}: a ramp takes 0 to {} s", control.name, kMostRamp_s));
  context.orders.push_back({.number = control.number,
                            .value = clamped(control, *value, context),
                            .ramp_s = *ramp_s,
                            .received = {}});
}

/// Messages of a phone or a mixer have addresses of their own; faders go from 0 to 1. False: the message
/// stands for no control.
bool OscHost::turn(const OscMessage& message, Context& context) {
  const double position = first_number(message.values);
  if (std::isnan(position)) return false;
  if (target_.learn_address(message.address)) return true;  // also of one that moves another control
  const auto& controls = description_->controls;
  const auto learnt = std::ranges::find(controls, message.address, &RemoteControl::osc);
  if (learnt == controls.end()) return false;
  context.orders.push_back(
      {.number = learnt->number, .value = learnt->at_position(position), .received = {}});
  return true;
}

/// Reports a value outside of the range, once until one is inside again.
double OscHost::clamped(const RemoteControl& control, double si, Context& context) {
  const double inside = std::clamp(si, control.low, control.high);
  if (std::abs(inside - si) <= kRounding * std::abs(inside)) {
    clamped_.erase(control.number);
  } else if (clamped_.insert(control.number).second) {
    error(context, fmt::format("{}: {}; the nearest value is taken", control.name,
                               limits_text(control.low, control.high, control.unit)));
  }
  return inside;
}

/// Buttons of phones send 1 when they are pressed and 0 when they are released.
void OscHost::trigger(std::string_view name, const Values& values, Context& context) {
  if (!values.empty() && number_of(values[0]) == 0.0) return;
  if (const int gesture = description_->find_gesture(name); gesture >= 0) {
    context.orders.push_back({.kind = RemoteOrder::Kind::Strike, .number = gesture, .received = {}});
    return;
  }
  each_control(name, context, [&](const auto& control) {
    if (control.constant) return error(context, control.name + " cannot be changed during playback");
    context.orders.push_back({.kind = RemoteOrder::Kind::Trigger, .number = control.number, .received = {}});
  });
}

void OscHost::gesture(std::string_view name, const Values& values, Context& context) {
  const int gesture = description_->find_gesture(name);
  const double value = first_number(values);
  if (gesture < 0) return error(context, fmt::format("there is no gesture '{}'", name));
  if (std::isnan(value)) return error(context, fmt::format("{}: give a number", name));
  context.orders.push_back(
      {.kind = RemoteOrder::Kind::Gesture, .number = gesture, .value = value, .received = {}});
}

void OscHost::change_world(const OscMessage& message, Context& context) {
  world_values_.touch(context.now);
  Status done;
  if (!OscWorldValues::is_question(message.address)) {
    done = world_.obey(message, *description_, target_.bodies().get(), context.orders);
  } else {
    if (add_client(context.from, context.now) == nullptr) return error(context, "there are too many clients");
    done = world_values_.ask(context.from, message, world_, *description_, context.now);
  }
  if (!done) error(context, to_string(done.error()));
}

void OscHost::preset(RemoteRequest::Kind kind, const Values& values, Context& context) {
  const auto* name = values.empty() ? nullptr : text_of(values[0]);
  const auto ramp_s = values.size() > 1 ? seconds_of(values[1]) : std::optional{0.0};
  if (name == nullptr || !ramp_s || !(*ramp_s >= 0 && *ramp_s <= kMostRamp_s))
    return error(context, fmt::format("give the name of a preset, and a ramp of 0 to {} s", kMostRamp_s));
  if (const auto status = check_preset_name(*name); !status) return error(context, to_string(status.error()));
  if (!target_.request({kind, *name, *ramp_s})) error(context, "too many requests wait");
}

// Arming.

void OscHost::request_arm(Context& context) {
  if (!may_arm(context.from)) return error(context, "arming from another host needs --osc-arm");
  auto* client = add_client(context.from, context.now);
  if (client == nullptr) return error(context, "there are too many clients");
  answer(context, {"/arm/number", {client->arming.begin(target_, random_(), context.now)}});
}

void OscHost::arm(const Values& values, Context& context) {
  if (!may_arm(context.from)) return error(context, "arming from another host needs --osc-arm");
  auto* client = add_client(context.from, context.now);
  if (client == nullptr) return error(context, "there are too many clients");
  const auto given = values.empty() ? std::nullopt : number_of(values[0]);
  const auto arming = client->arming.arm(target_, given, context.now);
  if (!arming) return error(context, "not armed: " + to_string(arming.error()));
  owner_ = context.from;
  arming_ = *arming;
  owner_armed_ = false;
  // On its own: a time tag does not put it off.
  const RemoteOrder order{.kind = RemoteOrder::Kind::Arm, .received = context.now};
  if (target_.post(std::span{&order, 1})) return;
  target_.disarm();
  error(context, "not armed: too many changes wait");
}

void OscHost::report_armed() {
  if (!owner_ || target_.armed() == owner_armed_) return;
  owner_armed_ = !owner_armed_;
  const OscMessage state{"/armed", {std::int64_t{owner_armed_}}};
  send(*owner_, {&state, 1}, OscBundle::kNow);
  if (!owner_armed_) owner_.reset();
}

// Clients and what they subscribed to.

OscHost::Client* OscHost::find_client(const OscPeer& peer, Clock::time_point now) {
  const auto found = clients_.find(peer);
  if (found == clients_.end()) return nullptr;
  found->second.heard = now;
  return &found->second;
}

OscHost::Client* OscHost::add_client(const OscPeer& peer, Clock::time_point now) {
  if (auto* client = find_client(peer, now)) return client;
  if (clients_.size() >= kMostClients) return nullptr;
  auto& client = clients_[peer];
  client.heard = now;
  return &client;
}

void OscHost::subscribe(const Values& values, Context& context) {
  const auto* pattern = values.empty() ? nullptr : text_of(values[0]);
  const auto rate = values.size() > 1 ? number_of(values[1]) : std::optional{kDefaultRate_hz};
  if (pattern == nullptr || !pattern->starts_with('/') || !rate || !std::isfinite(*rate))
    return error(context, "give /subscribe a pattern, such as /control/*, and a rate in Hz");
  Subscription subscription{
      .pattern = *pattern, .interval = {}, .next = context.now, .events = {}, .readings = {}, .peaks = {}};
  subscription.interval = std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>{1.0 / std::clamp(*rate, kLeastRate_hz, kMostRate_hz)});
  choose_readings(subscription);
  if (subscription.readings.empty() && !subscription.events)
    return error(context, fmt::format("nothing matches '{}'", *pattern));
  auto* client = add_client(context.from, context.now);
  if (client == nullptr) return error(context, "there are too many clients");
  auto& all = client->subscriptions;
  const auto same = std::ranges::find(all, *pattern, &Subscription::pattern);
  if (same == all.end() && all.size() >= kMostSubscriptions)
    return error(context, "there are too many subscriptions of this client");
  if (same != all.end())
    *same = std::move(subscription);
  else
    all.push_back(std::move(subscription));
}

/// Without a pattern: all of them.
void OscHost::unsubscribe(const Values& values, Context& context) {
  auto* client = find_client(context.from, context.now);
  if (client == nullptr) return;
  const auto* pattern = values.empty() ? nullptr : text_of(values[0]);
  std::erase_if(client->subscriptions, [&](const auto& subscription) {
    return pattern == nullptr || subscription.pattern == *pattern;
  });
}

void OscHost::list(Context& context) {
  std::vector<OscMessage> messages;
  for (const auto& control : description_->controls)
    messages.push_back(
        {"/list/control",
         {control.name, control.unit.from_si(control.value), control.unit.from_si(control.low),
          control.unit.from_si(control.high), control.unit_name, std::int64_t{control.constant}}});
  messages.push_back({"/list/end", {std::int64_t{std::ssize(description_->controls)}}});
  if (answers_left_ < 1) return void(++counts_.lost_answers);
  answers_left_ -= 1;
  send(context.from, messages, OscBundle::kNow);
}

/// After an edit there may be other controls.
void OscHost::renew() {
  auto now = target_.description();
  if (now == description_) return;
  description_ = std::move(now);
  readings_ = osc_readings(*description_);
  clamped_.clear();
  for (auto& [peer, client] : clients_)
    for (auto& subscription : client.subscriptions) choose_readings(subscription);
}

void OscHost::choose_readings(Subscription& subscription) const {
  subscription.readings.clear();
  for (std::size_t r = 0; r < readings_.size(); ++r)
    if (covers_osc(subscription.pattern, readings_[r].address)) subscription.readings.push_back(r);
  subscription.events = false;
  for (const auto* event : kEvents) subscription.events |= covers_osc(subscription.pattern, event);
  for (const auto& event : description_->events)
    subscription.events |= covers_osc(subscription.pattern, osc_event(event));
  subscription.peaks.assign(description_->inputs.size() + description_->outputs.size(), 0.0);
}

void OscHost::tick(Clock::time_point now, double now_s) {
  renew();
  const std::chrono::duration<double> passed = now - std::exchange(refilled_, now);
  answers_left_ = std::min<double>(kMostAnswers, answers_left_ + kMostAnswers * passed.count());
  std::erase_if(clients_, [&](const auto& entry) {
    const bool forgotten = now - entry.second.heard > kForgotten;
    if (forgotten) world_values_.forget(entry.first);
    return forgotten;
  });
  report_armed();
  send_events();
  send_world(now);
  send_subscriptions(now, now_s);
}

void OscHost::send_world(Clock::time_point now) {
  if (const auto wanted = world_values_.wanted(now); wanted != watch_) target_.watch_bodies(watch_ = wanted);
  if (!watch_.poses) return;
  const auto bodies = target_.bodies();
  world_values_.tick(world_, *description_, bodies.get(), now,
                     [&](const OscPeer& peer, const OscMessage& message) {
                       send(peer, {&message, 1}, OscBundle::kNow);
                     });
}

void OscHost::send_events() {
  using Kind = RemoteEvent::Kind;
  for (RemoteEvent event; target_.take_event(event);) {
    if (event.kind == Kind::NotArmed) {
      const OscMessage message{"/error", {std::string{"not armed: "} + event.text}};
      if (owner_) send(*owner_, {&message, 1}, OscBundle::kNow);
      owner_.reset();
      continue;
    }
    if (event.kind == Kind::Impact) {
      world_values_.impact(event, world_, *description_, [&](const OscPeer& peer, const OscMessage& message) {
        send(peer, {&message, 1}, OscBundle::kNow);
      });
      continue;
    }
    OscMessage message{kEvents[static_cast<std::size_t>(event.kind)], {event.frame}};
    if (event.kind == Kind::Message || event.kind == Kind::Guard) {
      message.values.emplace_back(std::string{event.text});
    } else if (event.kind == Kind::Trigger) {
      message.address = osc_event(event.text);
      message.values.emplace_back(event.level);
    } else {
      message.values.emplace_back(std::int64_t{event.value});
    }
    for (const auto& [peer, client] : clients_)
      if (std::ranges::any_of(client.subscriptions, [&](const auto& subscription) {
            return subscription.events && covers_osc(subscription.pattern, message.address);
          }))
        send(peer, {&message, 1}, event.time_s);
  }
}

void OscHost::send_subscriptions(Clock::time_point now, double now_s) {
  if (std::ranges::all_of(clients_, [](const auto& entry) { return entry.second.subscriptions.empty(); }))
    return;
  meters_ = target_.take_meters();
  for (auto& [peer, client] : clients_) {
    std::vector<OscMessage> messages;
    for (auto& subscription : client.subscriptions) {
      auto& peaks = subscription.peaks;
      for (std::size_t c = 0; c < peaks.size(); ++c) {
        const auto inputs = meters_.inputs.size();
        peaks[c] = std::max(peaks[c], c < inputs ? meters_.inputs[c] : meters_.outputs[c - inputs]);
      }
      if (now < subscription.next) continue;
      subscription.next = std::max(subscription.next + subscription.interval, now);
      collect(subscription, messages);
      std::ranges::fill(peaks, 0.0);
    }
    if (!messages.empty()) send(peer, messages, now_s);
  }
}

void OscHost::collect(Subscription& subscription, std::vector<OscMessage>& messages) const {
  for (const auto r : subscription.readings)
    messages.push_back({readings_[r].address, {value_of(readings_[r], subscription)}});
}

double OscHost::value_of(const OscReading& reading, const Subscription& subscription) const {
  using Kind = OscReading::Kind;
  switch (reading.kind) {
    case Kind::Control: {
      const auto& control = description_->controls[reading.index];
      return control.unit.from_si(control.value);
    }
    case Kind::Input:
      return subscription.peaks[reading.index];
    case Kind::Output:
      return subscription.peaks[description_->inputs.size() + reading.index];
    case Kind::Guard:
      return reading.index < meters_.guard.size() ? meters_.guard[reading.index] : 0.0;
    case Kind::Load:
      return meters_.load;
    case Kind::Armed:
      return target_.armed() ? 1.0 : 0.0;
    case Kind::Muted:
      return target_.muted() ? 1.0 : 0.0;
    case Kind::Late:
      return static_cast<double>(target_.late());
  }
  return 0.0;
}

// Answers.

void OscHost::error(const Context& context, const std::string& text) {
  answer(context, {"/error", {text.substr(0, kLongestOscText)}});
}

void OscHost::answer(const Context& context, OscMessage message) {
  if (answers_left_ < 1) return void(++counts_.lost_answers);
  answers_left_ -= 1;
  send(context.from, {&message, 1}, OscBundle::kNow);
}

void OscHost::send(const OscPeer& peer, std::span<const OscMessage> messages, double time_s) {
  for (const auto& packet : build_osc(messages, time_s)) {
    ++counts_.answers;
    send_(peer, packet);
  }
}

}  // namespace tactus
