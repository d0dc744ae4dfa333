#include <fmt/format.h>

#include <chrono>

#include "apps/cli/commands.h"
#include "apps/cli/console.h"
#include "apps/cli/interrupts.h"
#include "apps/play/live/controls/keyboard.h"
#include "apps/play/live/controls/midi_controls.h"
#include "apps/play/live/controls/status_line.h"
#include "apps/play/live/live_options.h"
#include "apps/play/live/plan.h"
#include "apps/play/live/session.h"
#include "apps/play/live/session_report.h"
#include "apps/play/save_rig.h"
#include "backends/realtime_thread.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kHelp =
    "keys: a arm or disarm | m mute | space strike | up, down select a control | left, right change it | "
    "l MIDI learn for it | s save the rig | q quit";

/// The keys of a session, and the control that they have selected.
class LivePlay {
 public:
  LivePlay(Session& session, Plan& plan, const LiveOptions& options, StatusLine& line)
      : session_(session),
        plan_(plan),
        line_(line),
        midi_(options.midi, plan.rig ? plan.rig->midi : std::vector<RigMidi>{}, session.controls()) {}

  /// What happens without keys: edits, MIDI, device and guard events.
  void tick() {
    for (const auto& words : session_.tick()) line_.say(words);
    for (const auto& words : midi_.tick()) line_.say(words);
  }

  /// False: the user wants to end it.
  bool press(const Key& key) {
    switch (key.kind) {
      case Key::Kind::Up:
        choose(-1);
        break;
      case Key::Kind::Down:
        choose(1);
        break;
      case Key::Kind::Left:
        turn(-0.05);
        break;
      case Key::Kind::Right:
        turn(0.05);
        break;
      case Key::Kind::Character:
        return press(key.character);
      default:
        break;
    }
    return true;
  }

  std::string selected_control() const {
    return chosen_ < session_.controls().all().size() ? session_.controls().text(chosen_) : "";
  }

 private:
  bool press(char key) {
    switch (key) {
      case 'q':
        return false;
      case 'a':
        if (!session_.has_drives()) {
          line_.say("there is no drive to arm");
          break;
        }
        session_.arm(!session_.armed());
        line_.say(session_.armed() ? "drives armed" : "drives disarmed");
        break;
      case 'm':
        session_.mute(!session_.muted());
        line_.say(session_.muted() ? "muted" : "unmuted");
        break;
      case ' ':
        if (!plan_.performer->strike()) line_.say("this scene has no strike; m mutes, a arms");
        break;
      case 'l':
        learn();
        break;
      case 's':
        save();
        break;
      case '?':
      case 'h':
        line_.say(kHelp);
        break;
      default:
        break;
    }
    return true;
  }
  void choose(int step) {
    const auto count = static_cast<int>(session_.controls().all().size());
    if (count > 0) chosen_ = index((static_cast<int>(chosen_) + step + count) % count);
  }
  void turn(double share) {
    if (chosen_ >= session_.controls().all().size()) return;
    if (!session_.controls().nudge(chosen_, share))
      line_.say(session_.controls().all()[chosen_].control.name + " is fixed while it plays");
  }

  void learn() {
    if (chosen_ >= session_.controls().all().size()) return;
    const auto& name = session_.controls().all()[chosen_].control.name;
    line_.say(midi_.learn(name) ? "move the MIDI controller for " + name
                                : "this program was built without MIDI");
  }
  void save() {
    if (!plan_.rig) return line_.say("there is no rig file: start with --save-rig FILE");
    plan_.rig->midi = midi_.bindings();
    plan_.rig->controls.clear();
    for (const auto& [control, frozen] : session_.controls().all())
      plan_.rig->controls.push_back({control.name, {}, {control.value, control.unit, false}});
    const auto saved = replace_rig(*plan_.rig, plan_.rig_file);
    line_.say(saved ? plan_.rig_file + ": controls and MIDI bindings saved; the former file is " +
                          plan_.rig_file + "~"
                    : to_string(saved.error()));
  }

  Session& session_;
  Plan& plan_;
  StatusLine& line_;
  MidiControls midi_;
  std::size_t chosen_ = 0;
};

Result<double> seconds_of(const std::string& text, const char* option) {
  if (text.empty()) return 0.0;
  const auto seconds = parse_option(text, "s", option);
  if (seconds && !(*seconds > 0))
    return fail(Errc::OutOfRange, std::string{"--"} + option, "must be above 0 s", "");
  return seconds;
}

/// The control loop: keys, edits, the status line. Returns the exit code.
int run_play_live(Session& session, Plan& plan, const LiveOptions& options, double seconds) {
  using namespace std::chrono_literals;
  StatusLine line;
  Keyboard keyboard;
  LivePlay player{session, plan, options, line};
  if (keyboard.is_terminal()) line.say(kHelp);
  const auto begin = Clock::now();
  auto drawn = begin - 1s;
  while (true) {
    if (interrupted()) return kInterrupted;
    if (session.over()) return kDevice;
    if (seconds > 0 && std::chrono::duration<double>(Clock::now() - begin).count() >= seconds) return kDone;
    if (const auto key = keyboard.wait(20ms); key && !player.press(*key)) return kDone;
    player.tick();
    if (Clock::now() - drawn < 100ms) continue;
    drawn = Clock::now();
    line.draw(session.look(), player.selected_control());
  }
}

/// What plays where, and the state of the drives.
void announce(const Session& session, const Plan& plan, const LiveOptions& options) {
  fmt::print(stderr, "{}\n{}\n", plan.performer->name(), granted_in_words(plan, session.granted()));
  if (options.listen)
    fmt::print(stderr, "sound goes to the first channels of {}: connect speakers there, no actuators\n",
               session.granted().device);
  else
    fmt::print(stderr, "{}\n", delay_in_words(plan));
  if (!options.arm && session.has_drives())
    fmt::print(stderr, "the drives are disarmed: press a, or start with --arm\n");
}

}  // namespace

int play_live(const LiveOptions& options) {
  const auto seconds = seconds_of(options.duration, "duration");
  if (!seconds) return report(seconds.error()), kUsage;
  auto plan = make_plan(options);
  if (!plan) return report(plan.error().errors), plan.error().exit;

  if (const auto locked = lock_memory(); !locked) fmt::print(stderr, "note: {}\n", to_string(locked.error()));
  Session session{*plan->performer, *plan->devices.backend, plan->request, options.arm};
  if (!options.record.empty()) session.record(options.record);
  install_signal_handlers(/*also_hangup=*/true);
  if (const auto opened = session.open(); !opened) return report(opened.error()), exit_of(opened.error());
  if (const auto known = check_delay(*plan, session.granted()); !known) return report(known.error()), kUsage;
  if (plan->delay_s)
    session.know_delay();
  else
    session.forget_delay();
  if (const auto started = session.start(); !started) return report(started.error()), kDevice;
  announce(session, *plan, options);

  const int ended = run_play_live(session, *plan, options, *seconds);
  const auto view = session.look();
  std::vector<std::string> words;
  const auto stopped = session.stop(words);
  for (const auto& line : words) fmt::print(stderr, "{}\n", line);
  print_report(session, view, *plan->performer, options.json);
  if (!stopped) return report(stopped.error()), kDevice;
  return ended;
}

}  // namespace tactus::app
