#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "backends/backend.h"

namespace tactus {

/// How a device came back.
struct Return {
  std::chrono::duration<double> away{};  ///< suspension of the computer included
  /// In what it is not as it was, a sentence each: the device itself, its settings, a long absence, a
  /// suspension.
  std::vector<std::string> differences;

  /// [any] It is the same device with the same settings, and was away for a moment only.
  bool same() const { return differences.empty(); }
};

/// [any] For how long the computer was suspended since it was started, where the system counts it.
std::chrono::nanoseconds time_suspended();

/// A stream that comes back: when its device is Lost it is destroyed, and opened again every 200 ms until
/// that device is there, at the same rate. Each time the processor is prepared anew, so the guards open
/// softly. What is not as it was is reported; the caller decides what it may still do. All functions are
/// called from one control thread.
class ReconnectingStream {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kRetry{200};
  static constexpr std::chrono::seconds kShortAbsence{10};
  static constexpr std::chrono::milliseconds kSuspension{500};  ///< shorter ones are not counted

  /// [control] `backend` and `processor` outlive it. Errors: those of Backend::open.
  static Result<std::unique_ptr<ReconnectingStream>> open(Backend& backend, const StreamRequest& request,
                                                          GuardedBlocks& processor);

  /// [control] `returned` is called each time that the device came back, before blocks flow again.
  void on_return(std::function<void(const Return&)> returned) { returned_ = std::move(returned); }
  /// [control] `changed` is called when a running stream is not as it was: another block size, no response
  /// for longer than a short absence, or the computer was suspended.
  void on_change(std::function<void()> changed) { changed_ = std::move(changed); }
  /// [control] As in Stream. What is stopped does not come back by itself.
  [[nodiscard]] Status start(const std::function<void()>& ready = [] {});
  [[nodiscard]] Status stop();
  /// [control] Closes the device and opens it again at once, so that the processor starts again at frame 0;
  /// `returned` is called as after a loss. Unknown hardware is no difference here. Errors: those of
  /// Backend::open and Stream::start; the device then counts as lost, and is looked for by `tick`.
  [[nodiscard]] Status restart(Clock::time_point now = Clock::now());
  /// [control] Checks the stream and reopens it; to be called some 20 times a second, in any state. It may
  /// take as long as Backend::open does. `now` and `suspended` (see `time_suspended`) never go back.
  void tick(Clock::time_point now = Clock::now(), std::chrono::nanoseconds suspended = time_suspended());
  /// [control] What happened since the last call, as messages for the user, oldest first.
  std::optional<std::string> take_event();

  /// [any] What was granted last.
  const StreamGranted& granted() const { return granted_; }
  /// [any] Lost until the device is back; for good if the backend cannot open it again in this process.
  StreamState state() const { return stream_ ? stream_->state() : StreamState::Lost; }
  /// [any] Counted over all openings; the quantiles of the load are those of the last one.
  Health health() const;
  /// [control] As in Stream; none while the device is away.
  bool take_output_cut() { return stream_ && stream_->take_output_cut(); }
  std::vector<OtherWriter> other_writers() const {
    return stream_ ? stream_->other_writers() : std::vector<OtherWriter>{};
  }
  /// [any] How often it was lost and came back.
  int returns() const { return returns_; }

 private:
  ReconnectingStream(Backend& backend, StreamRequest request, GuardedBlocks& processor)
      : backend_(backend), request_(std::move(request)), processor_(processor) {}

  Status reopen();
  void close(Clock::time_point now);
  void lose(Clock::time_point now);
  void try_again(Clock::time_point now);
  Return how_it_came_back(Clock::time_point now, const StreamGranted& before) const;
  void watch_stall(Clock::time_point now);
  void watch_block_size();
  void watch_suspension(std::chrono::nanoseconds suspended);
  void change(const std::string& what);
  void report(const std::string& what);

  Backend& backend_;
  StreamRequest request_;
  GuardedBlocks& processor_;
  std::unique_ptr<Stream> stream_;  ///< nullptr while the device is away
  StreamGranted granted_;
  Health before_;  ///< of the streams that were lost
  std::deque<std::string> events_;
  std::string last_error_;
  Clock::time_point lost_at_, next_try_;
  std::optional<Clock::time_point> last_running_;  ///< when the stream was last seen to run
  std::optional<Clock::time_point> stalled_at_;
  bool stall_is_long_ = false;  ///< longer than a short absence: reported
  std::optional<std::chrono::nanoseconds> suspended_;
  std::chrono::nanoseconds suspended_while_lost_{};
  std::function<void(const Return&)> returned_;
  std::function<void()> changed_;
  bool wanted_ = false;  ///< it should be running
  int returns_ = 0;
};

}  // namespace tactus
