#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <iostream>
#include <map>

#include "backends/reconnecting_stream.h"
#include "tests/cards/ways.h"
#include "tests/support/noise_probe.h"
#include "tests/support/skip.h"
#include "tests/support/sound_server.h"
#include "tests/support/undisturbed.h"
#include "tests/support/wait_until.h"

// JACK when things go wrong, on purpose, at a real server.

using namespace tactus;
using namespace std::chrono_literals;
using test::DelayClient;
using test::GuardedProbe;
using test::SoundServer;
using test::start_sound_server;
using test::wait_until;

namespace {

using Clock = std::chrono::steady_clock;
constexpr int kDelay = 960, kPeriod = 256;

double seconds_since(Clock::time_point then) {
  return std::chrono::duration<double>(Clock::now() - then).count();
}

/// That this process used until now [s].
double cpu_seconds() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

/// A player on a card, and an application's loop that looks after it 20 times a second.
struct Player {
  explicit Player(SoundServer& sound_server) : server(sound_server) {
    StreamRequest request;
    request.device = "jack:" + card->name();
    request.in_channels = request.out_channels = 1;
    request.client_name = name;
    auto opened = ReconnectingStream::open(*jack, request, probe.guarded);
    if (!opened) throw std::runtime_error{to_string(opened.error())};
    stream = std::move(*opened);
    if (auto status = stream->start(); !status) throw std::runtime_error{to_string(status.error())};
  }

  void tick() {
    stream->tick();
    while (auto event = stream->take_event()) events += *event + "\n";
  }
  /// False: not within 30 seconds.
  bool run_until(const std::function<bool()>& holds) {
    const auto deadline = Clock::now() + 30s;
    for (tick(); !holds(); tick()) {
      if (Clock::now() > deadline) return false;
      std::this_thread::sleep_for(50ms);
    }
    return true;
  }
  bool is_told(const std::string& what) const { return events.find(what) != std::string::npos; }
  /// Every sample comes back again, as late as it should.
  bool sounds(int delay = kDelay + kPeriod) {
    return test::undisturbed("frames were lost", [&]() -> std::optional<bool> {
      const auto turn = stream->returns();
      const auto xruns = stream->health().xruns;
      if (!plays_on()) return false;
      probe.probe.listen_again();
      const bool right = wait_until([&] { return probe.probe.full(); }) && stream->returns() == turn &&
                         probe.probe.delay(0, 0) == delay;
      if (!right && stream->health().xruns > xruns) return std::nullopt;
      return right;
    });
  }
  /// Until all that was under way in the card has come out of it.
  bool plays_on() {
    const auto frames = probe.probe.frames();
    return run_until([&] { return probe.probe.frames() > frames + 4 * (kDelay + kPeriod); });
  }

  SoundServer& server;
  std::string name = "tactus-" + std::to_string(::getpid());
  std::unique_ptr<DelayClient> card =
      std::make_unique<DelayClient>(DelayClient::Settings{.delay_frames = kDelay});
  GuardedProbe probe{1, 4800};
  std::unique_ptr<Backend> jack = test::backend_named("jack");
  std::unique_ptr<ReconnectingStream> stream;
  std::string events;
};

/// What a fault did to a player. `recovery`: from when there was again what it needs, to its first block.
struct Outcome {
  bool survived = false;
  double recovery_seconds = 0.0;
  std::string why = {};
};

Outcome failed(const std::string& why) { return {false, 0.0, why}; }

/// The player lost its device; `mend` brings it back.
Outcome lose_and_mend(Player& player, const std::function<void()>& mend) {
  if (!player.run_until([&] { return player.stream->state() == StreamState::Lost; }))
    return failed("not Lost");
  const auto frames = player.probe.probe.frames();
  const auto cpu = cpu_seconds();
  const auto begin = Clock::now();
  player.run_until([&] { return seconds_since(begin) > 0.25; });
  if (player.probe.probe.frames() != frames) return failed("plays while it is Lost");
  if (cpu_seconds() - cpu > 0.5 * seconds_since(begin)) return failed("busy while it is Lost");
  const int returns = player.stream->returns();
  mend();
  const auto mended = Clock::now();
  if (!player.run_until(
          [&] { return player.stream->returns() > returns && player.probe.probe.frames() > 0; }))
    return failed("does not come back");
  return {true, seconds_since(mended), ""};
}

Outcome kill_server(Player& player) {
  player.server.kill();
  return lose_and_mend(player, [&] {
    player.server.restart();
    player.card = std::make_unique<DelayClient>(DelayClient::Settings{.delay_frames = kDelay});
  });
}

Outcome kill_card(Player& player) {
  player.card->process().kill();
  return lose_and_mend(player, [&] {
    player.card = std::make_unique<DelayClient>(DelayClient::Settings{.delay_frames = kDelay});
  });
}

Outcome stop_server(Player& player) {
  player.server.stop_answering();
  const auto begin = Clock::now();
  player.run_until([&] { return seconds_since(begin) > 0.3; });
  player.server.go_on();
  const auto mended = Clock::now();
  if (!player.plays_on()) return failed("does not play on");
  return {true, seconds_since(mended), ""};
}

Outcome stop_and_kill_server(Player& player) {
  player.server.stop_answering();
  const auto begin = Clock::now();
  player.run_until([&] { return seconds_since(begin) > 0.1; });
  return kill_server(player);
}

Outcome change_period(Player& player) {
  for (const int period : {2 * kPeriod, kPeriod}) {
    player.server.set_period(period);
    if (!player.plays_on()) return failed("does not play on");
    if (!player.sounds(kDelay + period)) return failed("sounds wrong with another block");
  }
  return {true, 0.0, ""};
}

Outcome pull_ports(Player& player) {
  const auto out = player.name + ":out_1", in = player.name + ":in_1";
  player.server.disconnect(player.name);
  if (!player.plays_on()) return failed("does not play on");
  if (!wait_until([&] {
        player.tick();
        return player.is_told("disconnected '" + out);
      }))
    return failed("does not tell");
  if (player.server.connections(out) != "") return failed("does not leave it as the user did it");
  player.server.connect(out, player.card->name() + ":playback_1");
  player.server.connect(player.card->name() + ":capture_1", in);
  const auto mended = Clock::now();
  if (!wait_until([&] { return player.sounds(); })) return failed("is not heard again");
  return {true, seconds_since(mended), ""};
}

struct Fault {
  const char* name;
  Outcome (*make)(Player&);
};
constexpr Fault kFaults[] = {{"server killed", kill_server},
                             {"server stopped for 300 ms", stop_server},
                             {"server killed while stopped", stop_and_kill_server},
                             {"block size changed and back", change_period},
                             {"ports pulled and connected", pull_ports},
                             {"device gone", kill_card}};

}  // namespace

TEST_CASE("jack: survives each fault three times, and every sample comes back after it",
          "[cards][jack][slow]") {
  const auto fault = GENERATE(from_range(std::begin(kFaults), std::end(kFaults)));
  INFO(fault.name);
  const auto server = start_sound_server();
  Player player{*server};
  for (int turn = 0; turn < 3; ++turn) {
    CAPTURE(turn);
    const auto outcome = fault.make(player);
    INFO(outcome.why << "\n" << player.events);
    REQUIRE(outcome.survived);
    REQUIRE(player.stream->state() == StreamState::Running);
    REQUIRE(player.stream->granted().device == "jack:" + player.card->name());
    REQUIRE(player.sounds());
  }
  CHECK(player.stream->stop());
}

// scripts/soak_faults; $TACTUS_FAULTS says how many.
TEST_CASE("jack: survives a thousand faults", "[.thousand]") {
  const char* wanted = std::getenv("TACTUS_FAULTS");
  const int count = wanted == nullptr ? 1000 : std::atoi(wanted);
  const auto server = start_sound_server();
  REQUIRE(server);
  auto player = std::make_unique<Player>(*server);
  std::map<std::string, std::vector<double>> recoveries;
  int survived = 0;
  for (int turn = 0; turn < count; ++turn) {
    const auto& fault = kFaults[static_cast<std::size_t>(turn) % std::size(kFaults)];
    const auto outcome = fault.make(*player);
    if (outcome.survived && player->sounds()) {
      ++survived;
      recoveries[fault.name].push_back(outcome.recovery_seconds);
    } else {
      std::cout << "fault " << turn << ", " << fault.name << ": "
                << (outcome.why.empty() ? "sounds wrong after it" : outcome.why) << "\n"
                << player->events;
      player.reset();
      player = std::make_unique<Player>(*server);
    }
    player->events.clear();
  }
  for (auto& [name, seconds] : recoveries) {
    std::sort(seconds.begin(), seconds.end());
    std::cout << name << ": " << seconds.size() << " survived, recovery p50 "
              << std::lround(1e3 * seconds[seconds.size() / 2]) << " ms, worst "
              << std::lround(1e3 * seconds.back()) << " ms\n";
  }
  std::cout << survived << " of " << count << " faults survived\n";
  CHECK(survived == count);
  for (const auto& [name, seconds] : recoveries) CHECK(seconds.back() < 2.0);  // what a user is promised
}

TEST_CASE("jack: each time that a client is late is counted, on a synchronous server", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{*server};
  const auto before = player.card->xruns() - player.stream->health().xruns;  // when only the card was there
  for (int turn = 1; turn <= 10; ++turn) player.card->sleep_once(30ms);
  const auto injected = [&] { return player.card->xruns() - before; };
  CHECK(wait_until([&] { return player.stream->health().xruns == injected(); }));
  const auto health = player.stream->health();
  CHECK(health.gaps[static_cast<std::size_t>(Gap::Server)] == health.xruns);
  CHECK(health.xruns >= 10);
  if (health.realtime_priority > 0) CHECK(health.xruns == 10);  // otherwise the machine makes its own
  CHECK(player.sounds());
}

TEST_CASE("jack: the time that everybody waits for a late client is found by the clock", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{*server};
  REQUIRE(wait_until([&] { return player.stream->health().frames > 0; }));
  const auto begin = Clock::now();
  const auto begun = player.stream->health().frames;
  for (int turn = 0; turn < 10; ++turn) player.card->sleep_once(100ms);  // 10 * 4544 frames
  const auto frames = player.probe.probe.frames();
  REQUIRE(wait_until([&] { return player.probe.probe.frames() > frames + 60000; }));  // two half seconds
  const auto health = player.stream->health();
  const double expected = 48000 * seconds_since(begin);
  CHECK(static_cast<double>(health.frames - begun + health.lost_frames) == Approx(expected).epsilon(0.05));
  CHECK(static_cast<double>(health.frames - begun) < 0.8 * expected);
  CHECK(health.gaps[static_cast<std::size_t>(Gap::Unsaid)] == 0);
}

TEST_CASE("jack: frames that the server did not wait for are counted to the frame", "[cards][jack]") {
  const auto server = start_sound_server({.synchronous = false});
  DelayClient card{{.delay_frames = 9600}};
  GuardedProbe probe{1, 4800};
  StreamRequest request;
  request.device = "jack:" + card.name();
  request.in_channels = request.out_channels = 1;
  request.client_name = "tactus-" + std::to_string(::getpid());
  const auto jack = test::backend_named("jack");
  const auto stream = jack->open(request, probe.guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  REQUIRE(wait_until([&] { return probe.probe.frames() > 2 * 9600; }));
  const auto lost_before = (*stream)->health().lost_frames;
  probe.probe.sleep_ms = 50;
  REQUIRE(wait_until([&] { return probe.probe.full(); }));
  const auto health = (*stream)->health();
  const auto lost = health.lost_frames - lost_before;
  REQUIRE((*stream)->stop());
  if (health.realtime_priority == 0)
    test::skip("without real-time threads, which this user may not have, other frames are lost as well");
  CHECK(lost >= 2048);                                  // 50 ms are 9.4 periods
  CHECK(probe.probe.delay(0, 0) == 9600 + 256 - lost);  // what was sent before comes so much earlier
}

TEST_CASE("jack: a server that does not answer is told, and nobody waits for it for ever", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{*server};
  server->stop_answering();
  REQUIRE(player.run_until([&] { return player.stream->state() == StreamState::Stalled; }));
  CHECK(player.is_told("does not respond"));
  const auto refused = player.stream->stop();
  REQUIRE_FALSE(refused);
  CHECK(to_string(refused.error()).find("the JACK server does not respond") == 0);
  GuardedProbe other{1};
  const auto devices = player.jack->devices();
  REQUIRE_FALSE(devices);
  CHECK(to_string(devices.error()).find("the JACK server does not respond") == 0);
  player.stream.reset();
  server->go_on();
  CHECK(wait_until([&] { return player.jack->devices().has_value(); }));
}

TEST_CASE("jack: a stall ends by itself, and is told", "[cards][jack]") {
  const auto server = start_sound_server();
  Player player{*server};
  server->stop_answering();
  REQUIRE(player.run_until([&] { return player.stream->state() == StreamState::Stalled; }));
  server->go_on();
  REQUIRE(player.run_until([&] { return player.is_told("responds again"); }));
  CHECK(player.stream->state() == StreamState::Running);
  CHECK(player.stream->returns() == 0);
  CHECK(player.sounds());
}

TEST_CASE("jack: without a server there are words, and nothing is started or printed", "[cards][jack]") {
  ::setenv("JACK_DEFAULT_SERVER", "tactus-test-none", 1);
  std::FILE* caught = std::tmpfile();
  const int stderr_before = ::dup(STDERR_FILENO);
  ::dup2(::fileno(caught), STDERR_FILENO);
  const auto devices = test::backend_named("jack")->devices();
  ::dup2(stderr_before, STDERR_FILENO);
  ::close(stderr_before);
  ::unsetenv("JACK_DEFAULT_SERVER");
  CHECK(::lseek(::fileno(caught), 0, SEEK_END) == 0);
  std::fclose(caught);
  REQUIRE_FALSE(devices);
  CHECK(devices.error().code == Errc::Device);
  CHECK(to_string(devices.error()).find("no JACK server is running; start one") == 0);
}

TEST_CASE("jack: the server's sound card comes first and is the default", "[cards][jack]") {
  const auto server = start_sound_server({.channels = 3});
  DelayClient card{{.channels = 5, .input_latency = 7, .output_latency = 8}};
  const auto devices = test::backend_named("jack")->devices();
  REQUIRE(devices);
  REQUIRE(devices->size() == 3);
  CHECK(devices->front().id == "jack:system");
  CHECK(devices->front().in_channels == 3);
  CHECK(devices->front().is_default);
  CHECK(devices->front().block_frames == 256);
  const auto& last = devices->back();
  CHECK(last.id == "jack:" + card.name());
  CHECK(last.in_channels == 5);
  CHECK(last.out_channels == 5);
  CHECK(last.input_latency_frames == 7.0);
  CHECK(last.output_latency_frames == 8.0);
}

TEST_CASE("jack: two players of one name are two clients", "[cards][jack]") {
  const auto server = start_sound_server();
  Player first{*server};
  GuardedProbe probe{1};
  StreamRequest request;
  request.in_channels = request.out_channels = 1;
  request.client_name = first.name;
  const auto second = first.jack->open(request, probe.guarded);
  REQUIRE(second);
  REQUIRE((*second)->start());
  CHECK(wait_until([&] { return probe.probe.frames() > 0; }));
  CHECK(first.sounds());
}
