#include "engine/runtime/step_runner.h"

#include <algorithm>
#include <chrono>

#include "engine/core/every_block.h"
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

static_assert((kMaxSubBlock & (kMaxSubBlock - 1)) == 0);
std::int64_t end_of_cell(std::int64_t frame) { return (frame | (kMaxSubBlock - 1)) + 1; }

}  // namespace

/// Its output is what it is to be: one number, since no operand moves.
inline bool StepRunner::is_at_rest(const MicroOperation& operation, int frames) noexcept {
  return running_->computed_in[index(operation.can_rest)] == running_->settings ||
         run_at_rest(operation, frames);
}

inline StepRunner::Fault StepRunner::run_operations(const Step& step, bool loop, int offset,
                                                    int frames) noexcept {
  if (frames == 1) return run_operations_once(step, loop, offset);
  Fault first;
  const auto* const operations = plan_->operations.data() + step.first_operation;
  for (int i = 0; i < step.operations; ++i) {
    const auto& operation = operations[i];
    if (operation.can_rest >= 0 && is_at_rest(operation, frames)) continue;
    double* const out = operation.out + offset;
    if (offset == 0)
      run_operation(operation.op, operation.in, out, frames);
    else
      run_moved(operation, offset, frames);
    if (operation.can_fail && !all_finite(out, frames)) clear(operation, loop, out, frames, first);
  }
  return first;
}

/// One frame of them.
TACTUS_EVERY_BLOCK StepRunner::Fault StepRunner::run_operations_once(const Step& step, bool loop,
                                                                     int offset) noexcept {
  Fault first;
  const auto* operation = plan_->operations.data() + step.first_operation;
  for (const auto* const end = operation + step.operations; operation != end; ++operation) {
    if (operation->can_rest >= 0 && is_at_rest(*operation, 1)) continue;
    const Signal* const in = operation->in;
    const double value = operation->value(in[0][offset], in[1][offset], in[2][offset]);
    operation->out[offset] = value;
    if (!is_finite(value)) [[unlikely]]
      if (operation->can_fail) clear(*operation, loop, operation->out + offset, 1, first);
  }
  return first;
}

/// False: an output is not finite.
[[gnu::always_inline]] inline bool StepRunner::run_node(const Step& step, const NodeBlock& block) noexcept {
  if (step.kind == Step::Kind::Process) {
    step.runs->process(block);
  } else if (step.kind == Step::Kind::Emit) {
    step.runs->emit(block);
  } else {
    step.runs->absorb(block);
    return true;
  }
  if (step.can_fail == 0) return true;
  if (step.can_fail > 1) return gave_finite(step, block);
  return all_finite(block.out[0], block.frames * step.width);
}

/// The same for any outputs.
TACTUS_EVERY_BLOCK bool StepRunner::gave_finite(const Step& step, const NodeBlock& block) noexcept {
  for (int i = 0; i < step.can_fail; ++i)
    if (block.out[i] != nullptr && !all_finite(block.out[i], block.frames * step.width)) return false;
  return true;
}

template <bool kTimed>
TACTUS_EVERY_BLOCK void StepRunner::run(std::int64_t now, int frames) noexcept {
  now_ = now;
  for (const auto& section : plan_->sections)
    section.loop ? run_loop<kTimed>(section, frames) : run_straight<kTimed>(section, frames);
}

template void StepRunner::run<false>(std::int64_t, int) noexcept;
template void StepRunner::run<true>(std::int64_t, int) noexcept;

template <bool kTimed>
void StepRunner::run_straight(const Section& section, int frames) noexcept {
  const Step* const steps = plan_->steps.data();
  const bool all_with_care = running_->quiet_from > now_;
  NodeBlock block{nullptr, nullptr, frames, now_};
  for (int s = section.first_step, end = section.end_step; s < end; ++s) {
    const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
    const auto& step = steps[s];
    block.in = step.in;
    block.out = step.out;
    if (step.with_care || all_with_care) [[unlikely]]
      run_with_care(s, frames);
    else if (step.kind == Step::Kind::Operations)
      run_operations(step, false, 0, frames);
    else if (!run_node(step, block)) [[unlikely]]
      run_silent(s, begin_silence(s, fault_of(step, block), 0), frames);
  }
}

/// A step that lies in no loop.
void StepRunner::run_with_care(int s, int frames) noexcept {
  if (plan_->steps[index(s)].kind == Step::Kind::Outside)
    outside_.answer(0, frames);
  else
    run_silent(s, 0, frames);
}

/// The same from `offset` on, where it may have a fault or have had one.
void StepRunner::run_silent(int s, int offset, int frames) noexcept {
  const auto& step = plan_->steps[index(s)];
  while (offset < frames) {
    if (const auto until = running_->silent_until[index(s)]; until > now_ + offset) {
      const auto part = static_cast<int>(std::min<std::int64_t>(until - now_, frames)) - offset;
      silence(step, offset, part);
      offset += part;
      continue;
    }
    const Fault fault = run_step(step, false, offset, frames - offset);
    if (fault.vertex == kSound) return;
    offset = begin_silence(s, fault, offset);
  }
}

/// Of a step that was run from `offset` on. Returns where it is silent from.
int StepRunner::begin_silence(int s, const Fault& fault, int offset) noexcept {
  count_fault(fault.vertex);
  reset(plan_->steps[index(s)]);
  offset += fault.frame;
  running_->silence(s, end_of_cell(now_ + offset));
  return offset;
}

template <bool kTimed>
void StepRunner::run_loop(const Section& section, int frames) noexcept {
  if (frames > section.sub_block || now_ + frames > end_of_cell(now_) || running_->quiet_from > now_)
    return run_loop_in_parts<kTimed>(section, frames);
  const Step* const steps = plan_->steps.data();
  NodeBlock block{nullptr, nullptr, frames, now_};
  for (int s = section.first_step, end = section.end_step; s < end; ++s) {
    const auto& step = steps[s];
    block.in = step.in;
    block.out = step.out;
    if (step.with_care) [[unlikely]]
      return run_part<kTimed>(section, s, {}, 0, frames);
    const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
    if (step.kind == Step::Kind::Operations) {
      const Fault fault = run_operations(step, true, 0, frames);
      if (fault.vertex != kSound) return run_part<kTimed>(section, s + 1, fault, 0, frames);
    } else if (!run_node(step, block)) {
      return run_part<kTimed>(section, s + 1, made_finite(step, block, 0), 0, frames);
    }
  }
}

template <bool kTimed>
void StepRunner::run_loop_in_parts(const Section& section, int frames) noexcept {
  const auto& silent_until = running_->silent_until[index(section.first_step)];
  for (int offset = 0, part = 0; offset < frames; offset += part) {
    // No sub-block lies across the end of a cell, since a silence may end there.
    part = std::min(
        {section.sub_block, frames - offset, static_cast<int>(end_of_cell(now_ + offset) - (now_ + offset))});
    if (silent_until > now_ + offset)
      silence_part(section, offset, part);
    else if (part == 1)
      run_frame<kTimed>(section, offset);
    else
      run_part<kTimed>(section, section.first_step, {}, offset, part);
  }
}

/// One frame of a loop: many have no more in a sub-block.
template <bool kTimed>
inline void StepRunner::run_frame(const Section& section, int offset) noexcept {
  const Step* const steps = plan_->steps.data();
  Signal* const in = running_->moved_in.data();
  double** const out = running_->moved_out.data();
  const NodeBlock block{in, out, 1, now_ + offset};
  for (int s = section.first_step, end = section.end_step; s < end; ++s) {
    const auto& step = steps[s];
    if (step.with_care) [[unlikely]]
      return run_part<kTimed>(section, s, {}, offset, 1);
    const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
    if (step.kind == Step::Kind::Operations) {
      const Fault fault = run_operations_once(step, true, offset);
      if (fault.vertex != kSound) [[unlikely]]
        return run_part<kTimed>(section, s + 1, fault, offset, 1);
      continue;
    }
    for (int i = 0; i < step.inputs; ++i)
      in[i] = {step.in[i].data + offset * step.in[i].stride, step.in[i].stride};
    for (int i = 0; i < step.outputs; ++i)
      out[i] = step.out[i] == nullptr ? nullptr : step.out[i] + offset * step.width;
    if (!run_node(step, block)) [[unlikely]]
      return run_part<kTimed>(section, s + 1, made_finite(step, block, offset), offset, 1);
  }
}

/// The steps of a loop from `s` on, over one sub-block; `fault`: of those before.
template <bool kTimed>
void StepRunner::run_part(const Section& section, int s, Fault fault, int offset, int part) noexcept {
  for (; s < section.end_step; ++s) {
    const StepTimer<kTimed> timer{running_->step_ns[index(s)]};
    const auto& step = plan_->steps[index(s)];
    if (step.kind == Step::Kind::Outside)
      outside_.answer(offset, part);
    else if (const Fault found = run_step(step, true, offset, part);
             found.vertex != kSound && found.frame < fault.frame)
      fault = found;
  }
  if (fault.vertex == kSound) return;
  count_fault(fault.vertex);
  running_->silence(section.first_step, end_of_cell(now_ + offset));
  for (s = section.first_step; s < section.end_step; ++s) {
    reset(plan_->steps[index(s)]);
    silence(plan_->steps[index(s)], offset + fault.frame, part - fault.frame);
  }
}

/// The world outside misses no frame, or it would be late from here on.
void StepRunner::silence_part(const Section& section, int offset, int part) noexcept {
  for (int s = section.first_step; s < section.end_step; ++s) {
    const auto& step = plan_->steps[index(s)];
    step.kind == Step::Kind::Outside ? outside_.answer(offset, part) : silence(step, offset, part);
  }
}

void StepRunner::run_moved(const MicroOperation& operation, int offset, int frames) noexcept {
  const auto moved = [&](int operand) {
    const auto& in = operation.in[operand];
    return Signal{in.data + offset * in.stride, in.stride};
  };
  const Signal in[] = {moved(0), moved(1), moved(2)};
  run_operation(operation.op, in, operation.out + offset, frames);
}

/// Its output from `out` on is not finite.
void StepRunner::clear(const MicroOperation& operation, bool loop, double* out, int frames,
                       Fault& first) noexcept {
  const int bad = first_nonfinite(out, frames);
  const int cleared = clear_nonfinite(out, frames);
  // Outside loops it remembers nothing, so that only the bad frames themselves are lost.
  if (!loop) count_fault(operation.vertex, cleared);
  if (loop && bad < first.frame) first = {operation.vertex, bad};
}

/// False if one of the operands moves.
bool StepRunner::run_at_rest(const MicroOperation& operation, int frames) noexcept {
  const Signal* const operands = operation.in;
  const bool rests = all_rest(operands);
  if (rests != (running_->at_rest[index(operation.can_rest)] != 0))
    running_->settle(operation.can_rest, rests);
  if (!rests) return false;
  double value = operation.value(operands[0][0], operands[1][0], operands[2][0]);
  const bool finite = is_finite(value);
  running_->computed_in[index(operation.can_rest)] = finite ? running_->settings : 0;
  if (!finite) {
    value = 0;
    count_fault(operation.vertex, frames);
  }
  std::fill_n(operation.out, kVectorWidth, value);
  return true;
}

StepRunner::Fault StepRunner::run_step(const Step& step, bool loop, int offset, int frames) noexcept {
  if (step.divided) {
    const Fault fault = run_divided(step, loop, offset, frames);
    if (loop && fault.vertex != kSound) silence(step, offset + fault.frame, frames - fault.frame);
    return fault;
  }
  if (step.kind == Step::Kind::Operations) return run_operations(step, loop, offset, frames);
  NodeBlock block{step.in, step.out, frames, now_ + offset};
  if (offset > 0) move(step, offset, 1, offset, block);
  if (run_node(step, block)) return {};
  return loop ? made_finite(step, block, offset) : fault_of(step, block);
}

/// In a loop, what the step gave from the bad frame on becomes 0, for the steps that follow.
StepRunner::Fault StepRunner::made_finite(const Step& step, const NodeBlock& block, int offset) noexcept {
  const Fault fault = fault_of(step, block);
  silence(step, offset + fault.frame, block.frames - fault.frame);
  return fault;
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
    NodeBlock block{step.in, step.out, count, at == nullptr ? now_ + offset : at->number + first};
    move_divided(step, at == nullptr ? offset : at->place(first), block);
    if (!run_node(step, block)) fault = fault_of(step, block);
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
  for (int i = 0; i < step.outputs; ++i)
    if (double* out = step.out[i]) std::fill_n(out + offset * step.width, frames * step.width, 0.0);
  for (int i = 0; i < step.operations; ++i)
    if (const int rests = plan_->operations[index(step.first_operation + i)].can_rest; rests >= 0)
      running_->computed_in[index(rests)] = 0;
}

}  // namespace tactus
