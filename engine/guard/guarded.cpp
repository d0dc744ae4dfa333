#include "engine/guard/guarded.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "engine/core/every_block.h"
#include "engine/core/index.h"

namespace tactus {

using Kind = JournalEntry::Kind;

Guarded::Guarded(BlockProcessor& inner, std::vector<GuardedChannel> channels, bool armed)
    : inner_(inner), config_(std::move(channels)), armed_at_start_(armed) {}

Status Guarded::prepare(const StreamFormat& format) {
  const auto outputs = index(format.out_channels);
  if (config_.size() > outputs)
    return fail(Errc::BadArgument, "",
                std::to_string(config_.size()) + " guarded channels, but the stream has " +
                    std::to_string(outputs) + " outputs",
                "open the stream with more outputs");
  for (const auto& channel : config_)
    if (auto status = check(channel.limits, format.sample_rate); !status) return status;
  if (auto status = inner_.prepare(format); !status) return status;

  frame_ = 0;
  stopped_ = false;
  silent_ = true;
  // When a device returns, the time in which the control loop has not refreshed the switch counts.
  if (!channels_.empty() && dead_man_ != nullptr && dead_man_->age() >= DeadMansWatch::kPatience)
    expired_ = true;
  dead_mans_watch_.start(dead_man_, format.sample_rate, format.max_frames, expired_);
  const auto watched = std::exchange(
      sensors_, std::vector<SensorWatch>(index(format.in_channels), SensorWatch{format.sample_rate}));
  for (std::size_t c = 0; c < std::min(watched.size(), sensors_.size()); ++c)
    if (watched[c].is_noisy()) sensors_[c].set_noisy();
  inbox_.drop_posted();
  std::deque<Channel> before;
  before.swap(channels_);
  for (std::size_t c = 0; c < outputs; ++c) {
    auto& channel =
        channels_.emplace_back(config_of(static_cast<int>(c)), format.sample_rate, armed_at_start_);
    if (c < before.size()) restore(before[c], channel);
    if (!on_device_) continue;
    if (c < before.size())
      channel.guard.displace(1.0);
    else
      channel.guard.suppose_worst();
  }
  take_pending([this](const JournalEntry& command) { (void)apply_command(command); });
  open_guards(0);  // commands that came while no block did hold from the first frame on
  return {};
}

GuardedChannel Guarded::config_of(int channel) const {
  return index(channel) < config_.size() ? config_[index(channel)]
                                         : GuardedChannel{DriveGuard::Kind::Drive, conservative_limits()};
}

void Guarded::restore(const Channel& before, Channel& channel) noexcept {
  channel.armed = before.armed;
  channel.muted = before.muted;
  channel.guard.warm_to(before.guard.thermal_state());
  channel.guard.spend_dc_time(before.guard.dc_time_s());
  channel.guard.add_feedback_path(before.guard.feedback_path());
  channel.guard.add_feedback_path(FeedbackPath::of(before.new_paths.load(std::memory_order_relaxed)));
}

void Guarded::add_feedback_paths(const std::vector<FeedbackPath>& paths) noexcept {
  for (std::size_t c = 0; c < std::min(paths.size(), channels_.size()); ++c)
    channels_[c].new_paths.fetch_or(paths[c].bits(), std::memory_order_relaxed);
  has_new_paths_.store(true, std::memory_order_release);
}

template <class Apply>
void Guarded::take_new_paths(Apply apply) noexcept {
  if (!has_new_paths_.load(std::memory_order_relaxed)) return;
  has_new_paths_.exchange(false, std::memory_order_acquire);
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const int bits = channels_[c].new_paths.exchange(0, std::memory_order_relaxed);
    const int known = channels_[c].guard.feedback_path().bits();
    if ((bits | known) == known) continue;
    apply(
        JournalEntry{JournalEntry::kNow, Kind::FeedbackPath, static_cast<int>(c), static_cast<double>(bits)});
  }
}

/// Entries for now, then the switches, which no queue can hold back.
template <class Apply>
void Guarded::take_pending(Apply apply) noexcept {
  for (; const JournalEntry* entry = at_once_.front(); at_once_.drop_front()) apply(*entry);
  const auto flip = [&](GuardSwitch& from, JournalEntry::Kind kind) {
    if (const auto on = from.take())
      apply(JournalEntry{JournalEntry::kNow, kind, JournalEntry::kAllChannels, *on ? 1.0 : 0.0});
  };
  flip(arm_, JournalEntry::Kind::Arm);
  flip(mute_, JournalEntry::Kind::Mute);
  flip(fade_, JournalEntry::Kind::Fade);
  take_new_paths(apply);
}

/// False: there is no such channel. The guards are still to be opened.
bool Guarded::apply_command(const JournalEntry& command) noexcept {
  const bool all = command.index == JournalEntry::kAllChannels;
  if (command.kind == Kind::Fade) faded_ = command.value > 0.5;
  if (command.kind == Kind::DeadMan) expired_ = command.value > 0.5;
  if (command.kind == Kind::SensorNoise) {
    const bool known = !all && index(command.index) < sensors_.size();
    if (known) sensors_[index(command.index)].set_noisy();
    return known;
  }
  bool known = all;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    if (!all && command.index != static_cast<int>(c)) continue;
    known = true;
    apply_to(channels_[c], command);
  }
  return known;
}

void Guarded::apply_to(Channel& channel, const JournalEntry& command) noexcept {
  const bool on = command.value > 0.5;
  auto& guard = channel.guard;
  if (command.kind == Kind::Arm && (on || channel.is_drive() || command.index != JournalEntry::kAllChannels))
    channel.armed = on;
  if (command.kind == Kind::Mute) channel.muted = on;
  if (command.kind == Kind::CoilHeat) guard.warm_to({command.value, 0.0});
  if (command.kind == Kind::BodyHeat) guard.warm_to({0.0, command.value});
  if (command.kind == Kind::DcTime) guard.spend_dc_time(command.value);
  if (command.kind == Kind::Displacement) guard.displace(command.value);
  if (command.kind == Kind::FeedbackPath)
    guard.add_feedback_path(FeedbackPath::of(static_cast<int>(command.value)));
}

TACTUS_EVERY_BLOCK void Guarded::open_guards(std::int64_t frame) noexcept {
  for (auto& channel : channels_) channel.guard.set_open(!faded_ && !expired_ && channel.is_enabled(), frame);
}

void Guarded::skip_soft_start() noexcept {
  for (auto& channel : channels_) channel.guard.skip_soft_start();
}

TACTUS_EVERY_BLOCK void Guarded::process(const BlockIo& io) noexcept {
  const auto first_frame = frame_.load(std::memory_order_relaxed);
  {
    const NoDenormals no_denormals;
    if (std::exchange(stopped_, false)) {
      open_guards(first_frame);
      if (tap_ != nullptr) tap_->applied({first_frame, JournalEntry::Kind::Halt, 0, 0.0});
    }
    inner_.process(io);
    guard_block(io, first_frame);
    frame_.store(first_frame + io.frames, std::memory_order_relaxed);
    silent_.store(at_rest(first_frame + io.frames), std::memory_order_relaxed);
  }
  // A tap turns samples into floats, and must not lose those that are no denormals as doubles.
  if (tap_ != nullptr) tap_->observe(io, first_frame);
}

bool Guarded::finish(const BlockIo& io) noexcept {
  bool silent = true;
  for (std::size_t c = 0; c < channels_.size(); ++c)
    silent = channels_[c].guard.stop(io.out[c], io.frames) && silent;
  stopped_ = true;
  silent_.store(silent, std::memory_order_relaxed);
  return silent;
}

TACTUS_EVERY_BLOCK bool Guarded::at_rest(std::int64_t frame) const noexcept {
  return std::all_of(channels_.begin(), channels_.end(),
                     [frame](const Channel& channel) { return channel.guard.at_rest(frame); });
}

Seconds Guarded::closing_time() const noexcept {
  Seconds longest = channels_.size() > config_.size() ? tactus::closing_time(conservative_limits()) : 0_s;
  for (const auto& channel : config_) longest = std::max(longest, tactus::closing_time(channel.limits));
  return longest;
}

TACTUS_EVERY_BLOCK void Guarded::observe_dead_man(std::int64_t frame) noexcept {
  act_on_dead_man(dead_mans_watch_.observe(frame), frame);
  if (dead_mans_watch_.was_away()) act_on_dead_man(DeadMansWatch::Action::Disarm, frame);
  const auto* source = dead_mans_watch_.source();
  if (source != nullptr && source->stopped() && !faded_)
    apply({frame, JournalEntry::Kind::Fade, JournalEntry::kAllChannels, 1.0}, frame);
}

void Guarded::note_pause(Seconds pause) noexcept {
  if (!dead_mans_watch_.slept(pause)) return;
  arm_.set(false);
  dead_mans_watch_.set_disarmed();
  (void)events_.push({frame_.load(std::memory_order_relaxed), GuardEvent::Kind::DeadManDisarmed, 0});
}

void Guarded::note_gap(std::int64_t frames) noexcept {
  const auto now = frame_.load(std::memory_order_relaxed);
  for (int c = 0; c < static_cast<int>(channels_.size()); ++c) {
    const double share = channels_[index(c)].guard.displacement_after(frames);
    if (share > 0.0) apply({now, JournalEntry::Kind::Displacement, c, share}, now);
  }
}

TACTUS_EVERY_BLOCK void Guarded::act_on_dead_man(DeadMansWatch::Action action, std::int64_t frame) noexcept {
  using Action = DeadMansWatch::Action;
  if (action == Action::None) return;
  const bool disarms = action == Action::Disarm;
  const auto kind = disarms ? JournalEntry::Kind::Arm : JournalEntry::Kind::DeadMan;
  apply({frame, kind, JournalEntry::kAllChannels, action == Action::Expire ? 1.0 : 0.0}, frame);
  if (action == Action::Resume) return;
  (void)events_.push({frame, disarms ? GuardEvent::Kind::DeadManDisarmed : GuardEvent::Kind::DeadMan, 0});
}

TACTUS_EVERY_BLOCK void Guarded::guard_block(const BlockIo& io, std::int64_t first) noexcept {
  take_pending([&](const JournalEntry& entry) { apply(entry, first); });
  observe_dead_man(first);
  for (int done = 0; done < io.frames;) {
    const auto now = first + done;
    act_on_dead_man(dead_mans_watch_.take(now), now);
    const auto until = std::min<std::int64_t>(io.frames - done, dead_mans_watch_.next() - now);
    const int next = done + static_cast<int>(inbox_.take_due(
                                now, until, [&](const JournalEntry& entry) { apply(entry, now); }));
    guard_frames(io, done, next, first);
    done = next;
  }
}

TACTUS_EVERY_BLOCK void Guarded::guard_frames(const BlockIo& io, int from, int to,
                                              std::int64_t first_frame) noexcept {
  const int fault = first_sensor_fault(io, from, to, first_frame);
  guard_outputs(io, from, fault, first_frame);
  if (fault == to) return;
  for (auto& channel : channels_)
    if (channel.is_drive()) channel.armed = false;
  open_guards(first_frame + fault);
  guard_outputs(io, fault, to, first_frame);
}

TACTUS_EVERY_BLOCK void Guarded::guard_outputs(const BlockIo& io, int from, int to,
                                               std::int64_t first_frame) noexcept {
  if (from == to) return;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    auto& channel = channels_[c];
    channel.guard.process(io.out[c] + from, to - from, first_frame + from);
    const auto feedback = channel.guard.take_feedback();
    if (!feedback) continue;
    channel.armed = false;
    (void)events_.push({*feedback, GuardEvent::Kind::Feedback, static_cast<int>(c)});
  }
}

/// The frame at which the first sensor is found at fault, or `to`.
TACTUS_EVERY_BLOCK int Guarded::first_sensor_fault(const BlockIo& io, int from, int to,
                                                   std::int64_t first_frame) noexcept {
  int first = to;
  if (!watch_sensors_) return first;
  for (std::size_t c = 0; c < sensors_.size(); ++c) {
    if (c < unwatched_.size() && unwatched_[c]) continue;
    const auto found = sensors_[c].observe(io.in[c] + from, to - from);
    if (!found) continue;
    first = std::min(first, from + found->frame);
    const auto kind = found->fault == SensorWatch::Fault::Railed ? GuardEvent::Kind::SensorRailed
                                                                 : GuardEvent::Kind::SensorStuck;
    (void)events_.push({first_frame + from + found->frame, kind, static_cast<int>(c)});
  }
  return first;
}

void Guarded::apply(JournalEntry entry, std::int64_t frame) noexcept {
  const bool known = apply_command(entry);
  open_guards(frame);
  if (known && entry.kind == JournalEntry::Kind::Arm && entry.value > 0.5)
    for (auto& sensor : sensors_) sensor.rearm();
  entry.frame = frame;
  if (tap_ != nullptr) tap_->applied(entry);
}

std::vector<JournalEntry> Guarded::state() const {
  std::vector<JournalEntry> entries;
  if (faded_) entries.push_back({0, Kind::Fade, JournalEntry::kAllChannels, 1.0});
  if (expired_) entries.push_back({0, Kind::DeadMan, JournalEntry::kAllChannels, 1.0});
  for (int c = 0; c < static_cast<int>(channels_.size()); ++c) {
    const auto& channel = channels_[index(c)];
    const auto heat = channel.guard.thermal_state();
    if (channel.armed != (armed_at_start_ || !channel.is_drive()))
      entries.push_back({0, Kind::Arm, c, channel.armed ? 1.0 : 0.0});
    if (channel.muted) entries.push_back({0, Kind::Mute, c, 1.0});
    if (heat.coil > 0.0) entries.push_back({0, Kind::CoilHeat, c, heat.coil});
    if (heat.body > 0.0) entries.push_back({0, Kind::BodyHeat, c, heat.body});
    if (const double dc_s = channel.guard.dc_time_s(); dc_s > 0.0)
      entries.push_back({0, Kind::DcTime, c, dc_s});
    if (const double share = channel.guard.displacement(); share > 0.0)
      entries.push_back({0, Kind::Displacement, c, share});
    const auto path = channel.guard.feedback_path();
    if (path != config_of(c).feedback)
      entries.push_back({0, Kind::FeedbackPath, c, static_cast<double>(path.bits())});
  }
  for (int c = 0; c < static_cast<int>(sensors_.size()); ++c)
    if (sensors_[index(c)].is_noisy()) entries.push_back({0, Kind::SensorNoise, c, 1.0});
  return entries;
}

bool Guarded::post(const JournalEntry& entry) noexcept {
  constexpr std::array kOurs = {Kind::Arm,          Kind::Mute,        Kind::Fade,   Kind::DeadMan,
                                Kind::CoilHeat,     Kind::BodyHeat,    Kind::DcTime, Kind::SensorNoise,
                                Kind::FeedbackPath, Kind::Displacement};
  return std::ranges::find(kOurs, entry.kind) != kOurs.end() &&
         (entry.frame == JournalEntry::kNow ? at_once_.push(entry) : inbox_.post(entry));
}

}  // namespace tactus
