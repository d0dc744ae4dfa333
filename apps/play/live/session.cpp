#include "apps/play/live/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace tactus::app {
namespace {

/// The longest fade of all guards.
Seconds fade_of(const std::vector<GuardedChannel>& guards) {
  Seconds longest{0.0};
  for (const auto& guard : guards) longest = std::max(longest, guard.limits.fade_out);
  return longest;
}

std::vector<SessionView::Level> levels(const std::vector<std::string>& names,
                                       const std::vector<double>& peaks) {
  std::vector<SessionView::Level> all;
  for (std::size_t c = 0; c < names.size() && c < peaks.size(); ++c) all.push_back({names[c], peaks[c]});
  return all;
}

void raise(std::vector<double>& highest, const std::vector<double>& peaks) {
  highest.resize(peaks.size(), 0.0);
  for (std::size_t c = 0; c < peaks.size(); ++c) highest[c] = std::max(highest[c], peaks[c]);
}

}  // namespace

Session::Session(Performer& performer, Backend& backend, StreamRequest request, bool armed)
    : performer_(performer),
      backend_(backend),
      request_(std::move(request)),
      guards_(performer.guards()),
      guarded_(performer.processor(), guards_, armed),
      meter_(request_.in_channels, request_.out_channels),
      controls_(performer.instrument()),
      armed_(armed),
      seen_guards_(guards_.size()) {
  guarded_.set_tap(&meter_);
  files_.watch(performer_.files());
}

Session::~Session() {
  std::vector<std::string> unread;
  (void)stop(unread);
}

void Session::record(const std::filesystem::path& wav) {
  recording_ = std::make_unique<Recording>(wav, performer_, guarded_, meter_);
}

std::vector<std::filesystem::path> Session::takes() const {
  return recording_ == nullptr ? std::vector<std::filesystem::path>{} : recording_->files();
}

Status Session::open() {
  auto opened = ReconnectingStream::open(backend_, request_, guarded_);
  if (!opened) return tl::unexpected(opened.error());
  stream_ = std::move(*opened);
  if (recording_ != nullptr) {
    if (auto status = recording_->begin(); !status) return status;
    stream_->on_return([this] {
      if (const auto status = recording_->begin(); !status)
        waiting_messages_.push_back("recording stopped: " + to_string(status.error()));
    });
  }
  return {};
}

Status Session::stop(std::vector<std::string>& messages) {
  if (stream_ == nullptr) return {};
  fade_out();
  const auto stopped = stream_->stop();
  if (recording_ != nullptr)
    for (auto& line : recording_->end()) messages.push_back(std::move(line));
  return stopped;
}

/// Returns when the frames of the fade are over, or when no more blocks come.
void Session::fade_out() {
  using State = StreamState;
  if (stream_->state() != State::Running && stream_->state() != State::Stalled) return;
  guarded_.fade(true);
  const double rate = granted().format.sample_rate.value, block_s = granted().format.max_frames / rate;
  const auto until =
      guarded_.frame() + std::llround(fade_of(guards_).value * rate) + 2 * granted().format.max_frames;
  const auto deadline = std::chrono::steady_clock::now() +
                        std::chrono::duration<double>{fade_of(guards_).value + 4 * block_s + 0.5};
  while (guarded_.frame() < until && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
}

bool Session::has_drives() const {
  return std::any_of(guards_.begin(), guards_.end(),
                     [](const GuardedChannel& channel) { return channel.kind == DriveGuard::Kind::Drive; });
}

void Session::arm(bool on) {
  guarded_.arm(on);
  armed_ = on;
}

void Session::mute(bool on) {
  guarded_.mute(on);
  muted_ = on;
}

std::vector<std::string> Session::tick() {
  stream_->tick();
  auto messages = std::exchange(waiting_messages_, {});
  while (auto event = stream_->take_event()) messages.push_back(std::move(*event));
  if (recording_ != nullptr)
    for (auto& line : recording_->news()) messages.push_back(std::move(line));
  report_guard_events(messages);
  report_faults(messages);
  check_delay_after_gap(messages);
  follow_edits(messages);
  return messages;
}

void Session::forget_delay() {
  delay_known_ = false;
  (void)performer_.instrument().post({JournalEntry::kNow, JournalEntry::Kind::SystemDelay, 0, -1.0});
}

/// Some drivers come out of a gap with a buffer more or less.
void Session::check_delay_after_gap(std::vector<std::string>& messages) {
  if (!delay_known_ || !granted().xruns_move_delay || stream_->health().xruns == 0) return;
  forget_delay();
  messages.push_back(
      "a gap may have changed the round-trip latency: it counts as unknown until the device is opened again");
}

/// An edit waits until the one before it has taken over.
void Session::follow_edits(std::vector<std::string>& messages) {
  edit_waits_ = files_.changed() || edit_waits_;
  if (!edit_waits_ || performer_.instrument().replacing()) return;
  edit_waits_ = false;
  if (const auto edited = performer_.edit(); !edited) {
    messages.push_back(to_string(edited.error()) + "\nthe previous version keeps playing");
  } else {
    controls_.renew();
    if (recording_ != nullptr) recording_->edited();
    messages.push_back(performer_.name() + ": edit applied");
  }
  files_.watch(performer_.files());
}

void Session::report_guard_events(std::vector<std::string>& messages) {
  GuardReport names;
  names.input_names = performer_.inputs();
  for (const auto& output : performer_.outputs()) names.outputs.push_back({output, {}, {}, 0.0});
  GuardEvent event;
  while (guarded_.take_event(event)) {
    arm(false);  // one of several drives may still be armed: what is shown is true for all
    events_.push_back(event);
    names.events = {event};
    for (auto& line : in_words(names, granted().format.sample_rate)) messages.push_back(std::move(line));
  }
}

void Session::report_faults(std::vector<std::string>& messages) {
  for (const auto& fault : performer_.instrument().faults()) {
    const auto reported = std::find_if(reported_faults_.begin(), reported_faults_.end(),
                                       [&](const FaultCount& known) { return known.path == fault.path; });
    if (reported != reported_faults_.end()) {
      reported->count = fault.count;
      continue;
    }
    reported_faults_.push_back(fault);
    messages.push_back(fault.path + ": non-finite output; the node was reset and its output is silenced");
  }
}

SessionView Session::look() {
  SessionView view;
  view.drives = has_drives();
  view.armed = armed_;
  view.muted = muted_;
  view.state = stream_ == nullptr ? StreamState::Stopped : stream_->state();
  const auto inputs = performer_.inputs(), outputs = performer_.outputs();
  const auto in = meter_.take_inputs(), out = meter_.take_outputs();
  raise(highest_in_, in);
  raise(highest_out_, out);
  view.inputs = levels(inputs, in);
  view.outputs = levels(outputs, out);
  view.highest_inputs = levels(inputs, highest_in_);
  view.highest_outputs = levels(outputs, highest_out_);
  if (stream_ != nullptr) view.health = stream_->health();
  for (std::size_t c = 0; c < guards_.size(); ++c) {
    const auto counts = guarded_.counts(static_cast<int>(c));
    for (std::size_t s = 0; s < kGuardStages; ++s)
      if (counts.stages[s].frames > seen_guards_[c].stages[s].frames)
        view.guard.push_back(outputs[c] + " " + name_of(static_cast<GuardStage>(s)));
    seen_guards_[c] = counts;
  }
  for (const auto& fault : reported_faults_) view.faults += fault.count;
  if (recording_ != nullptr) view.recorded_s = recording_->seconds();
  return view;
}

GuardReport Session::guard_report() {
  auto report = report_of(guarded_, guards_, performer_.inputs(), performer_.outputs());
  report.events.insert(report.events.begin(), events_.begin(), events_.end());
  return report;
}

}  // namespace tactus::app
