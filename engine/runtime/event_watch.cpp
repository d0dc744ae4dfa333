#include "engine/runtime/event_watch.h"

#include <algorithm>

#include "engine/runtime/signal_scope.h"

namespace tactus {

namespace {

/// Of a world: the element that the port belongs to; "" of a node.
std::string_view element_of(const OutputPort& port) {
  const auto dot = port.name.rfind('.');
  return std::string_view{port.name}.substr(0, dot == std::string::npos ? 0 : dot);
}

/// A node's bare name means its first output.
std::string event_name(const ScopeSignal& signal, const Plan& plan) {
  auto name = signal.name;
  const auto& ports = plan.vertices[index(signal.vertex)].type->outputs;
  const auto port = "." + signal.port->name;
  if (ports.size() > 1 && signal.port == &ports.front()) name.erase(name.rfind(port), port.size());
  return name;
}

}  // namespace

std::vector<GraphEvent> graph_events(const Plan& plan) {
  std::vector<GraphEvent> events;
  const auto signals = scope_signals(plan);
  for (const auto& signal : signals) {
    if (signal.port == nullptr || signal.port->kind != OutputKind::Trigger || signal.in_part) continue;
    const auto level = std::ranges::find_if(signals, [&](const ScopeSignal& other) {
      return other.vertex == signal.vertex && other.lane == signal.lane && other.port != nullptr &&
             other.port->event_level && element_of(*other.port) == element_of(*signal.port);
    });
    events.push_back(
        {event_name(signal, plan), signal.place, level == signals.end() ? SignalPlace{} : level->place});
  }
  return events;
}

bool EventWatch::choose(std::uint64_t version, const std::vector<GraphEvent>& events) {
  Choice choice{.version = version, .triggers = {}, .levels = {}};
  for (const auto& event : events) {
    if (choice.count == kMostEvents) break;
    choice.triggers[index(choice.count)] = event.trigger;
    choice.levels[index(choice.count++)] = event.level;
  }
  return choices_.push(choice);
}

void EventWatch::observe(const Running& running, std::int64_t now, int frames) noexcept {
  for (Choice choice; choices_.pop(choice);) {
    choice_ = choice;
    restart();
  }
  if (choice_.count == 0 || choice_.version != running.number) return;
  if (now != next_) restart();
  next_ = now + frames;
  const double least = kLeastInterval_s * running.plan->sample_rate.value;
  for (int e = 0; e < choice_.count; ++e) {
    const SignalReader trigger{running, choice_.triggers[index(e)]};
    double& before = before_[index(e)];
    for (int n = 0; n < frames; ++n) {
      const double value = trigger.at(n, before);
      const bool rises = value > 0.5 && before <= 0.5;
      before = value;
      if (!rises || static_cast<double>(now + n - last_[index(e)]) < least) continue;
      last_[index(e)] = now + n;
      WatchedEvent event{choice_.version, e, now + n};
      if (const auto& level = choice_.levels[index(e)]; level.data != nullptr)
        event.level = SignalReader{running, level}.at(n, held_levels_[index(e)]);
      (void)found_.push(event);
    }
    if (const auto& level = choice_.levels[index(e)]; level.data != nullptr)
      held_levels_[index(e)] = SignalReader{running, level}.at(frames - 1, held_levels_[index(e)]);
  }
}

void EventWatch::restart() noexcept {
  before_.fill(0.0);
  held_levels_.fill(0.0);
  last_.fill(kNever);
}

}  // namespace tactus
