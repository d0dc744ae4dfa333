#include "engine/runtime/engine.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "engine/runtime/operations.h"

namespace tactus {

/// A control moves on a straight line (in decibels if it is read so) between two absolute frames.
struct Engine::ControlState {
  double from = 0, to = 0;
  std::int64_t start = 0, length = 0;
  bool resting = true;

  double at(std::int64_t frame, bool decibel) const noexcept {
    if (frame - start >= length) return to;
    const double position = static_cast<double>(frame - start) / static_cast<double>(length);
    if (decibel && from > 0 && to > 0) return from * std::pow(to / from, position);
    return from + (to - from) * position;
  }
};

Engine::Engine(std::unique_ptr<Schedule> schedule)
    : schedule_(std::move(schedule)),
      controls_(schedule_->controls.size()),
      faults_(schedule_->paths.size()) {
  for (std::size_t i = 0; i < schedule_->channels.size(); ++i)
    (schedule_->channels[i].use == OutputUse::Tap ? tap_channels_ : outputs_).push_back(static_cast<int>(i));
  std::size_t most_in = 2;
  std::size_t most_out = 1;
  for (const auto& step : schedule_->steps) {
    most_in = std::max(most_in, static_cast<std::size_t>(step.inputs));
    most_out = std::max(most_out, static_cast<std::size_t>(step.outputs));
  }
  moved_in_.resize(most_in);
  moved_out_.resize(most_out);
  step_ns_.assign(schedule_->steps.size(), 0);
}

Engine::~Engine() = default;

Status Engine::prepare(const StreamFormat& format) {
  if (format.sample_rate != schedule_->sample_rate)
    return fail(Errc::BadArgument, {}, "the graph was compiled for another sample rate",
                "compile it for the rate of the stream");
  format_ = format;
  taps_.assign(tap_channels_.size(), std::vector<double>(static_cast<std::size_t>(format.max_frames), 0.0));
  outside_buffers_.assign(outputs_.size() + schedule_->input_names.size(),
                          std::vector<double>(kMaxPiece, 0.0));
  outside_in_.clear();
  outside_out_.clear();
  for (std::size_t i = 0; i < outside_buffers_.size(); ++i) {
    if (i < outputs_.size())
      outside_in_.push_back(outside_buffers_[i].data());
    else
      outside_out_.push_back(outside_buffers_[i].data());
  }
  std::fill_n(schedule_->arena.data(), schedule_->arena.size(), 0.0);
  if (schedule_->system_delay != nullptr) *schedule_->system_delay = schedule_->system_delay_at_start.value;
  for (auto& node : schedule_->nodes) node->reset();
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    controls_[i] = {};
    controls_[i].from = controls_[i].to = schedule_->controls[i].control.value;
    rest(i, true);
  }
  for (auto& count : faults_) count.store(0, std::memory_order_relaxed);
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
  }
  frame_.store(now_, std::memory_order_relaxed);
}

template <bool kTimed>
void Engine::run_piece(const BlockIo& io, int offset, int frames) noexcept {
  advance_controls(frames);
  if (outside_ == nullptr) load_inputs(io, offset, 0, frames);
  for (const auto& section : schedule_->sections) run_section<kTimed>(section, io, offset, frames);
  if (outside_ == nullptr) store_outputs(io, offset, 0, frames);
  for (std::size_t t = 0; t < taps_.size(); ++t) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(tap_channels_[t])].signal;
    for (int n = 0; n < frames; ++n) taps_[t][static_cast<std::size_t>(offset + n)] = signal[n];
  }
}

// ---- journal and controls
// ------------------------------------------------------------------------------------

int Engine::frames_to_next_entry(int frames) noexcept {
  std::int64_t piece = frames;
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
    *schedule_->system_delay = std::max(0.0, entry.value) / schedule_->sample_rate.value;
  if (entry.kind != JournalEntry::Kind::ControlChange) return;
  if (entry.index < 0 || entry.index >= static_cast<int>(controls_.size())) return;
  const auto i = static_cast<std::size_t>(entry.index);
  const auto& control = schedule_->controls[i];
  if (control.frozen || !std::isfinite(entry.value)) return;
  auto& state = controls_[i];
  state.from = state.at(now_, control.control.decibel);
  state.to = std::clamp(entry.value, control.control.range.low, control.control.range.high);
  state.start = now_;
  state.length =
      static_cast<std::int64_t>(std::lround(control.control.smooth_s * schedule_->sample_rate.value));
  rest(i, false);
}

void Engine::rest(std::size_t control, bool resting) noexcept {
  auto& scheduled = schedule_->controls[control];
  controls_[control].resting = resting;
  if (scheduled.buffer == nullptr) return;
  if (resting) scheduled.buffer[0] = controls_[control].to;
  for (const int slot : scheduled.slots)
    schedule_->inputs[static_cast<std::size_t>(slot)].stride = resting ? 0 : 1;
  for (const int channel : scheduled.output_slots)
    schedule_->channels[static_cast<std::size_t>(channel)].signal.stride = resting ? 0 : 1;
}

void Engine::advance_controls(int frames) noexcept {
  for (std::size_t i = 0; i < controls_.size(); ++i) {
    auto& state = controls_[i];
    if (state.resting) continue;
    if (now_ - state.start >= state.length) {
      rest(i, true);
      continue;
    }
    const auto& scheduled = schedule_->controls[i];
    if (scheduled.buffer == nullptr) continue;
    for (int n = 0; n < frames; ++n) scheduled.buffer[n] = state.at(now_ + n, scheduled.control.decibel);
  }
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
    std::copy_n(io.in[c] + block_offset + piece_offset, frames, buffer);
    make_finite(buffer, frames);
  }
}

void Engine::make_finite(double* samples, int frames) noexcept {
  if (!all_finite(samples, frames))
    bad_inputs_.fetch_add(clear_nonfinite(samples, frames), std::memory_order_relaxed);
}

void Engine::store_outputs(const BlockIo& io, int block_offset, int piece_offset, int frames) noexcept {
  const auto channels = std::min(static_cast<std::size_t>(format_.out_channels), outputs_.size());
  for (std::size_t c = 0; c < channels; ++c) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(outputs_[c])].signal;
    double* out = io.out[c] + block_offset + piece_offset;
    for (int n = 0; n < frames; ++n) out[n] = signal[piece_offset + n];
  }
}

void Engine::answer_outside(const BlockIo& io, int block_offset, int offset, int frames) noexcept {
  if (outside_ == nullptr) return;  // nobody there: the channels were loaded like any others
  for (std::size_t c = 0; c < outputs_.size(); ++c) {
    const auto& signal = schedule_->channels[static_cast<std::size_t>(outputs_[c])].signal;
    for (int n = 0; n < frames; ++n) outside_buffers_[c][static_cast<std::size_t>(n)] = signal[offset + n];
  }
  outside_->process({outside_in_.data(), outside_out_.data(), frames});
  for (std::size_t c = 0; c < schedule_->input_buffers.size(); ++c) {
    double* buffer = schedule_->input_buffers[c];
    if (buffer == nullptr) continue;
    std::copy_n(outside_out_[c], frames, buffer + offset);
    make_finite(buffer + offset, frames);
  }
  store_outputs(io, block_offset, offset, frames);
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
        step_ns_[static_cast<std::size_t>(s)] +=
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
    const Signal moved[2] = {{operands[0].data + offset * operands[0].stride, operands[0].stride},
                             {operands[1].data + offset * operands[1].stride, operands[1].stride}};
    run_operation(operation.op, moved, operation.out + offset, frames);
    if (all_finite(operation.out + offset, frames)) continue;
    if (section.loop) return operation.path;
    // It remembers nothing, so that only the bad frames themselves are lost.
    clear_nonfinite(operation.out + offset, frames);
    count_fault(operation.path);
  }
  return kSound;
}

int Engine::run_step(const Section& section, const Step& step, int offset, int frames) noexcept {
  if (step.kind == Step::Kind::Operations) return run_operations(section, step, offset, frames);
  const Signal* in = schedule_->inputs.data() + step.first_in;
  double* const* out = schedule_->outputs.data() + step.first_out;
  if (offset > 0) {
    for (int i = 0; i < step.inputs; ++i)
      moved_in_[static_cast<std::size_t>(i)] = {in[i].data + offset * in[i].stride, in[i].stride};
    for (int i = 0; i < step.outputs; ++i)
      moved_out_[static_cast<std::size_t>(i)] = out[i] == nullptr ? nullptr : out[i] + offset;
    in = moved_in_.data();
    out = moved_out_.data();
  }
  const NodeBlock block{in, out, frames, now_ + offset};
  Node& node = *schedule_->nodes[static_cast<std::size_t>(step.node)];
  if (step.kind == Step::Kind::Absorb) {
    node.absorb(block);
    return kSound;
  }
  if (step.kind == Step::Kind::Emit)
    node.emit(block);
  else
    node.process(block);
  bool finite = true;
  for (int i = 0; i < step.outputs; ++i)
    if (out[i] != nullptr) finite &= all_finite(out[i], frames);
  return finite ? kSound : step.path;
}

void Engine::count_fault(int path) noexcept {
  faults_[static_cast<std::size_t>(path)].fetch_add(1, std::memory_order_relaxed);
}

void Engine::silence(const Step& step, int offset, int frames) noexcept {
  if (step.node >= 0) schedule_->nodes[static_cast<std::size_t>(step.node)]->reset();
  for (int i = step.first_out; i < step.first_out + step.outputs; ++i)
    if (double* out = schedule_->outputs[static_cast<std::size_t>(i)]) std::fill_n(out + offset, frames, 0.0);
}

std::vector<FaultCount> Engine::faults() const {
  std::vector<FaultCount> found;
  for (std::size_t i = 0; i < faults_.size(); ++i)
    if (const auto count = faults_[i].load(std::memory_order_relaxed); count > 0)
      found.push_back({schedule_->paths[i], count});
  return found;
}

}  // namespace tactus
