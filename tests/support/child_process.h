#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace tactus::test {

/// A program that runs beside the test, POSIX only. It is killed with this object, or (Linux) with the thread
/// that began it.
class ChildProcess {
 public:
  enum class Stdout { Read, Logged };
  static constexpr int kCannotRun = 127;  ///< the exit code of a program that is not there

  /// `command[0]` is looked for in PATH. Where its stdout is read, `say` and `hear` exchange lines with it.
  /// `stderr_to`: an open file for its stderr instead of the log.
  explicit ChildProcess(const std::vector<std::string>& command, Stdout out = Stdout::Read,
                        int stderr_to = -1);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  bool running();
  void send(int signal) const;
  /// SIGSTOP; returns when every thread has stopped.
  void pause() const;
  /// The exit code, or minus the signal that ended it; empty: it still runs after `patience`.
  std::optional<int> wait(std::chrono::milliseconds patience);
  /// SIGTERM, and SIGKILL when that does not end it within three seconds. Its exit code as `wait` tells it.
  int terminate();
  /// The end of its stdin.
  void hang_up() const;
  /// SIGKILL; returns when it is gone.
  void kill();

  /// Sends a line. False: nobody reads it.
  bool say(const std::string& line) const { return type(line + "\n"); }
  /// Sends bytes.
  bool type(const std::string& bytes) const;
  /// The next line it says; empty: none came within `patience`, or it is gone.
  std::string hear(std::chrono::milliseconds patience = std::chrono::seconds{10});
  /// What it wrote that is not read, until now.
  std::string log() const;

 private:
  int pid_ = -1;
  int socket_ = -1;
  int log_ = -1;
  std::optional<int> ended_;
  std::string unread_;
};

}  // namespace tactus::test
