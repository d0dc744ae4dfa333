#include "tests/support/terminal_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

#include "tests/support/wait_until.h"

namespace tactus::test {

TerminalProcess::TerminalProcess(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const auto& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  terminal_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  if (terminal_ < 0 || ::grantpt(terminal_) != 0 || ::unlockpt(terminal_) != 0) std::abort();
  const std::string name = ::ptsname(terminal_);
  pid_ = ::fork();
  if (pid_ < 0) std::abort();
  if (pid_ > 0) return;
  ::setsid();  // only calls that are safe between fork and exec
  const int own = ::open(name.c_str(), O_RDWR);
  ::ioctl(own, TIOCSCTTY, 0);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(own, stream);
  if (own > STDERR_FILENO) ::close(own);
  ::execvp(arguments[0], arguments.data());
  ::_exit(127);
}

TerminalProcess::~TerminalProcess() {
  send(SIGKILL);
  wait(std::chrono::seconds{10});
  close();
}

void TerminalProcess::make_cooked() const {
  termios mode;
  if (::tcgetattr(terminal_, &mode) != 0) return;
  mode.c_lflag |= ICANON | ECHO | ISIG;
  mode.c_iflag |= IXON;
  ::tcsetattr(terminal_, TCSANOW, &mode);
}

void TerminalProcess::type(const std::string& bytes) const {
  [[maybe_unused]] const auto written = ::write(terminal_, bytes.data(), bytes.size());
}

void TerminalProcess::send(int signal) const {
  if (!ended_) ::kill(pid_, signal);
}

void TerminalProcess::close() {
  if (const int terminal = std::exchange(terminal_, -1); terminal >= 0) ::close(terminal);
}

void TerminalProcess::stall() {
  stalled_ = true;
  const int line = ::open(::ptsname(terminal_), O_WRONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  const std::string bytes(4096, 'x');
  pollfd writable{line, POLLOUT, 0};
  do {  // the kernel moves what was written on to another buffer
    while (::write(line, bytes.data(), bytes.size()) > 0) continue;
  } while (::poll(&writable, 1, 100) > 0);
  ::close(line);
}

void TerminalProcess::read_output(std::chrono::milliseconds patience) {
  pollfd readable{terminal_, POLLIN, 0};
  if (terminal_ < 0 || stalled_ || ::poll(&readable, 1, static_cast<int>(patience.count())) <= 0) return;
  char bytes[4096];
  if (const auto count = ::read(terminal_, bytes, sizeof bytes); count > 0)
    output_.append(bytes, static_cast<std::size_t>(count));
}

bool TerminalProcess::shows(const std::string& words) {
  return wait_until([&] {
    read_output(std::chrono::milliseconds{10});
    const auto found = output_.find(words, searched_);
    if (found == std::string::npos) return false;
    searched_ = found + words.size();
    return true;
  });
}

std::optional<int> TerminalProcess::wait(std::chrono::milliseconds patience) {
  (void)wait_until(
      [&] {
        read_output(std::chrono::milliseconds{0});
        int status = 0;
        if (!ended_ && ::waitpid(pid_, &status, WNOHANG) == pid_)
          ended_ = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
        return ended_.has_value();
      },
      patience);
  return ended_;
}

}  // namespace tactus::test
