#include "remote/schedule.h"

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

constexpr double kLeastStep_s = 0.002;  // between the points of a ramp
constexpr std::size_t kMostOutgoing = 1024;

}  // namespace

double RemoteSchedule::MovingControl::value_at(std::int64_t point) const {
  return point >= points ? to
         : decibel       ? Ramp{from, to, 0, points}.decibel_at(point)
                         : Ramp{from, to, 0, points}.at(point);
}

bool RemoteSchedule::add(std::span<const RemoteOrder> bundle) {
  if (bundle.empty()) return true;
  if (orders_ + bundle.size() > kMostWaiting) return false;
  orders_ += bundle.size();
  waiting_.emplace(bundle.front().time_s, Bundle{bundle.begin(), bundle.end()});
  return true;
}

void RemoteSchedule::restart() {
  ramps_.clear();
  free_.clear();
  outgoing_.clear();
  last_ = 0;
}

void RemoteSchedule::advance(const StreamClock& clock, std::int64_t frame, std::int64_t first_free) {
  const auto frames = [this](Seconds time) {
    return static_cast<std::int64_t>(std::llround(time.value * rate_));
  };
  while (!waiting_.empty() && outgoing_.size() < kMostOutgoing) {
    const auto first = waiting_.begin();
    const auto at = frame_of(first->second, clock, first_free);
    if (!at || *at > frame + std::max<std::int64_t>(frames(kAhead), first_free - frame)) break;
    if (first->first != RemoteOrder::kNow && clock.frame_at(first->first) < static_cast<double>(first_free))
      ++late_;
    for (const auto& order : first->second) apply(order, *at);
    orders_ -= first->second.size();
    waiting_.erase(first);
  }
  advance_ramps(std::max(first_free, frame + frames(kRampAhead)), first_free);
  post(first_free);
}

/// Nothing: its frame is not known yet.
std::optional<std::int64_t> RemoteSchedule::frame_of(const Bundle& bundle, const StreamClock& clock,
                                                     std::int64_t first_free) {
  auto frame = std::max(first_free, last_);
  for (const auto& order : bundle)
    if (order.kind == RemoteOrder::Kind::Trigger && free_.contains(order.number))
      frame = std::max(frame, free_[order.number]);
  const double time_s = bundle.front().time_s;
  if (time_s == RemoteOrder::kNow) return frame;
  if (!clock.known()) return std::nullopt;
  return std::max<std::int64_t>(frame, std::llround(clock.frame_at(time_s)));
}

void RemoteSchedule::apply(const RemoteOrder& order, std::int64_t frame) {
  using Kind = RemoteOrder::Kind;
  if (order.kind == Kind::Gesture) return target_.gesture(order.number, order.value);
  const auto control = target_.control(order.number);
  if (!control) return;
  if (order.kind == Kind::Trigger) return pulse(order.number, *control, frame);
  if (order.kind != Kind::Set) return;
  if (order.ramp_s > 0) return begin_ramp(order, *control, frame);
  ramps_.erase(order.number);
  change(order.number, std::clamp(order.value, control->low, control->high), frame);
}

void RemoteSchedule::begin_ramp(const RemoteOrder& order, const ScheduledControl& control,
                                std::int64_t frame) {
  const double step_s = std::max(control.smooth_s, kLeastStep_s);
  MovingControl ramp{control.value, std::clamp(order.value, control.low, control.high), control.decibel,
                     frame};
  ramp.points = std::max<std::int64_t>(1, static_cast<std::int64_t>(order.ramp_s / step_s));
  ramp.step =
      std::max<std::int64_t>(1, std::llround(order.ramp_s * rate_ / static_cast<double>(ramp.points)));
  ramp.last_value = control.value;
  ramps_[order.number] = ramp;
}

void RemoteSchedule::change(int number, double value, std::int64_t frame) {
  target_.note(number, value);
  emit({frame, JournalEntry::Kind::ControlChange, number, value});
}

void RemoteSchedule::pulse(int number, const ScheduledControl& control, std::int64_t frame) {
  for (const int value : {1, 0})
    emit({frame + 1 - value, JournalEntry::Kind::ControlSet, number,
          std::clamp<double>(value, control.low, control.high)});
  free_[number] = frame + 2;
}

void RemoteSchedule::advance_ramps(std::int64_t until, std::int64_t first_free) {
  for (auto next = ramps_.begin(); next != ramps_.end();) {
    const auto ramp = next++;
    if (advance(ramp->first, ramp->second, until, first_free)) ramps_.erase(ramp);
  }
}

/// True: it has ended.
bool RemoteSchedule::advance(int number, MovingControl& ramp, std::int64_t until, std::int64_t first_free) {
  while (ramp.next < ramp.points && outgoing_.size() < kMostOutgoing) {
    const auto frame = ramp.start + ramp.next * ramp.step;
    if (frame > until) return false;
    const auto control = target_.control(number);
    if (!control || control->value != ramp.last_value) return true;  // somebody else moved it
    ramp.last_value = std::clamp(ramp.value_at(++ramp.next), control->low, control->high);
    change(number, ramp.last_value, std::max(frame, first_free));
  }
  return ramp.next >= ramp.points;
}

void RemoteSchedule::emit(const JournalEntry& entry) {
  const auto behind = std::upper_bound(outgoing_.begin(), outgoing_.end(), entry,
                                       [](const auto& a, const auto& b) { return a.frame < b.frame; });
  outgoing_.insert(behind, entry);
  last_ = std::max(last_, entry.frame);
}

/// What had no room before keeps its distances.
void RemoteSchedule::post(std::int64_t first_free) {
  if (!outgoing_.empty() && outgoing_.front().frame < first_free) {
    const auto by = first_free - outgoing_.front().frame;
    for (auto& entry : outgoing_) entry.frame += by;
    last_ += by;
  }
  while (!outgoing_.empty() && target_.post(outgoing_.front())) outgoing_.pop_front();
}

}  // namespace tactus
