#include "engine/runtime/engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/core/transpose.h"
#include "engine/dsp/lanes.h"
#include "engine/runtime/operations.h"

namespace tactus {

Engine::Engine(std::unique_ptr<Schedule> schedule)
    : newest_(std::make_unique<Running>(std::move(schedule), 1)),
      running_(newest_.get()),
      schedule_(newest_->schedule.get()) {}

Engine::~Engine() = default;

Status Engine::prepare(const StreamFormat& format) {
  if (format.sample_rate != newest_->schedule->sample_rate)
    return fail(Errc::BadArgument, {}, "the graph was compiled for another sample rate",
                "compile it for the rate of the stream");
  format_ = format;
  incoming_ = nullptr;
  retired_ = false;
  before_.reset();
  past_faults_.clear();
  running_ = newest_.get();
  schedule_ = running_->schedule.get();
  running_->start(format.max_frames);
  fades_.assign(running_->outputs.size(), {});
  fading_until_ = 0;
  last_frames_ = 0;
  outside_buffers_.assign(running_->outputs.size() + schedule_->input_names.size(),
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
  for (const auto& section : schedule_->sections) run_section<kTimed>(section, io, offset, frames);
  if (outside_ == nullptr) store_outputs(io, offset, 0, frames);
  for (std::size_t t = 0; t < running_->taps.size(); ++t) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(running_->tap_channels[t])].signal;
    for (int n = 0; n < frames; ++n) running_->taps[t][static_cast<std::size_t>(offset + n)] = signal[n];
  }
}

// ---- journal and controls
// ------------------------------------------------------------------------------------

int Engine::frames_to_next_entry(int frames) noexcept {
  std::int64_t piece = frames;
  if (Running* next = incoming_.load(std::memory_order_acquire); next != nullptr) {
    if (next->frame <= now_)
      take_over(*next);
    else
      piece = std::min(piece, next->frame - now_);
  }
  while (next_entry_ < journal_.size() && journal_[next_entry_].frame <= now_) apply(journal_[next_entry_++]);
  if (next_entry_ < journal_.size()) piece = std::min(piece, journal_[next_entry_].frame - now_);
  const JournalEntry* posted = inbox_.front();
  while (posted != nullptr && posted->frame <= now_) {
    apply(*posted);
    inbox_.drop_front();
    posted = inbox_.front();
  }
  if (posted != nullptr) piece = std::min(piece, posted->frame - now_);
  return static_cast<int>(piece);
}

void Engine::apply(const JournalEntry& entry) noexcept {
  if (entry.kind == JournalEntry::Kind::SystemDelay && schedule_->system_delay != nullptr)
    std::fill_n(schedule_->system_delay, kWide, std::max(0.0, entry.value) / schedule_->sample_rate.value);
  if (entry.kind != JournalEntry::Kind::ControlChange) return;
  if (entry.index < 0 || entry.index >= static_cast<int>(running_->control_of.size())) return;
  const int index = running_->control_of[static_cast<std::size_t>(entry.index)];
  if (index < 0 || !std::isfinite(entry.value)) return;
  running_->move_control(static_cast<std::size_t>(index), now_, entry.value);
}

// ---- samples in and out
// --------------------------------------------------------------------------------------

void Engine::load_inputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept {
  for (std::size_t c = 0; c < schedule_->input_buffers.size(); ++c) {
    double* buffer = schedule_->input_buffers[c];
    if (buffer == nullptr) continue;
    buffer += piece_offset;
    if (static_cast<int>(c) >= format_.in_channels) {
      std::fill_n(buffer, frames, 0.0);
      continue;
    }
    copy_samples(io.in[c] + block_offset + piece_offset, frames, buffer);
    make_finite(buffer, frames);
  }
}

void Engine::make_finite(double* samples, int frames) noexcept {
  if (!all_finite(samples, frames))
    bad_inputs_.fetch_add(clear_nonfinite(samples, frames), std::memory_order_relaxed);
}

void Engine::store_outputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept {
  const auto channels = std::min(static_cast<std::size_t>(format_.out_channels), running_->outputs.size());
  const int to = block_offset + piece_offset;
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(running_->outputs[c])].signal;
    if (signal.stride == 1) {
      copy_samples(signal.data + piece_offset, frames, io.out[c] + to);
    } else if (running_->side_by_side[c] && c + kWide <= channels) {
      std::array<double*, kWide> rows;
      for (std::size_t lane = 0; lane < kWide; ++lane) rows[lane] = io.out[c + lane] + to;
      Transpose::unpack(signal.data + piece_offset * kWide, rows, frames);
      c += kWide - 1;
    } else {
      for (int n = 0; n < frames; ++n) io.out[c][to + n] = signal[piece_offset + n];
    }
  }
  if (now_ + piece_offset >= fading_until_) return;
  for (std::size_t c = 0; c < channels; ++c) fades_[c].process(io.out[c] + to, frames, now_ + piece_offset);
}

void Engine::answer_outside(const BlockIo& io, int block_offset, int offset, int frames) noexcept {
  if (outside_ == nullptr) return;  // nobody there: the channels were loaded like any others
  for (std::size_t c = 0; c < running_->outputs.size(); ++c) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(running_->outputs[c])].signal;
    double* samples = outside_buffers_[c].data();
    for (int n = 0; n < frames; ++n) samples[n] = signal[offset + n];
    if (now_ + offset < fading_until_) fades_[c].process(samples, frames, now_ + offset);
    if (static_cast<int>(c) < format_.out_channels)
      std::copy_n(samples, frames, io.out[c] + block_offset + offset);
  }
  outside_->process({outside_in_.data(), outside_out_.data(), frames});
  for (std::size_t c = 0; c < schedule_->input_buffers.size(); ++c) {
    double* buffer = schedule_->input_buffers[c];
    if (buffer == nullptr) continue;
    std::copy_n(outside_out_[c], frames, buffer + offset);
    make_finite(buffer + offset, frames);
  }
}

// ---- steps
// ---------------------------------------------------------------------------------------------------

template <bool kTimed>
void Engine::run_section(const Section& section, const BlockIo& io, int block_offset, int frames) noexcept {
  for (int offset = 0; offset < frames; offset += section.sub_block) {
    const int part = std::min(section.sub_block, frames - offset);
    for (int s = section.first_step; s < section.end_step; ++s) {
      const auto& step = schedule_->steps[static_cast<std::size_t>(s)];
      [[maybe_unused]] std::chrono::steady_clock::time_point before;
      if constexpr (kTimed) before = std::chrono::steady_clock::now();
      int faulty_path = kSound;
      if (step.kind == Step::Kind::Outside)
        answer_outside(io, block_offset, offset, part);
      else
        faulty_path = run_step(section, step, offset, part);
      if constexpr (kTimed)
        running_->step_ns[static_cast<std::size_t>(s)] +=
            std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - before).count();
      if (faulty_path == kSound) continue;
      count_fault(faulty_path);
      if (!section.loop) {
        silence(step, offset, part);
        continue;
      }
      for (int t = section.first_step; t < section.end_step; ++t)
        silence(schedule_->steps[static_cast<std::size_t>(t)], offset, part);
      // The world outside misses no frame, or it would be late from here on.
      for (int t = s + 1; t < section.end_step; ++t)
        if (schedule_->steps[static_cast<std::size_t>(t)].kind == Step::Kind::Outside)
          answer_outside(io, block_offset, offset, part);
      break;
    }
  }
}

int Engine::run_operations(const Section& section, const Step& step, int offset, int frames) noexcept {
  for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
    const auto& operation = schedule_->operations[static_cast<std::size_t>(i)];
    const Signal* operands = schedule_->inputs.data() + operation.first_in;
    if (operation.can_rest >= 0 && run_at_rest(operation, operands)) continue;
    double* out = operation.out + offset;
    if (offset == 0) {
      run_operation(operation.op, operands, out, frames);
    } else {
      const Signal moved[2] = {{operands[0].data + offset * operands[0].stride, operands[0].stride},
                               {operands[1].data + offset * operands[1].stride, operands[1].stride}};
      run_operation(operation.op, moved, out, frames);
    }
    if (!can_overflow(operation.op) || all_finite(out, frames)) continue;
    if (section.loop) return operation.path;
    // It remembers nothing, so that only the bad frames themselves are lost.
    clear_nonfinite(out, frames);
    count_fault(operation.path);
  }
  return kSound;
}

/// False if one of the operands moves.
bool Engine::run_at_rest(const MicroOperation& operation, const Signal* operands) noexcept {
  const bool rests = operands[0].constant() && operands[1].constant();
  if (rests != (running_->at_rest[static_cast<std::size_t>(operation.can_rest)] != 0))
    running_->rest(operation.can_rest, rests);
  if (!rests) return false;
  double value = 0;
  run_operation(operation.op, operands, &value, 1);
  if (!is_finite(value)) {
    value = 0;
    count_fault(operation.path);
  }
  std::fill_n(operation.out, kWide, value);
  return true;
}

int Engine::run_step(const Section& section, const Step& step, int offset, int frames) noexcept {
  if (step.kind == Step::Kind::Operations) return run_operations(section, step, offset, frames);
  NodeBlock block{schedule_->inputs.data() + step.first_in, schedule_->outputs.data() + step.first_out,
                  frames, now_ + offset};
  if (offset > 0) move_operands(step, offset, block);
  Node& node = *schedule_->nodes[static_cast<std::size_t>(step.node)];
  if (step.kind == Step::Kind::Absorb) {
    node.absorb(block);
    return kSound;
  }
  if (step.kind == Step::Kind::Emit)
    node.emit(block);
  else
    node.process(block);
  if (!step.can_fail) return kSound;
  for (int i = 0; i < step.outputs; ++i)
    if (block.out[i] != nullptr && !all_finite(block.out[i], frames * step.width)) return step.path;
  return kSound;
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

void Engine::count_fault(int path) noexcept {
  running_->faults[static_cast<std::size_t>(path)].fetch_add(1, std::memory_order_relaxed);
}

void Engine::silence(const Step& step, int offset, int frames) noexcept {
  if (step.node >= 0) schedule_->nodes[static_cast<std::size_t>(step.node)]->reset();
  for (int i = step.first_out; i < step.first_out + step.outputs; ++i)
    if (double* out = schedule_->outputs[static_cast<std::size_t>(i)])
      std::fill_n(out + offset * step.width, frames * step.width, 0.0);
}

}  // namespace tactus
