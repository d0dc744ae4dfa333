// What comes into the engine besides samples, each at its frame.
#include <algorithm>
#include <cmath>

#include "engine/runtime/engine.h"

namespace tactus {

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

void Engine::tell(const JournalEntry& entry) noexcept {
  if (tap_ != nullptr) tap_->applied({now_, entry.kind, entry.index, entry.value});
}

void Engine::apply(const JournalEntry& entry) noexcept {
  tell(entry);
  // Where it is no longer known, the last one that was is the best guess.
  if (entry.kind == JournalEntry::Kind::SystemDelay && plan_->system_delay != nullptr && entry.value >= 0)
    std::fill_n(plan_->system_delay, kWide, entry.value / plan_->sample_rate.value);
  if (entry.kind != JournalEntry::Kind::ControlChange) return;
  if (entry.index < 0 || entry.index >= static_cast<int>(running_->control_of.size())) return;
  const int index = running_->control_of[static_cast<std::size_t>(entry.index)];
  if (index < 0 || !std::isfinite(entry.value)) return;
  running_->move_control(static_cast<std::size_t>(index), now_, entry.value);
}

}  // namespace tactus
