#include "engine/core/guarded.h"

#include <algorithm>
#include <string>
#include <utility>

namespace tactus {

struct Guarded::Channel {
  DriveGuard guard;
  bool armed;
  bool muted = false;
  std::unique_ptr<std::atomic<std::int64_t>[]> published =
      std::make_unique<std::atomic<std::int64_t>[]>(3);  // nonfinite, ceiling, slew

  bool should_sound() const { return !muted && (armed || guard.kind() == DriveGuard::Kind::Audio); }
  void publish() noexcept {
    const auto& counts = guard.counts();
    published[0].store(counts.nonfinite, std::memory_order_relaxed);
    published[1].store(counts.ceiling, std::memory_order_relaxed);
    published[2].store(counts.slew, std::memory_order_relaxed);
  }
};

Guarded::Guarded(BlockProcessor& inner, std::vector<GuardedChannel> channels, bool armed)
    : inner_(inner), config_(std::move(channels)), armed_at_start_(armed) {}

Guarded::~Guarded() = default;

Status Guarded::prepare(const StreamFormat& format) {
  const auto outputs = static_cast<std::size_t>(format.out_channels);
  if (config_.size() > outputs)
    return fail(Errc::BadArgument, "",
                std::to_string(config_.size()) + " guarded channels, but the stream has " +
                    std::to_string(outputs) + " outputs",
                "open the stream with more outputs");
  for (const auto& channel : config_)
    if (auto status = check(channel.limits); !status) return status;
  if (auto status = inner_.prepare(format); !status) return status;

  format_ = format;
  frame_ = 0;
  in_.assign(static_cast<std::size_t>(format.in_channels), nullptr);
  out_.assign(outputs, nullptr);
  channels_.clear();
  for (std::size_t c = 0; c < outputs; ++c) {
    const auto config = c < config_.size() ? config_[c] : GuardedChannel{};
    auto& channel = channels_.emplace_back(
        Channel{DriveGuard{config.kind, config.limits, format.sample_rate}, armed_at_start_});
    channel.guard.set_open(channel.should_sound(), 0);
  }
  return {};
}

void Guarded::process(const BlockIo& io) noexcept {
  const NoDenormals no_denormals;
  for (int offset = 0; offset < io.frames; offset += format_.max_frames)
    process_piece(io, offset, std::min(format_.max_frames, io.frames - offset));
  for (auto& channel : channels_) channel.publish();
}

void Guarded::process_piece(const BlockIo& io, int offset, int frames) noexcept {
  for (std::size_t c = 0; c < in_.size(); ++c) in_[c] = io.in[c] + offset;
  for (std::size_t c = 0; c < out_.size(); ++c) out_[c] = io.out[c] + offset;
  inner_.process({in_.data(), out_.data(), frames});

  const auto first = frame_.load(std::memory_order_relaxed);
  int done = 0;
  while (const JournalEntry* entry = inbox_.front()) {
    const auto due = std::max(entry->frame, first + done);
    if (due >= first + frames) break;
    guard_frames(done, static_cast<int>(due - first), first);
    done = static_cast<int>(due - first);
    apply(*entry, due);
    inbox_.drop_front();
  }
  guard_frames(done, frames, first);
  frame_.store(first + frames, std::memory_order_relaxed);
}

void Guarded::guard_frames(int from, int to, std::int64_t first_frame) noexcept {
  if (from == to) return;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    channels_[c].guard.process(out_[c] + from, to - from, first_frame + from);
}

void Guarded::apply(JournalEntry entry, std::int64_t frame) noexcept {
  for (int c = 0; c < static_cast<int>(channels_.size()); ++c) {
    if (entry.index != JournalEntry::kAllChannels && entry.index != c) continue;
    auto& channel = channels_[static_cast<std::size_t>(c)];
    (entry.kind == JournalEntry::Kind::Arm ? channel.armed : channel.muted) = entry.value > 0.5;
    channel.guard.set_open(channel.should_sound(), frame);
  }
  entry.frame = frame;
  // Nobody may be listening; a take that needs every entry reads more often than a thousand are posted.
  (void)applied_.push(entry);
}

bool Guarded::post(const JournalEntry& entry) noexcept {
  const bool ours = entry.kind == JournalEntry::Kind::Arm || entry.kind == JournalEntry::Kind::Mute;
  return ours && inbox_.push(entry);
}

GuardCounts Guarded::counts(int channel) const noexcept {
  const auto& published = channels_[static_cast<std::size_t>(channel)].published;
  return {published[0].load(std::memory_order_relaxed), published[1].load(std::memory_order_relaxed),
          published[2].load(std::memory_order_relaxed)};
}

}  // namespace tactus
