#include <fmt/format.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>

#include "apps/commands.h"
#include "apps/console.h"
#include "apps/live/keyboard.h"
#include "apps/live/live_options.h"
#include "apps/live/plan.h"
#include "apps/live/session.h"
#include "apps/live/status_line.h"
#include "backends/realtime_thread.h"

namespace tactus::app {
namespace {

using Clock = std::chrono::steady_clock;
using Json = nlohmann::ordered_json;

volatile std::sig_atomic_t interrupted = 0;
extern "C" void interrupt(int) { interrupted = 1; }

constexpr const char* kHelp =
    "keys: a arm or disarm | m mute | space strike | up, down choose a control | left, right turn it | q "
    "quit";

/// What the keys do, and what they have chosen.
class Player {
 public:
  Player(Session& session, Performer& performer, StatusLine& line)
      : session_(session), performer_(performer), line_(line) {}

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

  std::string knob() const {
    return chosen_ < session_.knobs().all().size() ? session_.knobs().text(chosen_) : "";
  }

 private:
  bool press(char key) {
    switch (key) {
      case 'q':
        return false;
      case 'a':
        session_.arm(!session_.armed());
        line_.say(session_.armed() ? "the drives are armed" : "the drives are not armed");
        break;
      case 'm':
        session_.mute(!session_.muted());
        line_.say(session_.muted() ? "muted" : "no longer muted");
        break;
      case ' ':
        if (!performer_.strike()) line_.say("there is nothing to strike here; m mutes, a arms");
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
    const auto knobs = static_cast<int>(session_.knobs().all().size());
    if (knobs > 0) chosen_ = static_cast<std::size_t>((static_cast<int>(chosen_) + step + knobs) % knobs);
  }
  void turn(double share) {
    if (chosen_ >= session_.knobs().all().size()) return;
    if (!session_.knobs().nudge(chosen_, share))
      line_.say(session_.knobs().all()[chosen_].name + " cannot be turned while it plays");
  }

  Session& session_;
  Performer& performer_;
  StatusLine& line_;
  std::size_t chosen_ = 0;
};

Json json_of(const Health& health) {
  Json gaps = Json::object();
  for (std::size_t g = 0; g < kGaps; ++g) gaps[name_of(static_cast<Gap>(g))] = health.gaps[g];
  return {{"blocks", health.blocks},
          {"frames", health.frames},
          {"xruns", health.xruns},
          {"xruns_by_cause", gaps},
          {"lost_frames", health.lost_frames},
          {"late_blocks", health.late_blocks},
          {"bad_input_samples", health.bad_input},
          {"load_median", health.median_load},
          {"load_p999", health.high_load},
          {"load_worst", health.peak_load},
          {"realtime_priority", health.realtime_priority}};
}

Json json_of(const std::vector<SessionView::Level>& levels) {
  Json json = Json::object();
  for (const auto& level : levels) json[level.name] = level.peak;
  return json;
}

Result<double> seconds_of(const std::string& text, const char* option) {
  if (text.empty()) return 0.0;
  const auto seconds = parse_option(text, "s", option);
  if (seconds && !(*seconds > 0))
    return fail(Errc::OutOfRange, std::string{"--"} + option, "must be above 0 s", "");
  return seconds;
}

/// Everything but the sound: keys, edits, the status line. Returns why it ended.
int run(Session& session, Performer& performer, double seconds) {
  using namespace std::chrono_literals;
  StatusLine line;
  Keyboard keyboard;
  Player player{session, performer, line};
  if (keyboard.is_terminal()) line.say(kHelp);
  const auto begin = Clock::now();
  auto drawn = begin - 1s;
  while (true) {
    if (interrupted != 0) return kInterrupted;
    if (session.over()) return kDevice;
    if (seconds > 0 && std::chrono::duration<double>(Clock::now() - begin).count() >= seconds) return kDone;
    if (const auto key = keyboard.wait(20ms); key && !player.press(*key)) return kDone;
    for (const auto& words : session.tick()) line.say(words);
    if (Clock::now() - drawn < 100ms) continue;
    drawn = Clock::now();
    line.draw(session.look(), player.knob());
  }
}

}  // namespace

int play_live(const LiveOptions& options) {
  const auto seconds = seconds_of(options.duration, "duration");
  if (!seconds) return report(seconds.error()), kUsage;
  auto plan = make_plan(options);
  if (!plan) return report(plan.error().errors), plan.error().exit;
  auto& performer = *plan->performer;

  if (const auto locked = lock_memory(); !locked) fmt::print(stderr, "note: {}\n", to_string(locked.error()));
  Session session{performer, *plan->devices.backend, plan->request, options.arm, nullptr};
  if (plan->delay_s) session.know_delay();
  if (const auto started = session.start(); !started) return report(started.error()), kDevice;
  fmt::print(stderr, "{}\n{}\n", performer.name(), granted_in_words(*plan, session.granted()));
  if (!options.listen) fmt::print(stderr, "{}\n", delay_in_words(*plan));
  if (!options.arm && session.has_drives())
    fmt::print(stderr, "the drives are not armed: press a, or start with --arm\n");

  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  const int ended = run(session, performer, *seconds);
  const auto view = session.look();
  const auto stopped = session.stop();
  const auto guard = session.guard_report();
  if (options.json) {
    fmt::print("{}\n", Json{{"instrument", performer.name()},
                            {"device", session.granted().device},
                            {"sample_rate_hz", session.granted().format.sample_rate.value},
                            {"block_frames", session.granted().block_frames},
                            {"highest_input", json_of(view.highest_inputs)},
                            {"highest_output", json_of(view.highest_outputs)},
                            {"health", json_of(view.health)},
                            {"guard", guard_json(guard, session.granted().format.sample_rate)}}
                           .dump(2));
  } else {
    for (const auto& level : view.highest_inputs)
      fmt::print("  {:<18}  {} at most\n", level.name, level_text(level.peak));
    for (const auto& level : view.highest_outputs)
      fmt::print("  {:<18}  {} at most\n", level.name, level_text(level.peak));
    fmt::print("  load                {}\n", load_text(view.health));
    fmt::print("  gaps                {}\n", xrun_text(view.health));
    print_guard(guard, session.granted().format.sample_rate);
  }
  if (!stopped) return report(stopped.error()), kDevice;
  return ended;
}

}  // namespace tactus::app
