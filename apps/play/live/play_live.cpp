#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cctype>
#include <chrono>
#include <filesystem>
#include <future>
#include <new>
#include <optional>
#include <set>
#include <system_error>

#include "apps/cli/console.h"
#include "apps/cli/printer.h"
#include "apps/cli/rig_files.h"
#include "apps/cli/stop_loop.h"
#include "apps/cli/terminal.h"
#include "apps/play/live/controls/drive_keys.h"
#include "apps/play/live/controls/live_presets.h"
#include "apps/play/live/controls/midi_notes.h"
#include "apps/play/live/controls/status_line.h"
#include "apps/play/live/plan.h"
#include "apps/play/live/remote/live_remote.h"
#include "apps/play/live/remote/remote_server.h"
#include "apps/play/live/session.h"
#include "apps/play/midi_map.h"
#include "backends/awake.h"
#include "backends/library_calls.h"
#include "backends/realtime_thread.h"
#include "engine/core/index.h"

namespace tactus::app {
namespace {

using Clock = std::chrono::steady_clock;
using Ending = StopLoop::Ending;

constexpr const char* kLoadHelp = "load: share of a block's time in use, 99.9th percentile (and maximum)";

/// "keys: …" in lines of at most `columns` characters.
std::string keys_text(const std::vector<std::string>& keys, std::size_t columns) {
  std::string text, line = "keys: ";
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const auto key = keys[k] + (k + 1 < keys.size() ? " | " : "");
    if (line.size() + keys[k].size() > columns && k > 0) text += std::exchange(line, "      ") + "\n";
    line += key;
  }
  return text + line;
}

/// NAME-2026-11-26_05-37-08.wav in the current folder; of the name letters and digits are kept.
std::filesystem::path take_of_now(const std::string& name) {
  std::string file;
  for (const char byte : name) file += std::isalnum(static_cast<unsigned char>(byte)) != 0 ? byte : '_';
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return fmt::format("{}-{:%Y-%m-%d_%H-%M-%S}.wav", file, fmt::localtime(now));
}

constexpr const char* kForeignTerminal =
    "note: keys are not read, because this terminal belongs to another session (setsid, su -c); run the "
    "program without setsid or with su --pty, and end this one with the command kill";

constexpr const char* kInputClosed =
    "standard input is closed, so that no key could disarm the drives any more: ended; to play without keys, "
    "add </dev/null";

std::string source_text(const RigMidi& binding) {
  if (binding.kind == RigMidi::Kind::PitchBend) return "the pitch wheel";
  return fmt::format("{} {}", binding.kind == RigMidi::Kind::Note ? "note" : "controller", binding.number);
}

/// What moves controls.
struct Bindings {
  std::vector<RigMidi> midi;
  std::vector<RigOsc> osc;
  std::vector<RigHid> hid;
};

bool same_source(const RigOsc& a, const RigOsc& b) { return a.address == b.address; }
bool same_source(const RigHid& a, const RigHid& b) {
  return a.device == b.device && a.part == b.part && a.number == b.number;
}

std::string save_and_report(const std::string& file, const Rig::Device& device, const Bindings& bindings,
                            const std::vector<Rig::Control>& settings) {
  const auto errors = change_rig(file, device, [&](Rig& rig) {
    rig.midi = bindings.midi;
    rig.osc = bindings.osc;
    rig.hid = bindings.hid;
    rig.controls = settings;
  });
  return errors.empty() ? file + ": controls and what moves them saved; the previous file is " + file + "~"
                        : to_string(errors) + "\nnothing was saved";
}

/// The control loop of a session: MIDI controllers, the status line, the control that the keys have selected,
/// and the keys that the stop loop leaves to it.
class LivePlay {
 public:
  LivePlay(Session& session, LivePlan& plan, StopLoop& stop_loop, Printer& printer,
           const LiveOptions& options, LiveRemote* remote)
      : session_(session),
        remote_(remote),
        controls_(session.controls()),
        plan_(plan),
        stop_loop_(stop_loop),
        printer_(printer),
        options_(options),
        midi_map_(plan.rig ? plan.rig->midi : std::vector<RigMidi>{}),
        osc_(plan.rig ? plan.rig->osc : std::vector<RigOsc>{}),
        hid_(plan.rig ? plan.rig->hid : std::vector<RigHid>{}),
        presets_(preset_folder(plan.performer->files.front())) {
    follow_notes();
    publish_bindings();
    if (!midi_map_.bindings().empty() || !options.midi.empty() || notes_.any()) open_midi();
  }

  /// `duration`: 0: until it is ended. Returns the exit code.
  int run(Seconds duration) {
    using namespace std::chrono_literals;
    if (stop_loop_.reads_terminal()) help();
    const auto begin = Clock::now();
    auto drawn = begin - 1s;
    while (true) {
      if (const auto ending = stop_loop_.ending(); ending != Ending::None) {
        if (ending == Ending::InputClosed) print(kInputClosed);
        return ending == Ending::Quit ? kDone : kInterrupted;
      }
      if (session_.over()) return kDevice;
      const std::chrono::duration<double> played = Clock::now() - begin;
      if (duration.value > 0 && played.count() >= duration.value) return kDone;
      if (const auto key = stop_loop_.wait_key(notes_.any() || remote_ != nullptr ? 2ms : 20ms)) press(*key);
      tick();
      if (Clock::now() - drawn < 100ms) continue;
      drawn = Clock::now();
      draw();
    }
  }
  /// Waits until a rig that is being saved is saved.
  void report_saved() {
    if (saving_.valid()) print(saving_.get());
  }

 private:
  /// What happens without keys: MIDI, edits, device and guard events.
  void tick() {
    if (midi_ != nullptr) follow_midi();
    notes_.flush([this](const JournalEntry& entry) { return player().post(entry); });
    if (saving_.valid() && saving_.wait_for(std::chrono::seconds{0}) != std::future_status::timeout)
      report_saved();
    follow_presets();
    if (remote_ != nullptr) follow_remote();
    if (const auto now = Clock::now(); now - ticked_ >= std::chrono::milliseconds{10}) {
      ticked_ = now;
      session_.tick();
    } else if (session_.plays()) {
      session_.send_controls();
    }
    for (const auto& message : session_.take_messages()) print(message);
  }

  void follow_remote() {
    remote_->tick(notes_.next());
    for (const auto& message : remote_->take_messages()) print(message);
  }

  void follow_presets() {
    if (const auto recalled = presets_.tick()) apply(*recalled);
    for (const auto& message : presets_.take_messages()) print(message);
    if (remote_ == nullptr) return;
    if (std::exchange(presets_seen_, presets_.version()) != presets_.version())
      remote_->set_presets(presets_.names());
    using Kind = RemoteRequest::Kind;
    for (const auto& request : remote_->take_requests()) {
      if (request.kind == Kind::RecallPreset)
        presets_.recall(request.name, Seconds{request.ramp_s}, playing());
      if (request.kind == Kind::SavePreset) presets_.save(request.name, playing());
      if (request.kind == Kind::Learn) learn(request.name);
      if (request.kind == Kind::LearntAddress) bind(osc_, {{}, {}, request.name}, request.name);
      if (request.kind == Kind::LearntHid)
        bind(hid_, request.hid,
             fmt::format("{} {} of {}", name_of(request.hid.part), request.hid.number, request.hid.device));
    }
  }
  void apply(const LivePresets::Recalled& recalled) {
    if (remote_ != nullptr) return remote_->apply(recalled.preset, recalled.ramp);
    for (const auto& [name, value] : recalled.preset.values) (void)controls_.set(name, value);
  }
  /// The controls that can be changed, with the values that they have now.
  std::vector<FlatControl> playing() const {
    std::vector<FlatControl> controls;
    for (const auto& live : controls_.all())
      if (!live.frozen) controls.push_back(live.control);
    return controls;
  }
  void recall(std::size_t number) {
    if (number < presets_.names().size()) return presets_.recall(presets_.names()[number], 0_s, playing());
    print(presets_.names().empty() ? "there are no presets: p saves one"
                                   : fmt::format("there are {} presets", presets_.names().size()));
  }
  void save_preset() {
    if (any()) presets_.save(presets_.free_name(), playing());
  }
  void publish_bindings() {
    if (remote_ == nullptr) return;
    std::map<std::string, std::string> sources;
    for (const auto& binding : midi_map_.bindings()) sources[binding.control] = source_text(binding);
    remote_->set_sources(std::move(sources), osc_, hid_);
  }
  /// To the control that is being learnt.
  template <class Source>
  void bind(std::vector<Source>& sources, Source source, const std::string& name) {
    source.control = midi_map_.control();
    if (source.control.empty()) return;
    midi_map_.learn("");
    print(fmt::format("{} now controls {}; s saves this in the rig", name, source.control));
    std::erase_if(sources, [&](const Source& other) {
      return other.control == source.control || same_source(other, source);
    });
    sources.push_back(std::move(source));
    publish_bindings();
  }

  void follow_midi() {
    for (const auto& message : midi_->news()) print(message);
    const auto events = midi_->poll();
    if (!events.empty()) follow_notes();
    if (const auto frame = player().frame(); frame < std::exchange(last_frame_, frame)) notes_.restart();
    for (const auto& event : events) {
      notes_.play(event.message, first_free_frame());
      if (event.message.kind == MidiMessage::Kind::ProgramChange) recall(index(event.message.number));
      for (const auto& move : midi_map_.handle(event))
        if (!controls_.turn(move.control, move.position) && refused_.insert(move.control).second)
          print(move.control + " cannot be changed during playback");
      if (const auto learnt = midi_map_.take_learnt()) {
        if (remote_ != nullptr) remote_->learn(false);
        publish_bindings();
        print(fmt::format("{} of {} now controls {}; s saves this in the rig", source_text(*learnt),
                          event.port, learnt->control));
      }
    }
  }

  Player& player() { return plan_.performer->instrument(); }

  /// Which controls follow notes may have changed with the file.
  void follow_notes() {
    std::vector<MidiNotes::Follower> followers;
    for (const auto& planned : player().plan().controls)
      if (planned.control.midi != MidiRole::None)
        followers.push_back(
            {planned.control.midi, player().control_index(planned.control.name), planned.control.range});
    notes_.follow(std::move(followers));
  }
  /// Not before the end of the block after the one that may be in work, nor before an entry that is posted.
  std::int64_t first_free_frame() {
    const auto free = player().frame() + 2 * std::int64_t{session_.granted().format.max_frames};
    return remote_ == nullptr ? free : std::max(free, remote_->last_frame());
  }

  void draw() {
    const auto& view = session_.view();  // levels are those since the last view
    const int columns = terminal_columns() - 1;
    if (columns < 0) return;
    auto lines = status_line(view, any() && !listed_ ? controls_.text(selected_) : "", columns);
    if (listed_ && any()) lines += "\n" + control_list(controls_, selected_, columns, terminal_rows() - 2);
    printer_.status(std::move(lines));
  }
  void print(const std::string& message) {
    printer_.print(message);
    if (remote_ != nullptr) remote_->message(message);
  }

  void press(Key pressed) {
    for (const auto& [key, text] :
         {std::pair{kPressEnterKey, "press Enter within three seconds to arm the drives"},
          {kDisarmedKey, "drives disarmed"},
          {kNotArmedKey, "not armed: press nothing for a second, then a, then Enter"},
          {kMutedKey, "muted"},
          {kUnmutedKey, "unmuted"}})
      if (key == pressed) print(text);
    for (const auto& [key, act] : {std::pair{kArmKey, &LivePlay::arm},
                                   {Key{' '}, &LivePlay::strike},
                                   {Key{'c'}, &LivePlay::list},
                                   {Key{'l'}, &LivePlay::learn_selected},
                                   {Key{'p'}, &LivePlay::save_preset},
                                   {Key{'r'}, &LivePlay::record},
                                   {Key{'s'}, &LivePlay::save},
                                   {Key{'?'}, &LivePlay::help},
                                   {Key{'h'}, &LivePlay::help}})
      if (key == pressed) (this->*act)();
    for (std::size_t number = 0; number < 9; ++number)
      if (pressed == Key{static_cast<char>('1' + number)}) recall(number);
    if (pressed == kUpKey || pressed == kDownKey) select(pressed == kUpKey ? -1 : 1);
    if (pressed == kLeftKey || pressed == kRightKey) turn(pressed == kLeftKey ? -0.05 : 0.05);
  }

  bool any() const { return selected_ < controls_.all().size(); }
  const std::string& name() const { return controls_.all()[selected_].control.name; }

  bool open_midi() {
    if (midi_ == nullptr) midi_ = make_midi_inputs(options_.midi, *plan_.devices.backend);
    return midi_ != nullptr;
  }

  void arm() {
    if (!session_.has_drives()) return print("there is no drive to arm");
    if (const auto armed = session_.arm(true); !armed) return print(to_string(armed.error()));
    if (session_.armed()) print("drives armed");
  }
  void strike() {
    if (!plan_.performer->can_strike()) return print("there is nothing to strike here");
    (void)plan_.performer->strike();
  }
  /// Only the keys that do something here.
  void help() {
    const bool controls = any(), changes = changeable();
    std::vector<std::string> keys;
    for (const auto& [works, key] : {std::pair{session_.has_drives(), "a, then Enter: arm"},
                                     {session_.has_drives(), "a: disarm"},
                                     {true, "m: mute"},
                                     {plan_.performer->can_strike(), "space: strike"},
                                     {controls, "c: list the controls"},
                                     {controls, "up, down: select one"},
                                     {changes, "left, right: change it"},
                                     {changes && has_midi(options_.midi), "l: MIDI learn"},
                                     {changes, "p: save a preset"},
                                     {!presets_.names().empty(), "1 to 9: recall a preset"},
                                     {plan_.rig.has_value(), "s: save the rig"},
                                     {!options_.listen, "r: record, or stop"},
                                     {true, "?: keys"},
                                     {true, "q: quit"}})
      if (works) keys.emplace_back(key);
    const int columns = terminal_columns();
    print(keys_text(keys, columns > 0 ? index(columns - 1) : 79) + "\n" + kLoadHelp);
  }
  bool changeable() const {
    for (std::size_t c = 0; c < controls_.all().size(); ++c)
      if (controls_.can_change(c)) return true;
    return false;
  }
  void list() {
    if (!any()) return print("there are no controls");
    listed_ = !listed_;
  }
  void record() {
    if (options_.listen)
      return print("a simulated scene is not recorded; without --listen its signals are written to files");
    if (session_.recording()) return session_.stop_recording();
    const auto file =
        options_.record.empty() ? take_of_now(plan_.performer->name) : std::filesystem::path{options_.record};
    const auto takes = session_.takes().size();
    if (const auto started = session_.start_recording(file); !started)
      return print(to_string(started.error()));
    if (session_.takes().size() > takes)
      print("recording to " + session_.takes().back().string() +
            "; the instrument started again from rest, so that the take can be replayed bit for bit");
    else if (session_.recording())
      print("recording begins when the device is back");
  }
  void select(int step) {
    const auto count = static_cast<int>(controls_.all().size());
    if (count > 0) selected_ = index((static_cast<int>(selected_) + step + count) % count);
  }
  void turn(double share) {
    if (any() && !controls_.nudge(selected_, share)) print(name() + " cannot be changed during playback");
  }
  void learn_selected() {
    if (any()) learn(name());
  }
  /// Without a name: no more.
  void learn(const std::string& control) {
    if (remote_ != nullptr) remote_->learn(false);
    if (control.empty()) return midi_map_.learn(control);
    const auto* live = controls_.find(control);
    if (live == nullptr || live->frozen)
      return print("there is no control '" + control + "' that can be changed");
    const bool others = !options_.osc.empty() || options_.hid;
    if (!open_midi() && !others) return print("this program was built without MIDI");
    midi_map_.learn(control);
    if (remote_ != nullptr) remote_->learn(true);
    print(fmt::format("move the {}controller for {}", others ? "" : "MIDI ", control));
  }
  void save() {
    if (!plan_.rig) return print("there is no rig file: start with --save-rig FILE");
    if (saving_.valid()) return print("the rig is still being saved; press s again later");
    std::vector<Rig::Control> settings;
    for (const auto& live : controls_.all())
      settings.push_back({live.control.name, {}, {live.control.value, live.control.unit, false}});
    saving_ =
        std::async(std::launch::async, [file = plan_.rig_file, device = plan_.rig->device,
                                        bindings = Bindings{midi_map_.bindings(), osc_, hid_}, settings] {
          return save_and_report(file, device, bindings, settings);
        });
  }

  Session& session_;
  LiveRemote* remote_;  ///< or nullptr
  LiveControls& controls_;
  LivePlan& plan_;
  StopLoop& stop_loop_;
  Printer& printer_;
  const LiveOptions& options_;
  MidiMap midi_map_;
  std::vector<RigOsc> osc_;
  std::vector<RigHid> hid_;
  MidiNotes notes_;
  std::int64_t last_frame_ = 0;       ///< of the player, when MIDI was polled
  std::shared_ptr<MidiInputs> midi_;  ///< opened when something is bound or MIDI learn is on
  std::set<std::string> refused_;     ///< controls that MIDI cannot turn, once reported
  std::size_t selected_ = 0;
  LivePresets presets_;
  int presets_seen_ = -1;            ///< the version of their names that clients have
  bool listed_ = false;              ///< all controls are shown
  Clock::time_point ticked_;         ///< the session
  std::future<std::string> saving_;  ///< the rig: what to report of it
};

/// Further lines below the first one, behind a heading of 10 columns.
std::string aligned(std::string lines) {
  for (auto at = lines.find('\n'); at != std::string::npos; at = lines.find('\n', at + 1))
    lines.insert(at + 1, 10, ' ');
  return lines;
}

/// What plays where, and the state of the drives.
std::string announcement(const Session& session, const LivePlan& plan, const LiveOptions& options,
                         bool keys) {
  const auto& granted = session.granted();
  auto text = plan.performer->name + "\n" + granted_text(plan, granted) + "\n";
  text += options.listen ? "the sound is played on the first channels of " + granted.device +
                               ": connect speakers there, not actuators"
                         : delay_text(plan);
  if (const auto& inputs = plan.performer->input_signals; !inputs.empty())
    text += "\ninputs    " + aligned(inputs);
  for (const auto& line : describe_limits(plan.performer->outputs, plan.performer->guards))
    text += "\nlimits    " + line;
  if (!options.arm && session.has_drives())
    text += "\nthe drives are disarmed: press a, then Enter, or start with --arm";
  if (!keys && options.duration.empty())
    text += "\nit plays until a signal (kill, Ctrl-C); --duration \"10 s\" ends it by itself";
  return text;
}

/// The report, as far as somebody reads it.
void report(Session& session, const SessionView& view, const LivePlan& plan, bool as_json) {
  try {
    print_report(session, view, *plan.performer, as_json);
    std::fflush(stdout);
  } catch (const std::system_error&) {
    // The reader of standard output is gone, and with it whom it would be reported to.
  }
}

/// A rig with MIDI messages sends them, and one with joysticks reads them, without an option.
RemoteOptions remote_options(const LiveOptions& options, const LivePlan& plan) {
  RemoteOptions remote = options;
  if (plan.rig) remote.midi_messages = plan.rig->midi_out;
  if (!remote.midi_messages.empty() && !remote.midi_out) {
    remote.midi_out = "";
    remote.midi_by_rig = true;
  }
  if (plan.rig && !plan.rig->hid.empty() && !remote.hid) remote.hid = "";
  return remote;
}

/// Plays on an open session to its end. The exit code.
int play(Session& session, LivePlan& plan, StopLoop& stop_loop, const LiveOptions& options,
         RemoteServer* remote, Seconds duration) {
  const bool terminal = stop_loop.reads_terminal() && terminal_columns() > 0;
  Printer printer{terminal ? kMarkPastedText : "", terminal ? kDoNotMarkPastedText : ""};
  or_exit(session.start(), kDevice);
  printer.print(announcement(session, plan, options, stop_loop.reads_terminal()));
  if (stop_loop.in_foreign_terminal()) printer.print(kForeignTerminal);
  if (remote != nullptr)
    for (const auto& line : remote->announcements()) printer.print(line);
  LivePlay live{session, plan, stop_loop, printer, options, remote == nullptr ? nullptr : &remote->target()};
  const int ended = live.run(duration);
  const auto& view = session.view();
  const auto stopped = session.stop();
  live.report_saved();
  for (const auto& message : session.take_messages()) printer.print(message);
  if (remote != nullptr)
    for (const auto& line : remote->summaries()) printer.print(line);
  printer.finish();
  report(session, view, plan, options.json);
  or_exit(stopped, kDevice);
  return ended;
}

int play(const LiveOptions& options) {
  const auto duration = options.duration.empty() ? 0_s : parse_duration(options.duration);
  auto plan = make_plan(options);
  if (const auto locked = lock_memory(); !locked) print_note("note: " + to_string(locked.error()));
  const auto awake = options.awake ? std::optional{Awake::begin()} : std::nullopt;
  if (awake && !*awake) print_note("note: " + to_string(awake->error()));
  DeadMansSwitch dead_man;
  Session session{*plan.performer, *plan.devices.backend, plan.request, options.arm, &dead_man};
  session.share_ports(options.shared_port);
  const auto remote =
      make_remote_server(remote_options(options, plan), session, *plan.performer, *plan.request.sample_rate);
  if (remote != nullptr) remote->target().set_latency(plan.delay, !plan.delay_assumed);
  DriveKeys keys{session.switches()};
  StopLoop stop_loop{dead_man,
                     {.act = [&](Key key, Clock::time_point now) { return keys.act(key, now); },
                      .each_turn =
                          [&](Clock::time_point now) {
                            keys.begin_turn(now);
                            if (remote != nullptr) remote->target().watch(now);
                          },
                      .needs_input = [&] { return session.armed(); },
                      .inputs = {},
                      .control_stalled = [&] { session.control_stalled(); },
                      .fade = session.closing_time()}};
  if (const auto opened = session.open(options.record); !opened)
    exit_with(opened.error(), exit_of(opened.error()));
  check_delay(plan, session.granted());
  session.set_delay(plan.delay ? std::optional{plan.delay_settings} : std::nullopt);
  on_slow_call({});  // a note of a library must not hold up what is printed
  return play(session, plan, stop_loop, options, remote.get(), duration);
}

}  // namespace

/// Whatever throws, the session fades out with its end.
int play_live(const LiveOptions& options) {
  accept_stop_signals();
  try {
    return play(options);
  } catch (const std::bad_alloc&) {
    exit_with(out_of_memory(options.target), kNo);
  }
}

}  // namespace tactus::app
