#pragma once
// Thread: [control]

#include "backends/card_callback.h"

namespace tactus {

/// A stream on a sound library: its state, and the order in which callback and library start and stop. `Line`
/// is all that the library touches, with the callback as `card`.
template <class Line>
class CardStream : public Stream {
 public:
  /// `processor` is prepared for `granted.format`; `request` has the channel maps.
  CardStream(std::shared_ptr<Line> line, StreamGranted granted, const StreamRequest& request,
             Guarded& processor)
      : line_(std::move(line)), granted_(std::move(granted)) {
    line_->card = std::make_unique<CardCallback>(processor, request, granted_);
  }

  const StreamGranted& granted() const final { return granted_; }
  Status start() final {
    if (running_) return {};
    if (lost())
      return fail(Errc::Device, "", "'" + granted_.device + "' was disconnected",
                  granted_.comes_back ? "open it again" : "end the program and start it again");
    if (auto status = start_library(); !status) return status;
    line_->card->play();
    running_ = true;
    return {};
  }
  Status stop() final {
    const bool finished = running_ && !lost() && line_->card->finish();
    if (!std::exchange(running_, false)) return {};
    line_->card->abandon();
    return stop_library(finished);
  }
  StreamState state() const final {
    if (lost()) return StreamState::Lost;
    if (!running_) return StreamState::Stopped;
    return line_->card->stalled() ? StreamState::Stalled : StreamState::Running;
  }
  Health health() const final { return line_->card->health(); }

 protected:
  bool running() const { return running_; }

  std::shared_ptr<Line> line_;

 private:
  /// [control] The device or its server went away.
  virtual bool lost() const = 0;
  /// [control] Blocks begin to flow. Errors: Device.
  virtual Status start_library() = 0;
  /// [control] No block comes any more. `finished`: the last block was played. Errors: Device.
  virtual Status stop_library(bool finished) = 0;

  StreamGranted granted_;
  bool running_ = false;
};

}  // namespace tactus
