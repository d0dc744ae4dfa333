#include <fmt/format.h>

#include <chrono>

#include "apps/cli/console.h"
#include "apps/play/live/controls/keyboard.h"
#include "apps/play/live/controls/status_line.h"
#include "apps/play/live/plan.h"
#include "apps/play/live/session.h"
#include "apps/play/midi_map.h"
#include "apps/play/save_rig.h"
#include "backends/library_calls.h"
#include "backends/realtime_thread.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kHelp =
    "keys: a arm or disarm | m mute | space strike | up, down select a control | left, right change it | l "
    "MIDI learn | s save the rig | q quit";

std::string source_text(const RigMidi& binding) {
  if (binding.kind == RigMidi::Kind::PitchBend) return "the pitch wheel";
  return fmt::format("{} {}", binding.kind == RigMidi::Kind::Note ? "note" : "controller", binding.number);
}

/// The control loop of a session: keys, MIDI controllers, the status line, and the control that the keys have
/// selected.
class LivePlay {
 public:
  LivePlay(Session& session, LivePlan& plan, const std::string& midi_api)
      : session_(session),
        controls_(session.controls()),
        plan_(plan),
        midi_api_(midi_api),
        midi_map_(plan.rig ? plan.rig->midi : std::vector<RigMidi>{}) {
    if (!midi_map_.bindings().empty() || !midi_api.empty()) open_midi();
  }

  /// `duration`: 0: until it is ended. Returns the exit code.
  int run(Seconds duration) {
    using namespace std::chrono_literals;
    if (keyboard_.is_terminal()) help();
    const auto begin = Clock::now();
    auto drawn = begin - 1s;
    while (true) {
      if (interrupted()) return kInterrupted;
      if (session_.over()) return kDevice;
      const std::chrono::duration<double> played = Clock::now() - begin;
      if (duration.value > 0 && played.count() >= duration.value) return kDone;
      if (const auto key = keyboard_.wait(20ms); key && !press(*key)) return kDone;
      tick();
      if (Clock::now() - drawn < 100ms) continue;
      drawn = Clock::now();
      line_.draw(session_.view(), any() ? controls_.text(selected_) : "");
    }
  }

 private:
  /// What happens without keys: edits, MIDI, device and guard events.
  void tick() {
    session_.tick();
    for (const auto& message : session_.take_messages()) line_.print(message);
    if (midi_ == nullptr) return;
    for (const auto& message : midi_->news()) line_.print(message);
    for (const auto& event : midi_->poll()) {
      for (const auto& move : midi_map_.handle(event)) (void)controls_.turn(move.control, move.position);
      if (const auto learnt = midi_map_.take_learnt())
        line_.print(fmt::format("{} of {} now controls {}; s saves this in the rig", source_text(*learnt),
                                event.port, learnt->control));
    }
  }

  /// False: the user wants to end it.
  bool press(char pressed) {
    for (const auto& [key, act] : {std::pair{'a', &LivePlay::arm},
                                   {'m', &LivePlay::mute},
                                   {' ', &LivePlay::strike},
                                   {'l', &LivePlay::learn},
                                   {'s', &LivePlay::save},
                                   {'?', &LivePlay::help},
                                   {'h', &LivePlay::help}})
      if (key == pressed) (this->*act)();
    if (pressed == kUpKey || pressed == kDownKey) select(pressed == kUpKey ? -1 : 1);
    if (pressed == kLeftKey || pressed == kRightKey) turn(pressed == kLeftKey ? -0.05 : 0.05);
    return pressed != 'q';
  }

  bool any() const { return selected_ < controls_.all().size(); }
  const std::string& name() const { return controls_.all()[selected_].control.name; }

  bool open_midi() {
    if (midi_ == nullptr) midi_ = make_midi_inputs(midi_api_);
    return midi_ != nullptr;
  }

  void arm() {
    if (!session_.has_drives()) return line_.print("there is no drive to arm");
    if (const auto armed = session_.arm(!session_.armed()); !armed)
      return line_.print(to_string(armed.error()));
    line_.print(session_.armed() ? "drives armed" : "drives disarmed");
  }
  void mute() {
    session_.mute(!session_.muted());
    line_.print(session_.muted() ? "muted" : "unmuted");
  }
  void strike() {
    if (!plan_.performer->strike()) line_.print("this scene has no strike gesture; m mutes, a arms");
  }
  void help() { line_.print(kHelp); }
  void select(int step) {
    const auto count = static_cast<int>(controls_.all().size());
    if (count > 0) selected_ = index((static_cast<int>(selected_) + step + count) % count);
  }
  void turn(double share) {
    if (any() && !controls_.nudge(selected_, share))
      line_.print(name() + " cannot be changed during playback");
  }
  void learn() {
    if (!any()) return;
    if (!open_midi()) return line_.print("this program was built without MIDI");
    midi_map_.learn(name());
    line_.print("move the MIDI controller for " + name());
  }
  void save() {
    if (!plan_.rig) return line_.print("there is no rig file: start with --save-rig FILE");
    plan_.rig->midi = midi_map_.bindings();
    plan_.rig->controls.clear();
    for (const auto& live : controls_.all())
      plan_.rig->controls.push_back({live.control.name, {}, {live.control.value, live.control.unit, false}});
    const auto& file = plan_.rig_file;
    const auto saved = replace_rig(*plan_.rig, file);
    line_.print(saved ? file + ": controls and MIDI bindings saved; the previous file is " + file + "~"
                      : to_string(saved.error()));
  }

  Session& session_;
  LiveControls& controls_;
  LivePlan& plan_;
  StatusLine line_;
  Keyboard keyboard_;
  std::string midi_api_;
  MidiMap midi_map_;
  std::shared_ptr<MidiInputs> midi_;  ///< opened when something is bound or MIDI learn is on
  std::size_t selected_ = 0;
};

/// What plays where, and the state of the drives.
void announce(const Session& session, const LivePlan& plan, const LiveOptions& options) {
  fmt::print(stderr, "{}\n{}\n", plan.performer->name, granted_text(plan, session.granted()));
  if (options.listen)
    fmt::print(stderr,
               "the sound is played on the first channels of {}: connect speakers there, not actuators\n",
               session.granted().device);
  else
    fmt::print(stderr, "{}\n", delay_text(plan));
  if (!options.arm && session.has_drives())
    fmt::print(stderr, "the drives are disarmed: press a, or start with --arm\n");
}

}  // namespace

int play_live(const LiveOptions& options) {
  const auto duration = options.duration.empty() ? 0_s : parse_duration(options.duration);
  auto plan = make_plan(options);
  if (const auto locked = lock_memory(); !locked) fmt::print(stderr, "note: {}\n", to_string(locked.error()));
  Session session{*plan.performer, *plan.devices.backend, plan.request, options.arm};
  session.share_ports(options.shared_port);
  install_signal_handlers(/*also_hangup=*/true);
  if (const auto opened = session.open(options.record); !opened)
    exit_with(opened.error(), exit_of(opened.error()));
  check_delay(plan, session.granted());
  session.set_delay(plan.delay ? std::optional{plan.delay_settings} : std::nullopt);
  or_exit(session.start(), kDevice);
  announce(session, plan, options);
  on_slow_call({});  // a note of a library must not hold up the keys

  const int ended = LivePlay{session, plan, options.midi}.run(duration);
  const auto& view = session.view();
  const auto stopped = session.stop();
  for (const auto& message : session.take_messages()) fmt::print(stderr, "{}\n", message);
  print_report(session, view, *plan.performer, options.json);
  or_exit(stopped, kDevice);
  return ended;
}

}  // namespace tactus::app
