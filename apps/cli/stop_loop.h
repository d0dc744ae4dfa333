#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <optional>
#include <thread>
#include <vector>

#include "apps/cli/keys.h"
#include "apps/cli/stop_inputs.h"
#include "engine/core/spsc_queue.h"
#include "engine/core/units.h"
#include "engine/guard/dead_mans_switch.h"

namespace tactus::app {

/// Handles the stop inputs of a program whose outputs move something, on a thread of its own that never
/// compiles, prints or waits for a file: what the other threads wait for does not matter. Every 20 ms it
/// refreshes the dead man's switch. At once it stops the switch, so that every output fades out, at
///   q                                                         Ending::Quit
///   a signal to stop (StopInputs), a terminal that is closed  Ending::Interrupted
///   a closed pipe or socket at standard input, while needed   Ending::InputClosed
/// At a second signal it ends the process with exit code 5, though other threads hang: one second after the
/// outputs had their time to fade.
class StopLoop {
 public:
  using Clock = std::chrono::steady_clock;
  enum class Ending { None, Quit, Interrupted, InputClosed };
  struct Settings {
    /// [stop loop] Acts on a key at once; the keys that it returns, other than kNoKey, go to `wait_key`.
    std::function<Key(Key, Clock::time_point)> act;
    /// [stop loop] Called in each turn, before its keys.
    std::function<void(Clock::time_point)> each_turn{};
    /// [stop loop] Asked in each turn once a pipe or socket at standard input is closed: does that end the
    /// program?
    std::function<bool()> needs_input{};
    /// [stop loop] More stop inputs, asked in each turn: true ends the program as a signal does. None of them
    /// waits for anything.
    std::vector<std::function<bool()>> inputs;
    /// [stop loop] Called when the thread of `wait_key` has not called it for 25 turns, though it had before:
    /// what that thread watches is watched no more. Turns are counted and not time, so that a program that
    /// was stopped as a whole is none that stalls.
    std::function<void()> control_stalled{};
    Seconds fade{0.0};  ///< how long the outputs take to fade out
  };

  /// [control] `dead_man` outlives it.
  StopLoop(DeadMansSwitch& dead_man, Settings settings);
  explicit StopLoop(DeadMansSwitch& dead_man) : StopLoop(dead_man, Settings{}) {}
  ~StopLoop();
  StopLoop(const StopLoop&) = delete;
  StopLoop& operator=(const StopLoop&) = delete;

  /// [any]
  Ending ending() const { return ending_.load(); }
  /// [any] The keys are those of a terminal.
  bool reads_terminal() const { return inputs_.reads_terminal(); }
  /// [any] As StopInputs has it.
  bool in_foreign_terminal() const { return inputs_.in_foreign_terminal(); }
  /// [control, one thread] The next key; nothing if none is pressed within this time, or the program ends.
  std::optional<Key> wait_key(std::chrono::milliseconds timeout);

 private:
  void run();
  void turn();
  void end(Ending ending);
  void handle_key(Key key, Clock::time_point now);
  void pass(Key key);
  void exit_if_hung(Clock::time_point now);
  void watch_control();

  DeadMansSwitch& dead_man_;
  const Settings settings_;
  StopInputs inputs_;
  KeyDecoder decoder_;
  SpscQueue<Key> keys_{256};
  std::atomic<Ending> ending_{Ending::None};
  std::atomic<bool> done_{false};
  std::atomic<unsigned> control_waits_{0};  ///< calls of wait_key
  // Of the thread.
  Clock::time_point ended_at_;
  bool input_closed_ = false;
  int stops_ = 0;  ///< signals after the end
  unsigned seen_waits_ = 0;
  int stalled_turns_ = 0;
  std::thread thread_;
};

}  // namespace tactus::app
