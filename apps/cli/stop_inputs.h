#pragma once

#include <chrono>
#include <string>

namespace tactus::app {

/// [control] At the start of a command whose outputs move something: the signals that StopInputs reports end
/// the process until there is one, although its parent had them ignored or blocked.
void accept_stop_signals();

/// The stop inputs of the process: signals, and the keys of standard input. A terminal is switched to deliver
/// keys without Enter, without echo and without flow control (Ctrl-S would stop its output), and restored at
/// the end, as are the signals. In its background no keys are read, but its end is detected; so is that of
/// the terminal of a process whose standard input is something else. Signals that would suspend the process,
/// or end it for a failed write, are ignored; blocked ones are unblocked. A process has one of these at a
/// time.
class StopInputs {
 public:
  /// [control]
  StopInputs();
  ~StopInputs();
  StopInputs(const StopInputs&) = delete;
  StopInputs& operator=(const StopInputs&) = delete;

  struct Arrived {
    int stops = 0;              ///< SIGINT, SIGTERM and others whose default is to end; Ctrl-C as a byte
                                ///< too, Ctrl-Break
    bool hung_up = false;       ///< the terminal was closed, now or before the start, or cannot be waited for
    bool input_closed = false;  ///< the other end of a pipe or socket at standard input is; reported once
    std::string bytes;          ///< of standard input
  };
  /// [any, one thread] What arrived; waits for it for `timeout` at most.
  Arrived wait(std::chrono::milliseconds timeout);

  /// [any] The keys are those of a terminal, which had this process in its foreground at first.
  bool reads_terminal() const { return reads_terminal_; }
  /// [any] Standard input is a terminal that does not control this process, but another session perhaps,
  /// whose shell reads it too: no keys are read.
  bool in_foreign_terminal() const { return foreign_terminal_; }
  /// [any] Restores the terminal and ends the process, whatever other threads do.
  [[noreturn]] void exit_now(int exit_code);

 private:
  void open_input();
  void read_signals(Arrived& arrived);
  void read_input(int events, Arrived& arrived);
  void read_keys(Arrived& arrived);
  void follow_foreground();
  static bool is_raw();
  void set_raw();
  void restore_terminal();

  int other_terminal_ = -1;  ///< only its end counts
  int input_ = 0;            ///< standard input, opened again where that makes its reads never block
  bool open_ = true, terminal_ = false, foreign_terminal_ = false, reads_terminal_ = false;
  bool connection_ = false;     ///< a pipe or socket
  bool datagrams_ = false;      ///< a socket without an end
  bool closed_before_ = false;  ///< standard input or output is a terminal that is gone; not reported yet
  bool paused_ = false;         ///< the last read gave nothing: none in the next turn, which then waits
  bool raw_ = false;            ///< the terminal delivers single keys to this process
  bool mode_known_ = false;     ///< of the terminal, before it was raw
};

}  // namespace tactus::app
