#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "backends/backend.h"

namespace tactus {

/// A stream that comes back: when its device is Lost it is destroyed, and opened again every 200 ms until the
/// very same device is there, at the very same rate. Each time the processor is prepared anew, so the guards
/// open softly. All functions are called from one control thread.
class ReconnectingStream {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kRetry{200};

  /// [control] `backend` and `processor` outlive it. Errors: those of Backend::open.
  static Result<std::unique_ptr<ReconnectingStream>> open(Backend& backend, const StreamRequest& request,
                                                          Guarded& processor);

  /// [control] `reopened` is called each time that the device came back, before blocks flow again.
  void on_return(std::function<void()> reopened) { reopened_ = std::move(reopened); }
  /// [control] As in Stream. What is stopped does not come back by itself.
  [[nodiscard]] Status start();
  [[nodiscard]] Status stop();
  /// [control] Checks the stream and reopens it; to be called some 20 times a second, in any state. It may
  /// take as long as Backend::open does. `now` never goes back.
  void tick(Clock::time_point now = Clock::now());
  /// [control] What happened since the last call, as messages for the user, oldest first.
  std::optional<std::string> take_event();

  /// [any] What was granted last.
  const StreamGranted& granted() const { return granted_; }
  /// [any] Lost until the device is back; for good if the backend cannot open it again in this process.
  StreamState state() const { return stream_ ? stream_->state() : StreamState::Lost; }
  /// [any] Counted over all openings; the quantiles of the load are those of the last one.
  Health health() const;
  /// [any] How often it was lost and came back.
  int returns() const { return returns_; }

 private:
  ReconnectingStream(Backend& backend, StreamRequest request, Guarded& processor)
      : backend_(backend), request_(std::move(request)), processor_(processor) {}

  Status reopen();
  void lose(Clock::time_point now);
  void try_again(Clock::time_point now);
  void watch_stall(Clock::time_point now);
  void report(const std::string& what);

  Backend& backend_;
  StreamRequest request_;
  Guarded& processor_;
  std::unique_ptr<Stream> stream_;  ///< nullptr while the device is away
  StreamGranted granted_;
  Health before_;  ///< of the streams that were lost
  std::deque<std::string> events_;
  std::string last_error_;
  Clock::time_point lost_at_, next_try_;
  std::optional<Clock::time_point> stalled_at_;
  std::function<void()> reopened_;
  bool wanted_ = false;  ///< it should be running
  int returns_ = 0;
};

}  // namespace tactus
