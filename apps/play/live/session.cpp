#include "apps/play/live/session.h"

#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <thread>

#include "apps/cli/console.h"
#include "apps/cli/take_files.h"
#include "apps/play/live/controls/status_line.h"
#include "apps/play/play_report.h"

namespace tactus::app {
namespace {

void update(std::vector<SessionView::Level>& levels, const std::vector<double>& peaks) {
  for (std::size_t c = 0; c < levels.size(); ++c) {
    levels[c].peak = peaks[c];
    levels[c].highest = std::max(levels[c].highest, peaks[c]);
  }
}

Json session_health(const Health& health) {
  return {{"blocks", health.blocks},
          {"frames", health.frames},
          {"xruns", health.xruns},
          {"xruns_by_cause", gaps_json(health)},
          {"lost_frames", health.lost_frames},
          {"late_blocks", health.late_blocks},
          {"bad_input_samples", health.bad_input},
          {"load_median", health.median_load},
          {"load_p999", health.high_load},
          {"load_worst", health.peak_load},
          {"realtime_priority", health.realtime_priority}};
}

Json levels_json(const std::vector<SessionView::Level>& levels) {
  Json json = Json::object();
  for (const auto& level : levels) json[level.name] = level.highest;
  return json;
}

/// Timed on what has played, which has stopped.
std::vector<NetworkReport> networks_of(const Session& session, Performer& performer) {
  return performer.networks(std::min(kMaxSubBlock, session.granted().format.max_frames));
}

Json report_json(Session& session, const SessionView& view, Performer& performer) {
  const auto& granted = session.granted();
  const auto guard = session.guard_report();
  Json json{{"instrument", performer.name},
            {"device", granted.device},
            {"sample_rate_hz", granted.format.sample_rate.value},
            {"block_frames", granted.block_frames},
            {"highest_input", levels_json(view.inputs)},
            {"highest_output", levels_json(view.outputs)},
            {"health", session_health(view.health)},
            {"takes", list_of(session.takes(), [](const auto& take) { return take.string(); })},
            {"limits", limits_json(guard)},
            {"guard", guard_json(guard, granted.format.sample_rate)}};
  if (const auto ports = performer.ports(); !ports.empty()) json["ports"] = ports_json(ports);
  json["network_solvers"] = networks_json(networks_of(session, performer));
  return json;
}

WatchedFiles watched(const Performer& performer) {
  WatchedFiles files;
  files.watch(performer.files);
  return files;
}

}  // namespace

Session::Session(Performer& performer, Backend& backend, StreamRequest request, bool armed,
                 const DeadMansSwitch* dead_man)
    : performer_(performer),
      backend_(backend),
      request_(std::move(request)),
      guarded_(performer.processor(), performer.guards, armed),
      switches_(guarded_, armed),
      meter_(request_.in_channels, request_.out_channels),
      controls_(performer.instrument()),
      seen_guards_(performer.guards.size()),
      edits_(watched(performer), [&performer] { return performer.read_edit(); }) {
  view_.drives = std::any_of(performer.guards.begin(), performer.guards.end(),
                             [](const auto& channel) { return channel.kind == DriveGuard::Kind::Drive; });
  for (const auto& input : performer.inputs) view_.inputs.push_back({input});
  for (const auto& output : performer.outputs) view_.outputs.push_back({output});
  guarded_.set_tap(&meter_);
  meter_.set_next(&take_);
  performer.instrument().set_tap(&take_);
  guarded_.set_dead_mans_switch(dead_man);
  guarded_.suppose_worst();
}

void Session::add_meter(std::shared_ptr<LevelMeter> meter) {
  second_meter_ = std::move(meter);
  second_meter_->set_next(&meter_);
  guarded_.set_tap(second_meter_.get());
}

Session::GuardUse Session::guard_use(int output) const {
  const auto& limits = guarded_.channels()[index(output)].limits;
  GuardUse use;
  if (limits.heat) {
    const auto heat = guarded_.thermal_state(output);
    use = {heat.coil, heat.body, {}};
  }
  if (limits.excursion) use.excursion = guarded_.excursion(output);
  return use;
}

Session::~Session() {
  (void)stop();
  performer_.instrument().set_tap(nullptr);
}

Status Session::stop() {
  if (stream_ == nullptr) return {};
  fade_out();
  auto stopped = stream_->stop();
  end_take();
  if (ended_take_.valid()) ended_take_.wait();
  report_ended_take();
  return stopped;
}

/// Returns when every output is at zero, or when no more blocks come.
void Session::fade_out() {
  using State = StreamState;
  if (stream_->state() != State::Running && stream_->state() != State::Stalled) return;
  guarded_.fade(true);
  const auto& format = granted().format;
  const double block_s = format.max_frames / format.sample_rate.value;
  const auto deadline = std::chrono::steady_clock::now() +
                        std::chrono::duration<double>{closing_time().value + 4 * block_s + 0.5};
  while (!guarded_.silent() && std::chrono::steady_clock::now() < deadline)
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
}

void Session::control_stalled() {
  if (!device_runs_ || !armed()) return;
  switches_.disarm();
  control_stalled_ = true;
}

void Session::tick() {
  device_runs_ = stream_->state() == StreamState::Running;
  if (control_stalled_.exchange(false))
    messages_.emplace_back("drives disarmed: the program did not watch its device for 0.5 s");
  stream_->tick();
  watch_writers();
  while (auto event = stream_->take_event()) messages_.push_back(std::move(*event));
  for (auto& note : std::exchange(notes_, {})) messages_.push_back(std::move(note));
  report_recording();
  report_ended_take();
  report_guard_events();
  report_faults();
  check_delay_after_gap();
  follow_edits();
  // A value posted before an edit takes over would be applied to the version after it.
  if (plays()) send_controls();
}

/// An edit waits until the one before it has taken over.
void Session::follow_edits() {
  if (performer_.instrument().replacing()) return;
  if (const auto edit = edits_.take()) take_over(*edit);
}

void Session::take_over(const Edit& edit) {
  if (!edit.files.empty()) performer_.files = edit.files;
  if (!edit.warning.empty()) messages_.push_back(edit.warning);
  try {
    if (!edit.errors.empty()) exit_with(edit.errors);
    edit.take_over(guarded_);
    controls_.renew();
    note_edit();
    messages_.push_back(performer_.name + ": edit applied");
    if (on_edit_) on_edit_({});
  } catch (const CommandError& error) {
    if (on_edit_) on_edit_(error.errors);
    messages_.push_back(to_string(error.errors) + "\nthe previous version keeps playing");
  }
}

void Session::report_guard_events() {
  GuardReport names;
  names.input_names = performer_.inputs;
  for (const auto& output : performer_.outputs) names.outputs.push_back({output, {}, {}, 0.0});
  GuardEvent event;
  while (guarded_.take_event(event)) {
    // One of several drives may still be armed: what is shown is true for all.
    if (event.kind != GuardEvent::Kind::DeadMan) switches_.disarm();
    if (event.kind == GuardEvent::Kind::Feedback) view_.drives = true;
    events_.push_back(event);
    names.events = {event};
    for (auto& line : describe(names, granted().format.sample_rate)) {
      if (on_guard_event_) on_guard_event_(event, line);
      messages_.push_back(std::move(line));
    }
  }
}

void Session::report_faults() {
  for (const auto& fault : performer_.instrument().faults())
    if (!std::exchange(fault_counts_[fault.path], fault.count))
      messages_.push_back(fault.path + ": non-finite output; the node was reset and its output set to zero");
}

Status Session::begin_take() {
  auto header = take_header(performer_.instrument(), guarded_);
  header.program = version();
  performer_.describe(header);
  if (std::exchange(first_take_, record_) != record_) takes_of_name_ = 0;
  auto file = record_;
  // A take that failed may have left its file.
  for (std::error_code none; takes_of_name_ > 0; ++takes_of_name_) {
    file.replace_filename(
        fmt::format("{}-{}{}", record_.stem().string(), takes_of_name_ + 1, record_.extension().string()));
    if (!std::filesystem::exists(file, none)) break;
  }
  auto begun = TakeRecorder::start(file, std::move(header));
  if (!begun) return tl::unexpected(begun.error());
  recorder_ = std::move(*begun);
  ++takes_of_name_;
  takes_.push_back(file);
  recording_ = {};
  take_.set(&recorder_->tap());
  return {};
}

/// What is left of it is written on a thread of its own: the disk may be slow.
void Session::end_take() {
  if (recorder_ == nullptr) return;
  take_.set(nullptr);
  if (ended_take_.valid()) ended_take_.wait();
  report_ended_take();
  ended_take_ = std::async(
      std::launch::async, [recorder = std::shared_ptr{std::move(recorder_)}, file = takes_.back()] {
        auto messages = recorder->finish();
        messages.push_back(
            fmt::format("recorded {:.1f} s: {}", recorder->status().recorded.value, file.string()));
        return messages;
      });
}

void Session::report_ended_take() {
  if (!ended_take_.valid() || ended_take_.wait_for(std::chrono::seconds{0}) == std::future_status::timeout)
    return;
  for (auto& message : ended_take_.get()) messages_.push_back(std::move(message));
}

Status Session::start_recording(const std::filesystem::path& wav) {
  const auto state = stream_->state();
  if (state != StreamState::Running && state != StreamState::Lost)
    return fail(Errc::BadArgument, "", "nothing is recorded: the device does not respond",
                "try again when blocks come");
  if (performer_.instrument().replacing())
    return fail(Errc::BadArgument, "", "nothing is recorded: an edit is being applied", "try again");
  record_ = wav;
  if (state == StreamState::Lost) return {};
  device_runs_ = false;  // nobody is to watch it meanwhile
  fade_out();
  (void)stream_->stop();
  guarded_.fade(false);
  return stream_->restart();
}

void Session::stop_recording() {
  record_.clear();
  end_take();
}

void Session::note_edit() {
  if (recorder_ == nullptr) return;
  TakeHeader now;
  performer_.describe(now);
  const auto& instrument = performer_.instrument();
  recorder_->note_edit(
      {0, std::move(now.files), take_settings(instrument.plan()), instrument.control_names()});
}

std::vector<std::string> RecordingMonitor::update(const TakeStatus& status) {
  if (!status.error.empty()) {
    if (std::exchange(reported_error_, true)) return {};
    return {"recording stopped: " + status.error + "; the instrument keeps playing"};
  }
  if (std::exchange(reported_dropped_, status.dropped_frames) >= status.dropped_frames) return {};
  return {fmt::format("the disk is too slow: {} frames dropped from the recording so far",
                      status.dropped_frames)};
}

void Session::report_recording() {
  if (recorder_ == nullptr) return;
  for (auto& message : recording_.update(recorder_->status())) messages_.push_back(std::move(message));
}

const SessionView& Session::view() {
  if (stream_ != nullptr) {
    view_.state = stream_->state();
    view_.health = stream_->health();
  }
  view_.armed = armed();
  view_.muted = muted();
  update(view_.inputs, meter_.take_inputs());
  update(view_.outputs, meter_.take_outputs());
  view_.guard.clear();
  for (std::size_t c = 0; c < seen_guards_.size(); ++c) {
    const auto counts = guarded_.counts(static_cast<int>(c));
    for (std::size_t s = 0; s < kGuardStages; ++s)
      if (counts[s].frames > seen_guards_[c][s].frames)
        view_.guard.push_back(view_.outputs[c].name + " " + name_of(GuardStage::Index{s}));
    seen_guards_[c] = counts;
  }
  view_.faults = 0;
  for (const auto& [path, count] : fault_counts_) view_.faults += count;
  view_.recorded_s.reset();
  if (recorder_ != nullptr) view_.recorded_s = recorder_->status().recorded.value;
  return view_;
}

GuardReport Session::guard_report() {
  auto report = report_of(guarded_, performer_.guards, performer_.inputs, performer_.outputs);
  report.events.insert(report.events.begin(), events_.begin(), events_.end());
  return report;
}

void print_report(Session& session, const SessionView& view, Performer& performer, bool as_json) {
  if (as_json) return print_json(report_json(session, view, performer));
  for (const auto* levels : {&view.inputs, &view.outputs})
    for (const auto& level : *levels)
      fmt::print("  {:<18}  at most {}\n", level.name, level_text(level.highest));
  fmt::print("  load                {}\n", load_text(view.health));
  fmt::print("  gaps                {}\n", xrun_text(view.health));
  if (view.health.bad_input > 0)
    fmt::print("  bad input           {} non-finite samples replaced by zero\n", view.health.bad_input);
  print_guard(session.guard_report(), session.granted().format.sample_rate);
  print_ports(performer.ports());
  print_networks(networks_of(session, performer));
  for (const auto& take : session.takes()) fmt::print("  take                {}\n", take.string());
}

}  // namespace tactus::app
