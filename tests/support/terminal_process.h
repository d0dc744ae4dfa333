#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace tactus::test {

/// A program on a terminal of its own, which controls it. POSIX only. It is killed with this object.
class TerminalProcess {
 public:
  explicit TerminalProcess(const std::vector<std::string>& command);
  ~TerminalProcess();
  TerminalProcess(const TerminalProcess&) = delete;
  TerminalProcess& operator=(const TerminalProcess&) = delete;

  void type(const std::string& bytes) const;
  void send(int signal) const;
  /// Sets the mode of lines with echo, as another program can.
  void make_cooked() const;
  /// The terminal is closed, as when its window is.
  void close();
  /// Its output is not read any more, as that of a window that hangs, and its line is full, until `resume`.
  void stall();
  void resume() { stalled_ = false; }
  /// Reads on until the output since the last call contains this; false: it does not within half a minute.
  bool shows(const std::string& words);
  /// All that it wrote so far.
  const std::string& output() const { return output_; }
  /// The exit code, or minus the signal that ended it; empty: it still runs after `patience`.
  std::optional<int> wait(std::chrono::milliseconds patience = std::chrono::seconds{60});
  bool running() { return !wait(std::chrono::milliseconds{0}); }

 private:
  void read_output(std::chrono::milliseconds patience);

  int pid_ = -1, terminal_ = -1;
  bool stalled_ = false;
  std::optional<int> ended_;
  std::string output_;
  std::size_t searched_ = 0;
};

}  // namespace tactus::test
