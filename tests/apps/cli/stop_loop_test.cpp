#include "apps/cli/stop_loop.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <optional>
#include <string>
#include <vector>

#include "engine/guard/guarded.h"
#include "tests/support/full_scale.h"
#include "tests/support/keyboard.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace tactus::app;
using test::wait_until;
using Ending = StopLoop::Ending;
using namespace std::chrono_literals;

TEST_CASE("stop loop: a control thread that stalls is reported once for each stall", "[cli]") {
  DeadMansSwitch dead_man;
  std::atomic<int> turns = 0, stalls = 0;
  StopLoop loop{dead_man,
                {.act = {},
                 .each_turn = [&](auto) { ++turns; },
                 .inputs = {},
                 .control_stalled = [&] { ++stalls; },
                 .fade = {}}};
  const auto pass_turns = [&](int many, auto each) {
    const int end = turns + many;
    REQUIRE(wait_until([&] {
      each();
      return turns >= end;
    }));
  };
  pass_turns(40, [] {});
  CHECK(stalls == 0);  // it has not begun
  pass_turns(40, [&] { (void)loop.wait_key(0ms); });
  CHECK(stalls == 0);
  pass_turns(60, [] {});
  CHECK(stalls == 1);
  CHECK_FALSE(dead_man.stopped());
  pass_turns(5, [&] { (void)loop.wait_key(0ms); });
  pass_turns(60, [] {});
  CHECK(stalls == 2);
}

namespace {

/// A stop that arrives when the loop has just looked for it.
class LateStop {
 public:
  explicit LateStop(const std::string& by) : by_(by) {}
  /// How long it took until the outputs were told to fade; nothing: longer than to the end of the next turn.
  std::optional<StopLoop::Clock::duration> measure() {
    StopLoop loop{dead_man_,
                  {.act = {},
                   .each_turn = [this](auto) { begin_turn(); },
                   .inputs = {[this] { return further_input(); }},
                   .fade = {}}};
    REQUIRE(wait_until([&] { return dead_man_.stopped(); }));
    const auto stopped = StopLoop::Clock::now();
    REQUIRE(wait_until([&] { return turns_ > 2; }));
    if (!in_next_turn_) return std::nullopt;
    return stopped - arrived_.load();
  }

 private:
  void begin_turn() {
    if (++turns_ == 1 && by_ != "input") arrive();
    if (turns_ == 3) in_next_turn_ = dead_man_.stopped();
  }
  bool further_input() {
    if (turns_ > 1) return by_ == "input";
    if (by_ == "input") arrive();
    return false;
  }
  void arrive() {
    arrived_ = StopLoop::Clock::now();
    if (by_ == "signal") std::raise(SIGTERM);
    if (by_ == "key") keyboard_.press('q');
  }

  const std::string by_;
  test::Keyboard keyboard_;
  DeadMansSwitch dead_man_;
  std::atomic<int> turns_{0};
  std::atomic<bool> in_next_turn_{false};
  std::atomic<StopLoop::Clock::time_point> arrived_{};
};

}  // namespace

TEST_CASE("stop loop: a stop that arrives in a turn acts in the next one, within 50 ms with its block",
          "[live]") {
  const std::string by = GENERATE(as<std::string>{}, "signal", "key", "input");
  CAPTURE(by);
  constexpr auto kMost = 50ms - 22ms;       // outputs fade in the next block: 21.3 ms for 1024 frames
  StopLoop::Clock::duration shortest = 1h;  // of many: no busy machine delays each of them
  for (int attempt = 0; attempt < 20 && shortest > kMost; ++attempt) {
    const auto took = LateStop{by}.measure();
    REQUIRE(took);
    shortest = std::min(shortest, *took);
  }
  CHECK(shortest <= kMost);
}

TEST_CASE("stop loop: a signal stops the dead man's switch, whatever the control thread does", "[live]") {
  const auto signal = GENERATE(SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM,
                               SIGXCPU, SIGPROF, SIGIO, SIGSYS, SIGTRAP);
  DeadMansSwitch dead_man;
  {
    StopLoop loop{dead_man};
    CHECK(loop.ending() == Ending::None);
    std::raise(signal);
    REQUIRE(wait_until([&] { return dead_man.stopped(); }));
    REQUIRE(wait_until([&] { return loop.ending() == Ending::Interrupted; }));
    CHECK_FALSE(loop.wait_key(std::chrono::seconds{60}).has_value());
  }
}

#if defined(SIGRTMIN)
TEST_CASE("stop loop: so does every real-time signal", "[live]") {
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) {
    CAPTURE(signal);
    DeadMansSwitch dead_man;
    StopLoop loop{dead_man};
    std::raise(signal);
    REQUIRE(wait_until([&] { return loop.ending() == Ending::Interrupted; }));
  }
}
#endif

TEST_CASE("stop loop: no signal suspends the process, or ends it for a failed write", "[live]") {
  DeadMansSwitch dead_man;
  StopLoop loop{dead_man};
  for (const auto signal : {SIGTSTP, SIGTTIN, SIGTTOU, SIGCONT, SIGPIPE, SIGXFSZ}) std::raise(signal);
  const auto before = dead_man.refreshes();
  REQUIRE(wait_until([&] { return dead_man.refreshes() > before + 2; }));
  CHECK(loop.ending() == Ending::None);
}

TEST_CASE("stop loop: a closed standard input ends it once it is needed, however long it was closed before",
          "[live]") {
  test::Keyboard keyboard;
  keyboard.close();
  DeadMansSwitch dead_man;
  std::atomic<int> asked{0};
  std::atomic<bool> needed{false};
  StopLoop loop{dead_man, {.act = {}, .needs_input = [&] { return ++asked, needed.load(); }, .inputs = {}}};
  REQUIRE(wait_until([&] { return asked > 3; }));
  CHECK(loop.ending() == Ending::None);
  needed = true;
  REQUIRE(wait_until([&] { return loop.ending() == Ending::InputClosed; }));
  CHECK(dead_man.stopped());
}

TEST_CASE("stop loop: it calls back in each turn, without keys too", "[live]") {
  DeadMansSwitch dead_man;
  std::atomic<int> turns{0};
  const auto count = [&](StopLoop::Clock::time_point) { ++turns; };
  StopLoop loop{dead_man, {.act = {}, .each_turn = count, .inputs = {}, .fade = {}}};
  CHECK(wait_until([&] { return turns > 3; }));
}

TEST_CASE("stop loop: it refreshes the dead man's switch, and other stop inputs end the program too",
          "[live]") {
  DeadMansSwitch dead_man;
  std::atomic<bool> pressed{false};
  StopLoop loop{dead_man, {.act = {}, .inputs = {[&] { return pressed.load(); }}, .fade = {}}};
  const auto before = dead_man.refreshes();
  REQUIRE(wait_until([&] { return dead_man.refreshes() > before + 10; }));
  CHECK_FALSE(dead_man.stopped());
  pressed = true;
  CHECK(wait_until([&] { return dead_man.stopped(); }));
}

TEST_CASE("stop loop: where it is blocked every output fades, and starts softly when it continues",
          "[live]") {
  DeadMansSwitch dead_man;
  std::atomic<bool> block{false}, blocked{false};
  const auto hang = [&] {
    blocked = block.load();
    return blocked && !wait_until([&] { return !block; });
  };
  StopLoop loop{dead_man, {.act = {}, .inputs = {hang}, .fade = {}}};
  test::FullScale one;
  Guarded guarded{one, {{DriveGuard::Kind::Drive, {.soft_start = 10_ms, .fade_out = 10_ms}}}};
  guarded.set_dead_mans_switch(&dead_man);
  REQUIRE(guarded.prepare({.out_channels = 1}));
  std::vector<double> samples(480);
  double* out[] = {samples.data()};
  const auto play = [&](int blocks) {
    for (int n = 0; n < blocks; ++n) guarded.process({nullptr, out, 480});
    return samples.back();
  };
  block = true;
  REQUIRE(wait_until([&] { return blocked.load(); }));
  CHECK(play(50) == 1.0);  // 500 ms, the first block with the last refresh
  CHECK(play(2) == 0.0);
  block = false;
  const auto before = dead_man.refreshes();
  REQUIRE(wait_until([&] { return dead_man.refreshes() > before; }));
  CHECK(play(1) < 1.0);
  CHECK(play(1) == 1.0);
}
