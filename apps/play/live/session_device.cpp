#include <fmt/format.h>

#include <algorithm>

#include "apps/play/live/session.h"

// The part of a session that looks after its device: is it still the one that the drives were armed for?

namespace tactus::app {

static constexpr const char* kHiddenWriters =
    "this library does not show who else writes to the ports of the drives";
static constexpr const char* kShowWriters = "use --backend jack, or start with --shared-port";

Status Session::open(const std::filesystem::path& record) {
  record_ = record;
  auto opened = ReconnectingStream::open(backend_, request_, guarded_);
  if (!opened) return tl::unexpected(opened.error());
  stream_ = std::move(*opened);
  guarded_.disable_sensor_watch(granted().digital_inputs);
  stream_->on_return([this](const Return& back) { device_returned(back); });
  stream_->on_change([this] {
    disarm("the device is not as it was; check it before arming");
    check_delay();
  });
  return {};
}

Status Session::start() {
  Status recording;
  const auto started = stream_->start([&] {
    if (!record_.empty()) recording = begin_take();
    if (!recording) guarded_.fade(true);
    watch_writers();
  });
  if (!started || recording) return started;
  (void)stop();
  return recording;
}

/// The engine begins again with the values of its file; what plays must be what the user sees.
void Session::device_returned(const Return& back) {
  if (!back.same()) disarm("the device is not as it was; check it before arming");
  controls_.post_all();
  set_delay_known(delay_.has_value());
  check_delay();
  watch_writers();
  if (record_.empty()) return;
  end_take();
  const auto begun = begin_take();
  if (begun) return;
  record_.clear();
  notes_.push_back("nothing is recorded: " + to_string(begun.error()));
}

Status Session::arm(bool on) {
  auto status = on ? may_arm() : Status{};
  on&& status ? switches_.arm() : switches_.disarm();
  return status;
}

Status Session::may_arm() const {
  if (delay_ && delay_->padded)
    if (const auto why = delay_->why_invalid(granted()); !why.empty())
      return fail(Errc::BadArgument, "", "the drives stay disarmed: " + why + ": the padding is unknown",
                  "set the device to that block size, or measure again");
  if (writers_may_be_hidden())
    return fail(Errc::Device, "", std::string{"the drives stay disarmed: "} + kHiddenWriters, kShowWriters);
  if (const auto writers = writers_to_drives(); !writers.empty() && !shared_ports_)
    return fail(Errc::Device, "",
                "the drives stay disarmed: '" + writers.front().from + "' also writes to '" +
                    writers.front().to + "'",
                "disconnect it, or start with --shared-port");
  return {};
}

void Session::disarm(const std::string& why) {
  if (view_.drives && armed()) notes_.push_back("drives disarmed: " + why);
  switches_.disarm();
}

bool Session::writers_may_be_hidden() const {
  return view_.drives && granted().writers_unknown && !shared_ports_;
}

/// What reaches an actuator on such a connection has not passed its guard.
std::vector<OtherWriter> Session::writers_to_drives() const {
  auto writers = stream_->other_writers();
  std::erase_if(writers, [&](const OtherWriter& writer) {
    const auto c = index(writer.output);
    return c < performer_.guards.size() && performer_.guards[c].kind == DriveGuard::Kind::Audio;
  });
  return writers;
}

void Session::watch_writers() {
  auto writers = writers_to_drives();
  for (const auto& writer : writers)
    if (std::ranges::find(writers_, writer) == writers_.end())
      notes_.push_back("'" + writer.from + "' also writes to '" + writer.to +
                       "': no guard limits what the actuator gets");
  writers_ = std::move(writers);
  if (!writers_.empty() && !shared_ports_ && armed())
    disarm("disconnect these ports, or start with --shared-port");
  if (writers_may_be_hidden() && armed()) disarm(std::string{kHiddenWriters} + "; " + kShowWriters);
  if (stream_->take_output_cut()) disarm("another program disconnected an output");
}

std::string DelaySettings::why_invalid(const StreamGranted& granted) const {
  const int as_measured = block.value_or(granted.block_frames);
  if (as_measured != granted.block_frames)
    return fmt::format("the delay was measured with {} frames per block, but the block size is {}",
                       as_measured, granted.block_frames);
  if (granted.periods > 0 && periods.value_or(granted.periods) != granted.periods)
    return fmt::format("the delay was measured with {} periods, but there are {}", *periods, granted.periods);
  return {};
}

void Session::set_delay(std::optional<DelaySettings> settings) {
  delay_ = settings;
  set_delay_known(delay_.has_value());
}

void Session::set_delay_known(bool known) {
  delay_known_ = known;
  if (!known)
    (void)performer_.instrument().post({JournalEntry::kNow, JournalEntry::Kind::SystemDelay, 0, -1.0});
}

void Session::check_delay() {
  const auto why = delay_known_ ? delay_->why_invalid(granted()) : "";
  if (why.empty()) return;
  set_delay_known(false);
  notes_.push_back(why + "; the delay is treated as unknown");
}

/// Some drivers come out of a gap with a buffer more or less.
void Session::check_delay_after_gap() {
  if (!delay_known_ || !granted().xruns_move_delay || stream_->health().xruns == 0) return;
  set_delay_known(false);
  messages_.push_back(
      "a gap may have changed the round-trip latency: it is treated as unknown until the device is reopened");
}

}  // namespace tactus::app
