#include "engine/runtime/step_runner.h"

#include <algorithm>
#include <chrono>

#include "engine/runtime/operations.h"

namespace tactus {
namespace {

using Clock = std::chrono::steady_clock;

double ns_since(Clock::time_point before) {
  return std::chrono::duration<double, std::nano>(Clock::now() - before).count();
}

/// What reading the clock adds to each time that is taken: the least of many.
double clock_ns() {
  static const double least = [] {
    double shortest = 1e300;
    for (int i = 0; i < 1000; ++i) shortest = std::min(shortest, ns_since(Clock::now()));
    return shortest;
  }();
  return least;
}

/// Adds its lifetime to a step's nanoseconds where `kTimed`.
template <bool kTimed>
class StepTimer {
 public:
  explicit StepTimer(double& sum_ns) : sum_ns_(sum_ns) {
    if constexpr (kTimed) before_ = Clock::now();
  }
  ~StepTimer() {
    if constexpr (kTimed) sum_ns_ += ns_since(before_) - clock_ns();
  }

 private:
  double& sum_ns_;
  Clock::time_point before_;
};

std::int64_t end_of_cell(std::int64_t frame) { return frame - frame % kMaxSubBlock + kMaxSubBlock; }

}  // namespace

template <bool kTimed>
void StepRunner::run(std::int64_t now, int frames) noexcept {
  now_ = now;
  for (const auto& section : plan_->sections)
    section.loop ? run_loop<kTimed>(section, frames) : run_straight<kTimed>(section, frames);
}

template void StepRunner::run<false>(std::int64_t, int) noexcept;
template void StepRunner::run<true>(std::int64_t, int) noexcept;

template <bool kTimed>
void StepRunner::run_straight(const Section& section, int frames) noexcept {
  for (int s = section.first_step; s < section.end_step; ++s) {
    const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
    if (plan_->steps[index(s)].kind == Step::Kind::Outside)
      outside_.answer(0, frames);
    else
      run_alone(s, frames);
  }
}

/// A step that lies in no loop.
void StepRunner::run_alone(int s, int frames) noexcept {
  const auto& step = plan_->steps[index(s)];
  auto& silent_until = running_->silent_until[index(s)];
  for (int offset = 0; offset < frames;) {
    if (silent_until > now_ + offset) {
      const auto part = static_cast<int>(std::min<std::int64_t>(silent_until - now_, frames)) - offset;
      silence(step, offset, part);
      offset += part;
      continue;
    }
    const Fault fault = run_step(step, false, offset, frames - offset);
    if (fault.vertex == kSound) return;
    count_fault(fault.vertex);
    reset(step);
    offset += fault.frame;
    silent_until = end_of_cell(now_ + offset);
  }
}

template <bool kTimed>
void StepRunner::run_loop(const Section& section, int frames) noexcept {
  const Step* const steps = plan_->steps.data();
  auto& silent_until = running_->silent_until[index(section.first_step)];
  for (int offset = 0, part = 0; offset < frames; offset += part) {
    // No sub-block lies across the end of a cell, since a silence may end there.
    part = std::min(
        {section.sub_block, frames - offset, static_cast<int>(end_of_cell(now_ + offset) - (now_ + offset))});
    const bool silent = silent_until > now_ + offset;
    Fault first;
    for (int s = section.first_step; s < section.end_step; ++s) {
      const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
      // The world outside misses no frame, or it would be late from here on.
      if (steps[s].kind == Step::Kind::Outside)
        outside_.answer(offset, part);
      else if (silent)
        silence(steps[s], offset, part);
      else if (const Fault fault = run_step(steps[s], true, offset, part); fault.frame < first.frame)
        first = fault;
    }
    if (first.vertex == kSound) continue;
    count_fault(first.vertex);
    silent_until = end_of_cell(now_ + offset);
    for (int s = section.first_step; s < section.end_step; ++s) {
      reset(steps[s]);
      silence(steps[s], offset + first.frame, part - first.frame);
    }
  }
}

StepRunner::Fault StepRunner::run_operations(const Step& step, bool loop, int offset, int frames) noexcept {
  Fault first;
  for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
    const auto& operation = plan_->operations[index(i)];
    const Signal* operands = plan_->inputs.data() + operation.first_in;
    if (operation.can_rest >= 0 && run_at_rest(operation, operands, frames)) continue;
    double* out = operation.out + offset;
    if (offset == 0) {
      run_operation(operation.op, operation.operands, operands, out, frames);
    } else {
      const auto moved = [&](int operand) {
        return Signal{operands[operand].data + offset * operands[operand].stride, operands[operand].stride};
      };
      const Signal all[] = {moved(0), moved(1), operation.operands < 3 ? Signal{} : moved(2)};
      run_operation(operation.op, operation.operands, all, out, frames);
    }
    if (!operation.can_fail || all_finite(out, frames)) continue;
    const int bad = first_nonfinite(out, frames);
    const int cleared = clear_nonfinite(out, frames);
    // Outside loops it remembers nothing, so that only the bad frames themselves are lost.
    if (!loop) count_fault(operation.vertex, cleared);
    if (loop && bad < first.frame) first = {operation.vertex, bad};
  }
  return first;
}

/// False if one of the operands moves.
bool StepRunner::run_at_rest(const MicroOperation& operation, const Signal* operands, int frames) noexcept {
  const bool rests = all_rest(operands, operation.operands);
  if (rests != (running_->at_rest[index(operation.can_rest)] != 0))
    running_->settle(operation.can_rest, rests);
  if (!rests) return false;
  double value = 0;
  run_operation(operation.op, operation.operands, operands, &value, 1);
  if (!is_finite(value)) {
    value = 0;
    count_fault(operation.vertex, frames);
  }
  std::fill_n(operation.out, kVectorWidth, value);
  return true;
}

/// In a loop, what the step gave is made finite from the bad frame on, for the steps that follow.
StepRunner::Fault StepRunner::run_step(const Step& step, bool loop, int offset, int frames) noexcept {
  Fault fault;
  if ((step.divider | step.divider_in | step.divider_out) != 0) {
    fault = run_divided(step, loop, offset, frames);
  } else if (step.kind == Step::Kind::Operations) {
    return run_operations(step, loop, offset, frames);
  } else {
    NodeBlock block{plan_->inputs.data() + step.first_in, plan_->outputs.data() + step.first_out, frames,
                    now_ + offset};
    if (offset > 0) move(step, offset, 1, offset, block);
    fault = run_node(step, block);
  }
  if (loop && fault.vertex != kSound) silence(step, offset + fault.frame, frames - fault.frame);
  return fault;
}

StepRunner::Fault StepRunner::run_node(const Step& step, const NodeBlock& block) noexcept {
  Node& node = *plan_->nodes[index(step.node)];
  if (step.kind == Step::Kind::Absorb) {
    node.absorb(block);
    return {};
  }
  if (step.kind == Step::Kind::Emit)
    node.emit(block);
  else
    node.process(block);
  if (!step.can_fail) return {};
  for (int i = 0; i < step.outputs; ++i)
    if (block.out[i] != nullptr && !all_finite(block.out[i], block.frames * step.width))
      return fault_of(step, block);
  return {};
}

StepRunner::Fault StepRunner::fault_of(const Step& step, const NodeBlock& block) noexcept {
  Fault fault{step.vertex, block.frames};
  for (int i = 0; i < step.outputs; ++i)
    if (block.out[i] != nullptr)
      fault.frame =
          std::min(fault.frame, first_nonfinite(block.out[i], block.frames * step.width) / step.width);
  return fault;
}

/// Operands from frame `from` on, every `apart`th; outputs from frame `to` on.
void StepRunner::move(const Step& step, int from, int apart, int to, NodeBlock& block) noexcept {
  for (int i = 0; i < step.inputs; ++i)
    running_->moved_in[index(i)] = {block.in[i].data + from * block.in[i].stride, apart * block.in[i].stride};
  for (int i = 0; i < step.outputs; ++i)
    running_->moved_out[index(i)] = block.out[i] == nullptr ? nullptr : block.out[i] + to * step.width;
  block.in = running_->moved_in.data();
  block.out = running_->moved_out.data();
}

// Steps of parts with a rate divider run those of their own frames that lie in the sub-block.

/// The fault, if there is one, counts in engine frames.
StepRunner::Fault StepRunner::run_divided(const Step& step, bool loop, int offset, int frames) noexcept {
  const RateDivider* const at = divider(step.divider);
  const int first = at == nullptr ? offset : at->count(offset);
  const int count = at == nullptr ? frames : at->count(offset + frames) - first;
  if (count == 0) return {};
  Fault fault;
  if (step.kind == Step::Kind::Operations) {
    fault = run_operations(step, loop, first, count);
  } else {
    NodeBlock block{plan_->inputs.data() + step.first_in, plan_->outputs.data() + step.first_out, count,
                    at == nullptr ? now_ + offset : at->number + first};
    move_divided(step, at == nullptr ? offset : at->place(first), block);
    fault = run_node(step, block);
  }
  if (fault.vertex != kSound && at != nullptr) fault.frame = at->place(first + fault.frame) - offset;
  return fault;
}

/// What a step reads and writes, each at its own rate, from `offset` into the sub-block on. Of what is faster
/// than itself it reads only the frames that are its own.
void StepRunner::move_divided(const Step& step, int offset, NodeBlock& block) noexcept {
  const auto& divisors = plan_->divisors;
  const int own = divisors[index(step.divider)];
  const int apart = std::max(1, own / divisors[index(step.divider_in)]);
  const RateDivider *const in = divider(step.divider_in), *const out = divider(step.divider_out);
  move(step, in == nullptr ? offset : in->count(offset), apart, out == nullptr ? offset : out->count(offset),
       block);
}

void StepRunner::count_fault(int vertex, int times) noexcept {
  running_->faults[index(vertex)].fetch_add(times, std::memory_order_relaxed);
}

void StepRunner::reset(const Step& step) noexcept {
  if (step.node >= 0) plan_->nodes[index(step.node)]->reset();
}

void StepRunner::silence(const Step& step, int offset, int frames) noexcept {
  if (const RateDivider* const at = divider(step.divider_out)) {
    frames = at->count(offset + frames) - at->count(offset);
    offset = at->count(offset);
  }
  for (int i = step.first_out; i < step.first_out + step.outputs; ++i)
    if (double* out = plan_->outputs[index(i)])
      std::fill_n(out + offset * step.width, frames * step.width, 0.0);
}

}  // namespace tactus
