// The program itself, on a simulated card: however it is stopped, its drive fades out.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "tests/support/child_process.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/terminal_process.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using test::wait_until;

namespace {

using Arguments = std::vector<std::string>;

/// An instrument that gives out 0.2, and a take of it.
struct Stage {
  Arguments command(const Arguments& more = {}) const {
    Arguments all = {TACTUS_PROGRAM, "play", tone, "--backend", "loop", "--arm", "--record", wav.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// It is recorded for longer than the soft start takes.
  bool sounds() const {
    return wait_until([&] {
      std::error_code missing;
      const auto bytes = std::filesystem::file_size(wav, missing);
      return !missing && bytes > 48'000 * sizeof(float);
    });
  }
  /// How many frames of the take are on the disk.
  std::int64_t frames() const {
    const auto take = read_take(wav);
    return take ? take->complete : 0;
  }
  /// The frame that is being played, as the take reports it every 200 ms.
  std::int64_t frame_now() const {
    const auto before = frames();
    REQUIRE(wait_until([&] { return frames() > before; }));
    return frames();
  }
  bool finished() const {
    return wait_until([&] { return read_take(wav)->finished; });
  }
  /// The first frame of the fade.
  std::int64_t fade() const {
    const auto take = read_take(wav);
    REQUIRE(take);
    const auto fade = std::find_if(take->guard.begin(), take->guard.end(), [](const JournalEntry& entry) {
      return entry.kind == JournalEntry::Kind::Fade;
    });
    REQUIRE(fade != take->guard.end());
    return fade->frame;
  }
  /// The take was ended, and before that the drive came to zero within the fade of 10 ms.
  void check_fade() const {
    CHECK(read_take(wav)->finished);
    const auto samples = read_wav(wav);
    REQUIRE(samples);
    const auto& drive = samples->channels.front();
    const auto faded = drive.begin() + fade();
    CHECK(*(faded - 1) == Approx(0.2));
    REQUIRE(drive.end() - faded >= 480);
    CHECK(std::all_of(faded + 480, drive.end(), [](double sample) { return sample == 0.0; }));
  }
  /// The shell's terminal is closed while the program in it sounds.
  void check_closed_terminal(const Arguments& shell_command) const {
    test::TerminalProcess shell{shell_command};
    REQUIRE(sounds());
    shell.close();
    REQUIRE(finished());
    check_fade();
  }

  test::TemporaryFolder folder;
  std::filesystem::path wav = folder.path() / "take.wav";
  std::string tone =
      folder.write("tone.toml", "format = 1\nname = \"tone\"\n[outputs]\ntone = { from = \"0.2\" }\n")
          .string();
};

/// A pipe that is full, and whose reader reads nothing or is gone.
class Pipe {
 public:
  Pipe() {
    REQUIRE(::pipe2(ends_, O_CLOEXEC) == 0);
    ::fcntl(ends_[1], F_SETFL, O_NONBLOCK);
    const std::string bytes(4096, 'x');
    while (::write(ends_[1], bytes.data(), bytes.size()) > 0) continue;
    ::fcntl(ends_[1], F_SETFL, 0);
  }
  ~Pipe() {
    close_reader();
    ::close(ends_[1]);
  }
  void close_reader() {
    if (ends_[0] >= 0) ::close(ends_[0]);
    ends_[0] = -1;
  }
  int writer() const { return ends_[1]; }

 private:
  int ends_[2] = {-1, -1};
};

/// `script` runs the command "$0" "$@".
Arguments in_shell(const std::string& script, const Arguments& command) {
  Arguments all = {"sh", "-c", script};
  all.insert(all.end(), command.begin(), command.end());
  return all;
}

/// In the background of its terminal, until a line is typed.
Arguments in_background(const Arguments& command) {
  return in_shell("set -m; \"$0\" \"$@\" & read line; fg", command);
}

#ifdef __linux__
/// An edit of the stage's file that cannot be read until it is released: a file lease blocks whoever opens
/// it.
class HeldEdit {
 public:
  explicit HeldEdit(const Stage& stage) {
    const auto next = stage.folder.write(
        "next.toml", "format = 1\nname = \"edited\"\n[outputs]\ntone = { from = \"0.25\" }\n");
    file_ = ::open(next.c_str(), O_RDWR | O_CLOEXEC);
    before_ = std::signal(SIGIO, SIG_IGN);  // it comes when somebody opens the file
    if (::fcntl(file_, F_SETLEASE, F_WRLCK) != 0) {
      end();
      test::skip("this file system gives no leases");
    }
    std::filesystem::rename(next, stage.tone);
  }
  ~HeldEdit() { end(); }
  HeldEdit(const HeldEdit&) = delete;
  HeldEdit& operator=(const HeldEdit&) = delete;
  /// Somebody is held up.
  bool awaited() const { return ::fcntl(file_, F_GETLEASE) != F_WRLCK; }
  void release() const { ::fcntl(file_, F_SETLEASE, F_UNLCK); }

 private:
  void end() {
    ::close(file_);
    std::signal(SIGIO, before_);
  }

  int file_ = -1;
  void (*before_)(int) = SIG_DFL;
};
#endif

constexpr auto kLogged = test::ChildProcess::Stdout::Logged;
constexpr std::chrono::seconds kPatience{60};

/// What ends a program: a signal by its name, the key q, or Ctrl-C typed.
template <class Program>
void stop(const Program& program, const std::string& by) {
  if (by == "key") return void(program.type("q"));
  if (by == "Ctrl-C") return void(program.type("\x03"));
  program.send(by == "SIGINT" ? SIGINT : by == "SIGTERM" ? SIGTERM : SIGHUP);
}
int exit_code(const std::string& by) { return by == "key" ? 0 : 5; }

}  // namespace

TEST_CASE("play: a terminal that is closed fades the drive, and the take ends", "[live]") {
  const Stage stage;
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.close();
  CHECK(play.wait() == 5);
  stage.check_fade();
}

TEST_CASE("play: a terminal that is closed fades the drive of a program in its background", "[live]") {
  const Stage stage;
  stage.check_closed_terminal(in_background(stage.command({"--duration", "100 s"})));
}

TEST_CASE("play: a terminal that is closed fades the drive of a program that does not read it", "[live]") {
  const Stage stage;
  const std::string how = GENERATE(as<std::string>{}, "set -m; \"$0\" \"$@\" </dev/null & read line; fg",
                                   "setsid -w \"$0\" \"$@\" </dev/null");
  stage.check_closed_terminal(in_shell(how, stage.command({"--duration", "100 s"})));
}

TEST_CASE("play: a terminal that was closed before the start ends it", "[live]") {
  const Stage stage;
  test::TerminalProcess shell{
      in_shell("trap '' HUP; echo waits; while test -t 0; do :; done; exec \"$0\" \"$@\"", stage.command())};
  REQUIRE(shell.shows("waits"));
  shell.close();
  CHECK(shell.wait().value_or(-1) == 5);
}

TEST_CASE("play: signals that its parent had blocked end it", "[live]") {
  const Stage stage;
  test::ChildProcess play{in_shell("exec env --block-signal=TERM \"$0\" \"$@\"", stage.command()), kLogged};
  REQUIRE(stage.sounds());
  play.send(SIGTERM);
  CHECK(play.wait(kPatience) == 5);
  stage.check_fade();
}

TEST_CASE("play: keys work as soon as it is brought to the foreground", "[live]") {
  const Stage stage;
  test::TerminalProcess shell{in_background(stage.command({"--duration", "100 s"}))};
  REQUIRE(stage.sounds());
  shell.type("\n");  // fg
  shell.type("m");
  CHECK(shell.shows("muted"));
  shell.type("q");
  CHECK(shell.wait() == 0);
}

TEST_CASE("play: a connection at standard input that is closed fades an armed drive", "[live]") {
  const Stage stage;
  const std::string of = GENERATE(as<std::string>{}, "socket", "pipe");
  CAPTURE(of);
  auto command = stage.command();
  if (of == "pipe") command = in_shell("{ read line; } | exec \"$0\" \"$@\"", command);
  test::ChildProcess play{command, kLogged};
  REQUIRE(stage.sounds());
  play.hang_up();
  CHECK(play.wait(kPatience) == 5);
  stage.check_fade();
}

TEST_CASE("play: with a connection at standard input that is closed from the start, no drive stays armed",
          "[live]") {
  const Stage stage;
  test::ChildProcess play{in_shell("read line; exec \"$0\" \"$@\"", stage.command()), kLogged};
  play.hang_up();
  CHECK(play.wait(kPatience) == 5);
  CHECK(play.log().find("standard input is closed") != std::string::npos);
}

TEST_CASE("play: with /dev/null at standard input an armed drive plays until a signal", "[live]") {
  const Stage stage;
  test::ChildProcess play{in_shell("exec \"$0\" \"$@\" </dev/null", stage.command()), kLogged};
  REQUIRE(stage.sounds());
  play.send(SIGTERM);
  CHECK(play.wait(kPatience) == 5);
  stage.check_fade();
}

TEST_CASE("play: a limit on the size of files ends the take, and nothing else", "[live]") {
  const Stage stage;
  test::ChildProcess play{in_shell("ulimit -f 400; exec \"$0\" \"$@\"", stage.command()), kLogged};
  REQUIRE(wait_until([&] { return play.log().find("recording stopped") != std::string::npos; }));
  play.type("m");
  CHECK(wait_until([&] { return play.log().find("muted") != std::string::npos; }));
  play.type("q");
  CHECK(play.wait(kPatience) == 0);
}

TEST_CASE("play: Ctrl-S stops nothing, and keys, SIGINT, SIGTERM and SIGHUP do as before", "[live]") {
  const Stage stage;
  const auto signal = GENERATE(SIGINT, SIGTERM, SIGHUP);
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.type("\x13m");
  CHECK(play.shows("muted"));
  play.type("m");
  CHECK(play.shows("unmuted"));
  play.type("a");
  CHECK(play.shows("drives disarmed"));
  play.send(signal);
  CHECK(play.wait() == 5);
  CHECK(read_take(stage.wav)->finished);
}

TEST_CASE("play: a signal or a key right after Ctrl-S fades the armed drive", "[live]") {
  const Stage stage;
  const std::string by = GENERATE(as<std::string>{}, "SIGINT", "SIGTERM", "SIGHUP", "key");
  CAPTURE(by);
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.type("\x13");
  stop(play, by);
  CHECK(play.wait() == exit_code(by));
  stage.check_fade();
}

TEST_CASE("play: a terminal whose output is stalled holds up neither the fade nor the end of the take",
          "[live]") {
  const Stage stage;
  const std::string by = GENERATE(as<std::string>{}, "SIGINT", "SIGTERM", "SIGHUP", "key", "Ctrl-C");
  CAPTURE(by);
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.stall();
  play.type("??");
  stop(play, by);
  REQUIRE(stage.finished());
  stage.check_fade();
  play.resume();
  CHECK(play.wait() == exit_code(by));
}

TEST_CASE("play: a, then Enter, arms, and a held key, a paste and a stray escape sequence do not", "[live]") {
  const Stage stage;
  test::TerminalProcess play{{TACTUS_PROGRAM, "play", stage.tone, "--backend", "loop"}};
  REQUIRE(play.shows("the drives are disarmed"));
  play.type("\x1bOa\x1b[200~a\ra\r\x1b[201~xa\r");
  REQUIRE(play.shows("not armed: "));
  play.type("aaaaaaaaaa\r?");
  REQUIRE(play.shows("keys: "));
  const auto armed = [&] { return play.output().find("drives armed") != std::string::npos; };
  CHECK_FALSE(armed());
  while (!armed()) {  // a busy machine may take too long between both keys
    std::this_thread::sleep_for(std::chrono::milliseconds{1100});  // the times are part of what is pressed
    play.type("a");
    REQUIRE(play.shows("press Enter"));
    std::this_thread::sleep_for(std::chrono::milliseconds{150});
    play.type("\r?");
    REQUIRE(play.shows("keys: "));
  }
  play.type(
      "\x1b"
      "a");
  CHECK(play.shows("drives disarmed"));
  play.type("q");
  CHECK(play.wait() == 0);
  CHECK(play.output().find("\x1b[?2004l") != std::string::npos);
}

TEST_CASE("play: r ends a take and begins another, and both replay bit for bit", "[live]") {
  Stage stage;
  stage.folder.write("tone.toml", R"(format = 1
name = "swinging tone"
[controls]
level = { value = 0.5, range = [0, 1], smooth = "30 ms" }
[nodes]
wave = { type = "sine", frequency = "97 Hz", level = "0.1 * level" }
swing = { type = "noise", level = 0.01 }
[outputs]
tone = { from = "wave + swing" }
)");
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.type("\x1b[C");
  play.type("r");
  REQUIRE(play.shows("recorded "));
  play.type("r");
  REQUIRE(play.shows("take-2.wav; the instrument started again from rest"));
  stage.wav = stage.folder.path() / "take-2.wav";
  REQUIRE(stage.sounds());
  play.type("\x1b[C");
  REQUIRE(play.shows("level = 0.6"));
  play.type("q");
  CHECK(play.wait() == 0);
  for (const auto* name : {"take.wav", "take-2.wav"}) {
    test::ChildProcess replay{{TACTUS_PROGRAM, "render", "--replay", (stage.folder.path() / name).string()},
                              kLogged};
    CHECK(replay.wait(kPatience) == 0);
  }
}

TEST_CASE("play: without --record, r names the take by the instrument and the time, in the current folder",
          "[live]") {
  const Stage stage;
  test::TerminalProcess play{{"sh", "-c", "cd \"$1\"; exec \"$0\" play tone.toml --backend loop",
                              TACTUS_PROGRAM, stage.folder.path().string()}};
  REQUIRE(play.shows("r: record, or stop"));
  play.type("r");
  REQUIRE(play.shows("recording to tone-20"));
  play.type("q");
  CHECK(play.wait() == 0);
  int takes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(stage.folder.path()))
    if (entry.path().extension() == ".wav") {
      ++takes;
      CHECK(read_take(entry.path())->finished);
    }
  CHECK(takes == 1);
}

TEST_CASE("play: only keys that do something are listed, in lines that fit the terminal", "[live]") {
  const Stage stage;  // no controls, no rig, nothing to strike
  test::TerminalProcess play{stage.command()};
  REQUIRE(play.shows("q: quit"));
  const auto output = play.output();
  for (const auto* other : {"strike", "controls", "MIDI", "save"})
    CHECK(output.find(other) == std::string::npos);
  for (const auto* key : {"a, then Enter: arm", "m: mute", "r: record", "?: keys"})
    CHECK(output.find(key) != std::string::npos);
  play.type("q");
  CHECK(play.wait() == 0);
}

TEST_CASE("play: Ctrl-C stops it too where the terminal makes no signal of it", "[live]") {
  const Stage stage;
  test::TerminalProcess play{in_shell("stty raw; exec \"$0\" \"$@\"", stage.command())};
  REQUIRE(stage.sounds());
  play.type("\x03");
  CHECK(play.wait() == 5);
  stage.check_fade();
}

TEST_CASE("play: keys act after another program has changed the mode of the terminal", "[live]") {
  const bool disarms = GENERATE(true, false);
  const Stage stage;
  test::TerminalProcess play{stage.command()};
  REQUIRE(stage.sounds());
  play.make_cooked();
  if (disarms) {
    play.type("a");
    CHECK(play.shows("drives disarmed"));
    play.make_cooked();
  }
  play.type("q");
  CHECK(play.wait() == 0);
  if (!disarms) stage.check_fade();
}

TEST_CASE("play: in the terminal of another session it says that it reads no keys, and ends with it",
          "[live]") {
  const Stage stage;
  test::TerminalProcess shell{in_shell("setsid -w \"$0\" \"$@\"", stage.command({"--duration", "100 s"}))};
  REQUIRE(shell.shows("keys are not read"));
  REQUIRE(stage.sounds());
  shell.close();
  REQUIRE(stage.finished());
  stage.check_fade();
}

TEST_CASE("play: standard error that takes nothing holds up neither the fade nor the end", "[live]") {
  const Stage stage;
  const std::string by = GENERATE(as<std::string>{}, "SIGINT", "SIGTERM", "key");
  CAPTURE(by);
  const Pipe full;
  test::ChildProcess play{stage.command(), kLogged, full.writer()};
  REQUIRE(stage.sounds());
  play.type("??");
  stop(play, by);
  CHECK(play.wait(kPatience) == exit_code(by));
  stage.check_fade();
}

#ifdef __linux__
TEST_CASE("play: an edit that cannot be read holds up neither the fade nor the end of the take", "[live]") {
  const Stage stage;
  const std::string by = GENERATE(as<std::string>{}, "SIGINT", "SIGTERM", "key");
  CAPTURE(by);
  test::ChildProcess play{stage.command(), kLogged};
  REQUIRE(stage.sounds());
  const HeldEdit edit{stage};
  REQUIRE(wait_until([&] { return edit.awaited(); }));
  stop(play, by);
  REQUIRE(stage.finished());
  stage.check_fade();
  CHECK(play.running());  // it waits for the edit alone
  edit.release();
  CHECK(play.wait(kPatience) == exit_code(by));
}

TEST_CASE("play: further signals end a program that waits for an edit, once its drive has faded", "[live]") {
  const Stage stage;
  test::ChildProcess play{stage.command(), kLogged};
  REQUIRE(stage.sounds());
  const HeldEdit edit{stage};
  REQUIRE(wait_until([&] { return edit.awaited(); }));
  play.send(SIGINT);
  REQUIRE(stage.finished());
  CHECK(wait_until([&] { return play.send(SIGINT), !play.running(); }));
  stage.check_fade();
}
#endif

TEST_CASE("play: a stop starts the fade within 50 ms", "[live]") {
  const std::string by = GENERATE(as<std::string>{}, "SIGTERM", "key");
  const std::string during = GENERATE(as<std::string>{}, "nothing", "a full pipe", "an edit");
  CAPTURE(by, during);
  std::int64_t shortest = 48'000;  // [frames] of several attempts: no busy machine delays each of them
  for (int attempt = 0; attempt < 8 && shortest > 2400; ++attempt) {
    const Stage stage;
    const Pipe full;
    test::ChildProcess play{stage.command(), kLogged, during == "a full pipe" ? full.writer() : -1};
    REQUIRE(stage.sounds());
    play.type("??");
#ifdef __linux__
    std::optional<HeldEdit> edit;
    if (during == "an edit") edit.emplace(stage);
    REQUIRE((!edit || wait_until([&] { return edit->awaited(); })));
#endif
    const auto now = stage.frame_now();
    stop(play, by);
    REQUIRE(stage.finished());
    shortest = std::min(shortest, stage.fade() - now);
  }
  CHECK(shortest <= 2400);
}

TEST_CASE("play: a reader of standard error that is gone does not end it", "[live]") {
  const Stage stage;
  Pipe closed;
  closed.close_reader();
  test::ChildProcess play{stage.command(), kLogged, closed.writer()};
  REQUIRE(stage.sounds());
  play.type("??");
  const auto frames = std::filesystem::file_size(stage.wav);
  REQUIRE(wait_until([&] { return std::filesystem::file_size(stage.wav) > frames + 48'000; }));
  play.type("q");
  CHECK(play.wait(kPatience) == 0);
  stage.check_fade();
}

TEST_CASE("play: a second signal ends a program that hangs, once its drive has faded", "[live]") {
  if (test::kSignalsAreKeptBack) test::skip("ThreadSanitizer keeps signals back");
  const Stage stage;
  const Pipe full;  // nobody reads the report
  const auto log = (stage.folder.path() / "log").string();
  test::ChildProcess play{in_shell("exec \"$0\" \"$@\" >&2 2>" + log, stage.command()), kLogged,
                          full.writer()};
  REQUIRE(stage.sounds());
  play.send(SIGINT);
  REQUIRE(stage.finished());
  CHECK(play.running());
  play.send(SIGINT);
  CHECK(play.wait(kPatience) == 5);
  stage.check_fade();
}

TEST_CASE("play: a stop waits for the slew limit", "[live]") {
  const Stage stage;
  const auto profile = stage.folder.write("slow.toml", R"(format = 1
name   = "slow"
source = "a test"
[drive]
resistance = "8 ohm"
peak       = "10 V"
slew       = "30 V/s"
soft_start = "10 ms"
fade_out   = "10 ms"
)");
  test::ChildProcess play{stage.command({"--profile", profile.string(), "--volts-per-full-scale", "10"}),
                          kLogged};
  REQUIRE(stage.sounds());
  play.type("q");
  CHECK(play.wait(kPatience) == 0);
  const auto samples = read_wav(stage.wav);
  REQUIRE(samples);
  const auto& drive = samples->channels.front();
  CHECK(drive.back() == 0.0);
  CHECK(*std::max_element(drive.begin(), drive.end()) == Approx(0.2));
  for (std::size_t n = 1; n < drive.size(); ++n)
    if (std::abs(drive[n] - drive[n - 1]) > 3.0 / 48'000 + 1e-7) FAIL("a step at frame " << n);
}
