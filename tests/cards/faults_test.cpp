#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "backends/library_calls.h"
#include "tests/cards/watched_stream.h"
#include "tests/cards/ways.h"
#include "tests/support/child_process.h"
#include "tests/support/skip.h"
#include "tests/support/wait_until.h"

// What a server can do to RtAudio and PortAudio, over JACK and ALSA, three times each. The hidden ones tagged
// [.thousand] do it a thousand times and print how long it took.

using namespace tactus;
using std::chrono::seconds;
using test::CardOnServer;
using test::every_way;
using test::GuardedProbe;
using test::start_card;
using test::wait_until;
using test::Way;

namespace {

constexpr int kPeriod = 256, kKept = 9600;
constexpr std::chrono::milliseconds kLongest = seconds{30};

struct Player : test::WatchedStream {
  Player(const Way& way, const StreamRequest& request)
      : WatchedStream(way.backend(), request, kKept, kLongest) {}
};

/// How long it took from when the server was there, for those who want to know.
class Stopwatch {
 public:
  explicit Stopwatch(std::string what) : what_(std::move(what)) {}
  ~Stopwatch() {
    std::sort(times_.begin(), times_.end());
    if (times_.size() > 3)
      std::printf("%s: %zu times; came back after %.2f s (p50), %.2f s (worst)\n", what_.c_str(),
                  times_.size(), times_[times_.size() / 2], times_.back());
  }
  void begin() { since_ = std::chrono::steady_clock::now(); }
  void end() {
    times_.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - since_).count());
  }

 private:
  std::string what_;
  std::chrono::steady_clock::time_point since_;
  std::vector<double> times_;
};

std::vector<Way> ways_of(const std::string& library) {
  auto ways = every_way();
  std::erase_if(ways, [&](const Way& way) { return !way.name.starts_with(library); });
  return ways;
}

template <class Fault>
void each_way(const std::vector<Way>& ways, const char* what, int turns, Fault fault) {
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto rig = start_card();
    Player player{way, rig->request(way, 1, 1)};
    Stopwatch watch{way.name + ", " + what};
    for (int turn = 1; turn <= turns; ++turn) {
      CAPTURE(turn);
      fault(way, *rig, player, turn, watch);
    }
    CHECK(player.stream->stop());
  }
}

void kill_server(int turns) {
  each_way(ways_of("rtaudio"), "kill -9", turns,
           [](const Way&, CardOnServer& rig, Player& player, int turn, Stopwatch& watch) {
             rig.server->kill();
             REQUIRE(player.until(StreamState::Lost));
             rig.restart();
             watch.begin();
             REQUIRE(player.comes_back(turn));
             watch.end();
             REQUIRE(player.until([&] { return player.probe.probe.full(); }));
             CHECK(player.probe.probe.prepared == turn + 1);
           });
}

void stall_server(int turns) {
  each_way(every_way(), "SIGSTOP", turns,
           [](const Way&, CardOnServer& rig, Player& player, int, Stopwatch& watch) {
             rig.server->stop_answering();
             REQUIRE(player.until(StreamState::Stalled));
             rig.server->go_on();
             watch.begin();
             REQUIRE(player.plays_on());
             watch.end();
             CHECK(player.stream->returns() == 0);
           });
}

/// RtAudio over JACK cannot go on and is opened again; the others do.
void change_block(int turns) {
  each_way(every_way(), "new block", turns,
           [](const Way& way, CardOnServer& rig, Player& player, int turn, Stopwatch& watch) {
             const bool ends = way.name == "rtaudio:jack";
             rig.server->set_period(turn % 2 == 1 ? 2 * kPeriod : kPeriod);
             watch.begin();
             if (ends) REQUIRE(player.until([&] { return player.stream->returns() == turn; }));
             REQUIRE(player.plays_on());
             watch.end();
             CHECK(player.stream->returns() == (ends ? turn : 0));
             if (ends) CHECK(player.stream->granted().block_frames == (turn % 2 == 1 ? 512 : 256));
           });
}

void pull_ports(int turns) {
  each_way(every_way(), "ports", turns, [](const Way& way, CardOnServer& rig, Player&, int, Stopwatch&) {
    GuardedProbe probe{1, 48000};
    const auto stream = way.backend()->open(rig.request(way, 1, 1), probe.guarded);
    REQUIRE(stream);
    REQUIRE((*stream)->start());
    REQUIRE(wait_until([&] { return probe.probe.frames() > 4800; }));
    rig.server->disconnect(rig.card->name());
    const auto at = probe.probe.frames() + 4 * kPeriod;  // what was on its way
    REQUIRE(wait_until([&] { return probe.probe.frames() > at + 4800; }));
    CHECK((*stream)->state() == StreamState::Running);
    CHECK((*stream)->stop());
    const auto& heard = probe.probe.heard(0);
    CHECK(heard[4000] != 0.0);
    CHECK(std::count(heard.begin() + at, heard.begin() + at + 4800, 0.0) == 4800);
  });
}

/// What a program does whose user has had enough of a server that does not answer.
void close_during_stall(Backend& backend, const Way& way, CardOnServer& rig) {
  GuardedProbe probe{1, kKept};
  auto stream = backend.open(rig.request(way, 1, 1), probe.guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  REQUIRE(wait_until([&] { return probe.probe.frames() > 0; }));
  rig.server->stop_answering();
  REQUIRE_FALSE((*stream)->stop());
  stream->reset();
}

/// PortAudio may not be called any more in a process where it lost its JACK server. A server that is killed
/// while it writes its metadata lets every JACK program die of SIGBUS: then it is tried once more.
void in_own_process(const std::string& test_case) {
  for (int attempt = 1;; ++attempt) {
    test::ChildProcess child{{TACTUS_CARD_TESTS, test_case}, test::ChildProcess::Stdout::Logged};
    const int ended = child.wait(seconds{60}).value_or(-SIGALRM);
    const auto log = child.log();
    CAPTURE(test_case, log);
    if (ended == test::kSkipExitCode) test::skip(log.substr(log.find("SKIPPED")));
    if (ended == -SIGBUS && attempt == 1) continue;
    CHECK(ended == 0);
    return;
  }
}

}  // namespace

TEST_CASE("libraries: RtAudio comes back when a server that was killed does", "[cards][slow]") {
  kill_server(3);
}
TEST_CASE("libraries: a server that does not answer for a while is waited for", "[cards][slow]") {
  stall_server(3);
}
TEST_CASE("libraries: a server may change its block", "[cards]") { change_block(3); }
TEST_CASE("libraries: ports that are pulled are silent", "[cards]") { pull_ports(3); }

/// As many as scripts/soak_faults asks for.
static int thousand() {
  const char* times = std::getenv("TACTUS_FAULTS");
  return times == nullptr ? 1000 : std::atoi(times);
}

TEST_CASE("libraries: survive a thousand servers that are killed", "[.thousand]") { kill_server(thousand()); }
TEST_CASE("libraries: survive a thousand stalls", "[.thousand]") { stall_server(thousand()); }
TEST_CASE("libraries: survive a thousand changes of the block", "[.thousand]") { change_block(thousand()); }
TEST_CASE("libraries: survive a thousand times pulled ports", "[.thousand]") { pull_ports(thousand()); }

TEST_CASE("libraries: closing is over soon though the server does not answer, and RtAudio opens again after",
          "[cards][slow]") {
  listing_patience() = seconds{5};  // it ends in vain while the server does not answer
  for (const auto& way : ways_of("rtaudio")) {
    CAPTURE(way.name);
    const auto rig = start_card();
    const auto backend = way.backend();
    close_during_stall(*backend, way, *rig);
    GuardedProbe probe{1};
    const auto refused = backend->open(rig->request(way, 1, 1), probe.guarded);
    CHECK_FALSE(refused);
    rig->server->go_on();
    std::string refusal;
    const bool opens = wait_until(
        [&] {
          const auto opened = backend->open(rig->request(way, 1, 1), probe.guarded);
          if (!opened) refusal = to_string(opened.error());
          return opened.has_value();
        },
        kLongest);
    CAPTURE(refusal);
    REQUIRE(opens);
  }
}

TEST_CASE("libraries: PortAudio says that it cannot come back when its server was killed", "[cards]") {
  for (int turn = 0; turn < 3; ++turn)
    for (const auto* test : {"portaudio:jack loses its server", "portaudio:alsa loses its server",
                             "portaudio loses a server while no stream runs"})
      in_own_process(test);
}

TEST_CASE("libraries: PortAudio is closed soon though its server does not answer, and says that it is over",
          "[cards]") {
  in_own_process("portaudio is closed while its server does not answer");
}

namespace {

Way way_called(const std::string& name) {
  for (const auto& way : every_way())
    if (way.name == name) return way;
  test::skip("no " + name + " on this machine");
}

/// From here on every call answers at once, in words.
void is_over(const Way& way, const CardOnServer& rig, const std::string& why) {
  GuardedProbe probe{1};
  const auto devices = way.backend()->devices();
  REQUIRE_FALSE(devices);
  CHECK(to_string(devices.error()).find(why) != std::string::npos);
  const auto stream = way.backend()->open(rig.request(way, 1, 1), probe.guarded);
  REQUIRE_FALSE(stream);
  CHECK(to_string(stream.error()) == to_string(devices.error()));
}

void loses_server(const char* name) {
  const auto way = way_called(name);
  const auto rig = start_card();
  {
    Player player{way, rig->request(way, 1, 1)};
    CHECK_FALSE(player.stream->granted().comes_back);
    rig->server->kill();
    REQUIRE(player.until(StreamState::Lost));
    const auto frames = player.probe.probe.frames();
    rig->restart();
    player.stream->tick();
    CHECK(player.stream->state() == StreamState::Lost);
    CHECK(player.stream->stop());
    CHECK(player.probe.probe.frames() == frames);
  }
  is_over(way, *rig, "PortAudio's JACK client cannot reconnect");
}

}  // namespace

TEST_CASE("portaudio:jack loses its server", "[.own_process]") { loses_server("portaudio:jack"); }
TEST_CASE("portaudio:alsa loses its server", "[.own_process]") { loses_server("portaudio:alsa"); }

TEST_CASE("portaudio loses a server while no stream runs", "[.own_process]") {
  const auto way = way_called("portaudio:jack");
  const auto rig = start_card();
  GuardedProbe probe{1};
  auto stream = way.backend()->open(rig->request(way, 1, 1), probe.guarded);
  REQUIRE(stream);
  rig->server->kill();
  REQUIRE_FALSE((*stream)->start());
  stream->reset();
  is_over(way, *rig, "PortAudio's JACK client cannot reconnect");
}

TEST_CASE("portaudio is closed while its server does not answer", "[.own_process]") {
  const auto way = way_called("portaudio:jack");
  const auto rig = start_card();
  close_during_stall(*way.backend(), way, *rig);
  is_over(way, *rig, "PortAudio does not respond any more");
  rig->server->go_on();
}
