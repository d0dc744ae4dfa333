#include "engine/runtime/running.h"

#include <algorithm>
#include <cmath>

namespace tactus {

Running::Running(std::unique_ptr<Plan> made, int max_frames)
    : plan(std::move(made)),
      faults(plan->vertices.size()),
      step_ns(plan->steps.size(), 0.0),
      silent_until(plan->steps.size(), 0) {
  for (std::size_t i = 0; i < plan->channels.size(); ++i)
    (plan->channels[i].use == OutputUse::Tap ? tap_channels : outputs).push_back(static_cast<int>(i));
  for (const int channel : outputs) output_signals.push_back(&plan->channels[index(channel)].signal);
  for (std::size_t c = 0; c < outputs.size(); ++c) vectorised.push_back(begins_lanes(c));
  for (const auto& step : plan->steps) {
    moved_in.resize(std::max(moved_in.size(), index(step.inputs)));
    moved_out.resize(std::max(moved_out.size(), index(step.outputs)));
  }
  for (const auto& planned : plan->controls) {
    control_of.push_back(static_cast<int>(controls.size()));
    control_names.push_back(planned.control.name);
    controls.push_back({{}, planned.buffer, planned.readers, planned.control.unit.decibel});
  }
  has_own_rates_ = plan->divisors.size() > 1;
  for (std::size_t c = 0; c < plan->input_buffers.size(); ++c)
    if (const auto& to = plan->input_buffers[c]; to.data != nullptr && to.stride == 1)
      loaded_inputs.push_back({static_cast<int>(c), to.data});
  for (const int divisor : plan->divisors) dividers.push_back({divisor, 0, 0, {}});
  start(max_frames);
}

std::uint64_t Running::next_number() noexcept {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

bool Running::begins_lanes(std::size_t output) const {
  if (output + kVectorWidth > outputs.size()) return false;
  const auto signal = [&](std::size_t c) { return *output_signals[c]; };
  const double* first = signal(output).data;
  for (std::size_t lane = 0; lane < kVectorWidth; ++lane)
    if (const auto s = signal(output + lane); s.stride != kVectorWidth || s.data != first + lane)
      return false;
  return true;
}

void Running::start(int max_frames) {
  taps.assign(tap_channels.size(), std::vector<double>(index(max_frames), 0.0));
  std::fill_n(plan->arena.data(), plan->signal_doubles, 0.0);
  if (plan->system_delay != nullptr) set_system_delay(plan->system_delay_at_start);
  for (auto& node : plan->nodes) node->reset();
  std::fill(silent_until.begin(), silent_until.end(), 0);
  quiet_from = 0;
  for (std::size_t i = 0; i < controls.size(); ++i) {
    controls[i].value = Ramp::constant(plan->controls[i].control.value);
    settle(controls[i], true);
  }
  for (auto& ramp : ramps) {
    ramp.control.value = Ramp::constant(ramp.control.value.to);
    settle(ramp.control, true);
  }
  at_rest.assign(plan->can_rest.size(), 0);
  computed_in.assign(plan->can_rest.size(), 0);
  for (std::size_t i = 0; i < at_rest.size(); ++i) settle(static_cast<int>(i), false);
  for (auto& count : faults) count.store(0, std::memory_order_relaxed);
}

void Running::move_control(std::size_t control, std::int64_t now, double target,
                           std::int64_t least_frames) noexcept {
  const auto& planned = plan->controls[control];
  if (planned.frozen) return;
  const auto& range = planned.control.range;
  const auto frames =
      static_cast<std::int64_t>(std::lround(planned.control.smooth_s * plan->sample_rate.value));
  auto& smoothed = controls[control];
  smoothed.value = {smoothed.at(now), std::clamp(target, range.low, range.high), now,
                    std::max(frames, least_frames)};
  settle(smoothed, false);
}

void Running::set_control(std::size_t control, double value) noexcept {
  const auto& planned = plan->controls[control];
  if (planned.frozen) return;
  const auto& range = planned.control.range;
  controls[control].value = Ramp::constant(std::clamp(value, range.low, range.high));
  settle(controls[control], true);
}

void Running::set_system_delay(Seconds delay) noexcept {
  std::fill_n(plan->system_delay, kVectorWidth, delay.value);
  ++settings;
}

void Running::take_over(Running& before, std::int64_t now, std::int64_t fade_frames) noexcept {
  auto &nodes = plan->nodes, &old = before.plan->nodes;
  for (const auto [from, to] : handover.remade) nodes[index(to)]->adopt(*old[index(from)]);
  for (const auto [from, to] : handover.copies) nodes[index(to)]->copy(*old[index(from)]);
  for (const auto [from, to] : handover.nodes) std::swap(nodes[index(to)], old[index(from)]);
  plan->point_at_nodes();
  if (plan->system_delay != nullptr && before.plan->system_delay != nullptr)
    std::copy_n(before.plan->system_delay, kVectorWidth, plan->system_delay);
  take_values(before, now, fade_frames);
}

void Running::take_values(const Running& before, std::int64_t now, std::int64_t fade_frames) noexcept {
  for (const auto [from, to] : handover.silences) silence(to, before.silent_until[index(from)]);
  for (std::size_t i = 0; i < handover.controls.size(); ++i) {
    const auto [from, to] = handover.controls[i];
    const auto c = index(to);
    const double of_the_file = plan->controls[c].control.value;
    const auto& range = plan->controls[c].control.range;
    controls[c].value = before.controls[index(from)].value;
    const double target = handover.new_value[i] ? of_the_file : controls[c].value.to;
    if (handover.new_value[i] || !range.contains(target))
      move_control(c, now, target, fade_frames);
    else
      settle(controls[c], controls[c].value.done(now));
  }
  for (auto& ramp : ramps) {
    auto& value = ramp.control.value;
    const auto start = value;
    if (ramp.before >= 0) value = before.ramps[index(ramp.before)].control.value;
    if (ramp.before < 0 || value.to != start.to)
      value = {ramp.before < 0 ? start.from : value.at(now), start.to, now, fade_frames};
    settle(ramp.control, value.done(now));
  }
}

void Running::settle(SmoothedControl& control, bool resting) noexcept {
  moving_ += static_cast<int>(control.resting) - static_cast<int>(resting);
  control.resting = resting;
  ++settings;
  if (control.buffer == nullptr) return;
  if (resting) std::fill_n(control.buffer, kVectorWidth, control.value.to);
  set_strides(control.readers, resting ? 0 : 1);
}

void Running::settle(int can_rest, bool rests) noexcept {
  at_rest[index(can_rest)] = rests;
  set_strides(plan->can_rest[index(can_rest)], rests ? 0 : 1);
}

void Running::set_strides(const Readers& readers, int stride) noexcept {
  for (const int slot : readers.slots) plan->inputs[index(slot)].stride = stride;
  for (const int channel : readers.channels) plan->channels[index(channel)].signal.stride = stride;
}

void Running::advance_what_moves(std::int64_t now, int frames) noexcept {
  for (std::size_t d = 1; d < dividers.size(); ++d) dividers[d].begin(now, frames);
  for (auto& control : controls)
    if (!control.resting) advance(control, nullptr, now, frames);
  for (auto& ramp : ramps) {
    const auto* divider = ramp.divider == 0 ? nullptr : &dividers[index(ramp.divider)];
    if (!ramp.control.resting) advance(ramp.control, divider, now, frames);
  }
}

/// `divider`: of its reader; nullptr for none.
void Running::advance(SmoothedControl& control, const RateDivider* divider, std::int64_t now,
                      int frames) noexcept {
  if (control.value.done(now)) return settle(control, true);
  if (control.buffer == nullptr) return;
  const int samples = divider == nullptr ? frames : divider->count(frames);
  for (int i = 0; i < samples; ++i)
    control.buffer[i] = control.at(now + (divider == nullptr ? i : divider->place(i)));
}

}  // namespace tactus
