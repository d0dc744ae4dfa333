#include "backends/reconnecting_stream.h"

#include <fmt/format.h>

#include <ctime>
#include <utility>

#include "backends/find_device.h"

namespace tactus {

// CLOCK_BOOTTIME counts while the computer is suspended, CLOCK_MONOTONIC does not.
std::chrono::nanoseconds time_suspended() {
#if defined(CLOCK_BOOTTIME)
  const auto read = [](clockid_t clock) {
    timespec time{};
    ::clock_gettime(clock, &time);
    return std::chrono::seconds{time.tv_sec} + std::chrono::nanoseconds{time.tv_nsec};
  };
  const auto awake = read(CLOCK_MONOTONIC);  // first: so the difference is never below zero
  return read(CLOCK_BOOTTIME) - awake;
#else
  return {};
#endif
}

Result<std::unique_ptr<ReconnectingStream>> ReconnectingStream::open(Backend& backend,
                                                                     const StreamRequest& request,
                                                                     GuardedBlocks& processor) {
  std::unique_ptr<ReconnectingStream> opened{new ReconnectingStream{backend, request, processor}};
  if (auto status = opened->reopen(); !status) return tl::unexpected(status.error());
  // From now on it is this device, whichever becomes the default.
  opened->request_.device = opened->granted_.device;
  opened->request_.input_device = opened->granted_.input_device;
  opened->request_.sample_rate = opened->granted_.format.sample_rate;
  return opened;
}

Status ReconnectingStream::start(const std::function<void()>& ready) {
  wanted_ = true;
  return stream_ ? stream_->start(ready) : Status{};
}

Status ReconnectingStream::stop() {
  wanted_ = false;
  return stream_ ? stream_->stop() : Status{};
}

Status ReconnectingStream::reopen() {
  auto stream = backend_.open(request_, processor_);
  if (!stream) return tl::unexpected(stream.error());
  granted_ = (*stream)->granted();
  stream_ = std::move(*stream);
  return {};
}

void ReconnectingStream::tick(Clock::time_point now, std::chrono::nanoseconds suspended) {
  watch_suspension(suspended);
  if (!stream_) return try_again(now);
  for (auto note = stream_->take_note(); !note.empty(); note = stream_->take_note()) report(note);
  const auto state = stream_->state();
  if (state == StreamState::Lost) return lose(now);
  if (state == StreamState::Running) last_running_ = now;
  watch_block_size();
  watch_stall(now);
}

void ReconnectingStream::lose(Clock::time_point now) {
  if (!wanted_) return;
  wanted_ = granted_.comes_back;
  if (!wanted_) return report("disconnected; restart the program to reopen it");
  close(now);
  report("disconnected; outputs are silent until it reconnects");
}

void ReconnectingStream::close(Clock::time_point now) {
  stalled_at_.reset();
  lost_at_ = std::exchange(last_running_, std::nullopt).value_or(now);  // before, it may have hung for long
  suspended_while_lost_ = {};
  before_ = health();
  stream_.reset();
  last_error_.clear();
  next_try_ = now;
}

Status ReconnectingStream::restart(Clock::time_point now) {
  wanted_ = true;
  if (stream_) close(now);
  const auto before = request_.previous = granted_;
  auto status = reopen();
  if (status)
    status = stream_->start([&] {
      const Return back{{}, differences_between_openings(*before, granted_, true)};
      for (const auto& difference : back.differences) report(difference);
      if (returned_) returned_(back);
    });
  if (status) return status;
  stream_.reset();
  granted_ = *before;
  return status;
}

void ReconnectingStream::try_again(Clock::time_point now) {
  if (!wanted_ || now < next_try_) return;
  next_try_ = now + kRetry;
  const auto before = request_.previous = granted_;
  const auto begin = Clock::now();
  auto status = reopen();
  Return back;
  if (status)
    status = stream_->start([&] {
      back = how_it_came_back(now + (Clock::now() - begin), *before);  // libraries may search for seconds
      if (returned_) returned_(back);
    });
  if (status) {
    ++returns_;
    report(fmt::format("reconnected after {:.1f} s", back.away.count()));
    for (const auto& difference : back.differences) report(difference);
    return;
  }
  stream_.reset();
  granted_ = *before;
  if (auto why = to_string(status.error()); why != last_error_) {
    report("waiting for it: " + why);
    last_error_ = std::move(why);
  }
}

Return ReconnectingStream::how_it_came_back(Clock::time_point now, const StreamGranted& before) const {
  Return back{now - lost_at_ + suspended_while_lost_, differences(before, granted_)};
  if (back.away > kShortAbsence)
    back.differences.push_back(fmt::format("it was away for more than {} s", kShortAbsence.count()));
  if (suspended_while_lost_ > suspended_while_lost_.zero())
    back.differences.push_back("the computer was suspended");
  return back;
}

void ReconnectingStream::watch_suspension(std::chrono::nanoseconds suspended) {
  const auto time = suspended - std::exchange(suspended_, suspended).value_or(suspended);
  if (time < kSuspension) return;
  suspended_while_lost_ += time;
  if (stream_)
    change(
        fmt::format("the computer was suspended for {:.1f} s", std::chrono::duration<double>(time).count()));
}

void ReconnectingStream::watch_block_size() {
  const int block = stream_->block_frames();
  if (block == granted_.block_frames) return;
  const int before = std::exchange(granted_.block_frames, block);
  change(fmt::format("the block size is now {} frames instead of {}: the delay has changed", block, before));
}

void ReconnectingStream::change(const std::string& what) {
  report(what);
  if (changed_) changed_();
}

void ReconnectingStream::watch_stall(Clock::time_point now) {
  const bool stalled = stream_->state() == StreamState::Stalled;
  if (stalled_at_ && !stall_is_long_ && now - *stalled_at_ > kShortAbsence) {
    stall_is_long_ = true;
    change(fmt::format("does not respond for more than {} s", kShortAbsence.count()));
  }
  if (stalled == stalled_at_.has_value()) return;
  if (stalled)
    report("does not respond");
  else
    report(fmt::format("responds again after {:.1f} s",
                       std::chrono::duration<double>(now - *stalled_at_).count()));
  stalled_at_ = stalled ? std::optional{last_running_.value_or(now)} : std::nullopt;  // it may notice it late
  stall_is_long_ = false;
}

void ReconnectingStream::report(const std::string& what) {
  events_.push_back("'" + granted_.device + "': " + what);
}

std::optional<std::string> ReconnectingStream::take_event() {
  if (events_.empty()) return std::nullopt;
  auto event = std::move(events_.front());
  events_.pop_front();
  return event;
}

Health ReconnectingStream::health() const { return stream_ ? together(before_, stream_->health()) : before_; }

}  // namespace tactus
