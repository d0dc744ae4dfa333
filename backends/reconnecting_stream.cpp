#include "backends/reconnecting_stream.h"

#include <fmt/format.h>

#include <utility>

namespace tactus {
Result<std::unique_ptr<ReconnectingStream>> ReconnectingStream::open(Backend& backend,
                                                                     const StreamRequest& request,
                                                                     Guarded& processor) {
  std::unique_ptr<ReconnectingStream> opened{new ReconnectingStream{backend, request, processor}};
  if (auto status = opened->reopen(); !status) return tl::unexpected(status.error());
  // From now on it is this device, whichever becomes the default.
  opened->request_.device = opened->granted_.device;
  opened->request_.input_device = opened->granted_.input_device;
  opened->request_.sample_rate = opened->granted_.format.sample_rate;
  return opened;
}

Status ReconnectingStream::start() {
  wanted_ = true;
  return stream_ ? stream_->start() : Status{};
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

void ReconnectingStream::tick(Clock::time_point now) {
  if (!stream_) return try_again(now);
  for (auto note = stream_->take_note(); !note.empty(); note = stream_->take_note()) report(note);
  if (stream_->state() == StreamState::Lost) return lose(now);
  watch_stall(now);
}

void ReconnectingStream::lose(Clock::time_point now) {
  if (!wanted_) return;
  stalled_at_.reset();
  lost_at_ = now;
  wanted_ = granted_.comes_back;
  if (!wanted_) return report("disconnected; restart the program to reopen it");
  before_ = health();
  stream_.reset();
  report("disconnected; outputs are silent until it reconnects");
  last_error_.clear();
  next_try_ = now;
}

void ReconnectingStream::try_again(Clock::time_point now) {
  if (!wanted_ || now < next_try_) return;
  next_try_ = now + kRetry;
  const int block = granted_.block_frames;
  auto status = reopen();
  if (status && reopened_) reopened_();
  if (status) status = stream_->start();
  if (status) {
    ++returns_;
    report(fmt::format("reconnected after {:.1f} s", std::chrono::duration<double>(now - lost_at_).count()));
    if (granted_.block_frames != block)
      report(fmt::format("block size is now {} frames instead of {}: the delay has changed",
                         granted_.block_frames, block));
    return;
  }
  stream_.reset();
  if (auto why = to_string(status.error()); why != last_error_) {
    report("waiting for it: " + why);
    last_error_ = std::move(why);
  }
}

void ReconnectingStream::watch_stall(Clock::time_point now) {
  const bool stalled = stream_->state() == StreamState::Stalled;
  if (stalled == stalled_at_.has_value()) return;
  if (stalled)
    report("does not respond");
  else
    report(fmt::format("responds again after {:.1f} s",
                       std::chrono::duration<double>(now - *stalled_at_).count()));
  stalled_at_ = stalled ? std::optional{now} : std::nullopt;
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
