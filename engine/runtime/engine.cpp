#include "engine/runtime/engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "engine/runtime/operations.h"

namespace tactus {
namespace {

/// Adds its lifetime to a step's nanoseconds, if somebody asked for them.
template <bool kTimed>
struct StepTimer {
  explicit StepTimer(double&) {}
};

template <>
struct StepTimer<true> {
  explicit StepTimer(double& sum) : sum_ns(sum), before(std::chrono::steady_clock::now()) {}
  ~StepTimer() {
    sum_ns += std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - before).count();
  }
  StepTimer(const StepTimer&) = delete;
  StepTimer& operator=(const StepTimer&) = delete;

  double& sum_ns;
  std::chrono::steady_clock::time_point before;
};

}  // namespace

Engine::Engine(std::unique_ptr<Plan> plan)
    : newest_(std::make_unique<Running>(std::move(plan), 1)),
      running_(newest_.get()),
      plan_(newest_->plan.get()) {}

Engine::~Engine() = default;

Status Engine::prepare(const StreamFormat& format) {
  if (format.sample_rate != newest_->plan->sample_rate)
    return fail(Errc::BadArgument, {}, "the graph was compiled for another sample rate",
                "compile it for the rate of the stream");
  format_ = format;
  incoming_ = nullptr;
  retired_ = false;
  before_.reset();
  past_faults_.clear();
  running_ = newest_.get();
  plan_ = running_->plan.get();
  running_->start(format.max_frames);
  fades_.assign(running_->outputs.size(), {});
  fading_until_ = 0;
  last_frames_ = 0;
  outside_buffers_.assign(running_->outputs.size() + plan_->input_names.size(),
                          std::vector<double>(kMaxPiece, 0.0));
  outside_in_.clear();
  outside_out_.clear();
  for (std::size_t i = 0; i < outside_buffers_.size(); ++i) {
    if (i < running_->outputs.size())
      outside_in_.push_back(outside_buffers_[i].data());
    else
      outside_out_.push_back(outside_buffers_[i].data());
  }
  bad_inputs_ = 0;
  replacements_ = 0;
  now_ = 0;
  frame_ = 0;
  next_entry_ = 0;
  return {};
}

void Engine::set_journal(std::vector<JournalEntry> entries) {
  journal_ = std::move(entries);
  next_entry_ = 0;
}

void Engine::process(const BlockIo& io) noexcept { run_block<false>(io); }
void Engine::process_timed(const BlockIo& io) noexcept { run_block<true>(io); }

template <bool kTimed>
void Engine::run_block(const BlockIo& io) noexcept {
  const NoDenormals no_denormals;
  for (int offset = 0; offset < io.frames;) {
    const int piece = frames_to_next_entry(std::min(io.frames - offset, kMaxPiece));
    run_piece<kTimed>(io, offset, piece);
    offset += piece;
    now_ += piece;
    last_frames_ = piece;
  }
  frame_.store(now_, std::memory_order_relaxed);
}

template <bool kTimed>
void Engine::run_piece(const BlockIo& io, int offset, int frames) noexcept {
  running_->advance(now_, frames);
  if (outside_ == nullptr) load_inputs(io, offset, 0, frames);
  for (const auto& section : plan_->sections) run_section<kTimed>(section, io, offset, frames);
  if (outside_ == nullptr) store_outputs(io, offset, 0, frames);
  for (std::size_t t = 0; t < running_->taps.size(); ++t) {
    const auto& signal = plan_->channels[static_cast<std::size_t>(running_->tap_channels[t])].signal;
    for (int n = 0; n < frames; ++n) running_->taps[t][static_cast<std::size_t>(offset + n)] = signal[n];
  }
}

// ---- steps
// ---------------------------------------------------------------------------------------------------

template <bool kTimed>
void Engine::run_section(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept {
  if (section.loop) return run_loop<kTimed>(section, io, block_offset, frames);
  for (int s = section.first_step; s < section.end_step; ++s) {
    const StepTimer<kTimed> timer{running_->step_ns[static_cast<std::size_t>(s)]};
    if (plan_->steps[static_cast<std::size_t>(s)].kind == Step::Kind::Outside)
      answer_outside(io, block_offset, 0, frames);
    else
      run_alone(s, frames);
  }
}

// A fault silences from its own frame to the end of the cell that it lies in, on a grid of kMaxPiece frames:
// so the output does not depend on the blocks either.
std::int64_t Engine::end_of_cell(std::int64_t frame) { return frame - frame % kMaxPiece + kMaxPiece; }

/// A step that lies in no loop.
void Engine::run_alone(int s, int frames) noexcept {
  const auto& step = plan_->steps[static_cast<std::size_t>(s)];
  auto& silent_until = running_->silent_until[static_cast<std::size_t>(s)];
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
void Engine::run_loop(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept {
  const Step* const steps = plan_->steps.data();
  auto& silent_until = running_->silent_until[static_cast<std::size_t>(section.first_step)];
  for (int offset = 0, part = 0; offset < frames; offset += part) {
    // No sub-block lies across the end of a cell, since a silence may end there.
    part = std::min(
        {section.sub_block, frames - offset, static_cast<int>(end_of_cell(now_ + offset) - (now_ + offset))});
    const bool silent = silent_until > now_ + offset;
    Fault first;
    for (int s = section.first_step; s < section.end_step; ++s) {
      const StepTimer<kTimed> timer{running_->step_ns[static_cast<std::size_t>(s)]};
      // The world outside misses no frame, or it would be late from here on.
      if (steps[s].kind == Step::Kind::Outside)
        answer_outside(io, block_offset, offset, part);
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

Engine::Fault Engine::run_operations(const Step& step, bool loop, int offset, int frames) noexcept {
  Fault first;
  for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
    const auto& operation = plan_->operations[static_cast<std::size_t>(i)];
    const Signal* operands = plan_->inputs.data() + operation.first_in;
    if (operation.can_rest >= 0 && run_at_rest(operation, operands, frames)) continue;
    double* out = operation.out + offset;
    if (offset == 0) {
      run_operation(operation.op, operands, out, frames);
    } else {
      const Signal moved[2] = {{operands[0].data + offset * operands[0].stride, operands[0].stride},
                               {operands[1].data + offset * operands[1].stride, operands[1].stride}};
      run_operation(operation.op, moved, out, frames);
    }
    if (!can_overflow(operation.op) || all_finite(out, frames)) continue;
    const int bad = first_nonfinite(out, frames);
    const int cleared = clear_nonfinite(out, frames);
    // Outside loops it remembers nothing, so that only the bad frames themselves are lost.
    if (!loop) count_fault(operation.vertex, cleared);
    if (loop && bad < first.frame) first = {operation.vertex, bad};
  }
  return first;
}

/// False if one of the operands moves.
bool Engine::run_at_rest(const MicroOperation& operation, const Signal* operands, int frames) noexcept {
  const bool rests = operands[0].constant() && operands[1].constant();
  if (rests != (running_->at_rest[static_cast<std::size_t>(operation.can_rest)] != 0))
    running_->rest(operation.can_rest, rests);
  if (!rests) return false;
  double value = 0;
  run_operation(operation.op, operands, &value, 1);
  if (!is_finite(value)) {
    value = 0;
    count_fault(operation.vertex, frames);
  }
  std::fill_n(operation.out, kWide, value);
  return true;
}

/// In a loop, what the step gave is made finite from the bad frame on, for the steps that follow.
Engine::Fault Engine::run_step(const Step& step, bool loop, int offset, int frames) noexcept {
  Fault fault;
  if (paced(step)) {
    fault = run_paced(step, loop, offset, frames);
  } else if (step.kind == Step::Kind::Operations) {
    return run_operations(step, loop, offset, frames);
  } else {
    NodeBlock block{plan_->inputs.data() + step.first_in, plan_->outputs.data() + step.first_out,
                    frames, now_ + offset};
    if (offset > 0) move_operands(step, offset, block);
    fault = run_node(step, block);
  }
  if (loop && fault.vertex != kSound) silence(step, offset + fault.frame, frames - fault.frame);
  return fault;
}

Engine::Fault Engine::run_node(const Step& step, const NodeBlock& block) noexcept {
  Node& node = *plan_->nodes[static_cast<std::size_t>(step.node)];
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

Engine::Fault Engine::fault_of(const Step& step, const NodeBlock& block) noexcept {
  Fault fault{step.vertex, block.frames};
  for (int i = 0; i < step.outputs; ++i)
    if (block.out[i] != nullptr)
      fault.frame =
          std::min(fault.frame, first_nonfinite(block.out[i], block.frames * step.width) / step.width);
  return fault;
}

/// What a step reads and writes `offset` frames into the piece.
void Engine::move_operands(const Step& step, int offset, NodeBlock& block) noexcept {
  for (int i = 0; i < step.inputs; ++i)
    running_->moved_in[static_cast<std::size_t>(i)] = {block.in[i].data + offset * block.in[i].stride,
                                                       block.in[i].stride};
  for (int i = 0; i < step.outputs; ++i)
    running_->moved_out[static_cast<std::size_t>(i)] =
        block.out[i] == nullptr ? nullptr : block.out[i] + offset * step.width;
  block.in = running_->moved_in.data();
  block.out = running_->moved_out.data();
}

void Engine::count_fault(int vertex, int times) noexcept {
  running_->faults[static_cast<std::size_t>(vertex)].fetch_add(times, std::memory_order_relaxed);
}

void Engine::reset(const Step& step) noexcept {
  if (step.node >= 0) plan_->nodes[static_cast<std::size_t>(step.node)]->reset();
}

void Engine::silence(const Step& step, int offset, int frames) noexcept {
  if (const Pace* const at = pace(step.pace_out)) {
    frames = at->count(offset + frames) - at->count(offset);
    offset = at->count(offset);
  }
  for (int i = step.first_out; i < step.first_out + step.outputs; ++i)
    if (double* out = plan_->outputs[static_cast<std::size_t>(i)])
      std::fill_n(out + offset * step.width, frames * step.width, 0.0);
}

}  // namespace tactus
