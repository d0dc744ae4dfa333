#pragma once

#include <chrono>
#include <string>

namespace tactus::app {

/// The stop inputs of the process: signals, and the keys of standard input. A terminal is switched to deliver
/// keys without Enter, without echo and without flow control (Ctrl-S would stop its output), and restored at
/// the end, as are the signals. A process has one of these at a time.
class StopInputs {
 public:
  /// [control]
  StopInputs();
  ~StopInputs();
  StopInputs(const StopInputs&) = delete;
  StopInputs& operator=(const StopInputs&) = delete;

  struct Arrived {
    int stops = 0;         ///< SIGINT, SIGTERM and SIGQUIT; Ctrl-C, Ctrl-Break
    bool hung_up = false;  ///< the terminal was closed
    std::string bytes;     ///< of standard input
  };
  /// [any, one thread] What arrived; waits for it for `timeout` at most.
  Arrived wait(std::chrono::milliseconds timeout);

  /// [any] The keys are those of a terminal.
  bool reads_terminal() const { return terminal_; }
  /// [any] Restores the terminal and ends the process, whatever other threads do.
  [[noreturn]] void exit_now(int exit_code);

 private:
  void read_keys(Arrived& arrived);
  void open_terminal();
  void restore_terminal();

  bool terminal_ = false, open_ = true;  ///< standard input
};

}  // namespace tactus::app
