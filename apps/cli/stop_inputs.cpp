#include "apps/cli/stop_inputs.h"

#include <csignal>
#include <cstdlib>
#include <utility>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

#include "engine/core/index.h"

namespace tactus::app {
namespace {

constexpr char kCtrlC = 0x03;  // of a terminal that makes no signal of it

/// SIGCONT, and those whose default is to end the process, except faults of its own.
std::vector<int> forwarded_signals() {
  std::vector<int> signals = {SIGINT,    SIGTERM, SIGQUIT, SIGHUP,  SIGUSR1, SIGUSR2, SIGALRM,
                              SIGVTALRM, SIGPROF, SIGIO,   SIGXCPU, SIGSYS,  SIGTRAP, SIGCONT};
#if defined(__linux__)
  signals.insert(signals.end(), {SIGPWR, SIGSTKFLT});
#endif
#if defined(SIGRTMIN)
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) signals.push_back(signal);
#endif
  return signals;
}
const std::vector<int> kForwarded = forwarded_signals();
/// A closed pipe and a file that is too large are errors of a write, not the end. A program that the terminal
/// suspends (Ctrl-Z, or reading and writing in the background) could not be stopped any more.
const std::vector<int> kIgnored = {SIGPIPE, SIGXFSZ, SIGTSTP, SIGTTIN, SIGTTOU};

// A process has one terminal and one handler of each signal.
termios terminal_before;
std::array<struct sigaction, NSIG> actions_before;
int signal_pipe[2] = {-1, -1};

/// A breakpoint without a debugger, or a system call that is forbidden: not sent by another process.
bool is_own_fault(int signal, const siginfo_t& info) {
  return (signal == SIGTRAP || signal == SIGSYS) && info.si_code > 0;
}

extern "C" void forward_signal(int signal, siginfo_t* info, void*) {
  if (is_own_fault(signal, *info)) {
    ::signal(signal, SIG_DFL);
    return void(::raise(signal));  // it ends the process where this handler returns
  }
  const int error = errno;
  const auto byte = static_cast<char>(signal);
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], &byte, 1);
  errno = error;
}

void handle(const std::vector<int>& signals, const struct sigaction& action) {
  for (const int signal : signals) ::sigaction(signal, &action, &actions_before[index(signal)]);
}

void handle_signals() {
  struct sigaction forward {};
  forward.sa_sigaction = forward_signal;
  forward.sa_flags = SA_RESTART | SA_SIGINFO;
  handle(kForwarded, forward);
  struct sigaction ignore {};
  ignore.sa_handler = SIG_IGN;
  handle(kIgnored, ignore);
}

void restore_signals() {
  for (const auto* signals : {&kForwarded, &kIgnored})
    for (const int signal : *signals) ::sigaction(signal, &actions_before[index(signal)], nullptr);
}

void open_signal_pipe() {
  if (::pipe(signal_pipe) != 0) std::abort();
  for (const int end : signal_pipe) {
    ::fcntl(end, F_SETFL, O_NONBLOCK);
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
}

/// A program inherits the signals that its parent had blocked.
void unblock(const std::vector<int>& signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : signals) sigaddset(&set, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

/// A terminal that is not standard input: the controlling one, or where messages go; otherwise -1.
int other_terminal() {
  if (const int controlling = ::open("/dev/tty", O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
      controlling >= 0)
    return controlling;
  for (const int output : {STDERR_FILENO, STDOUT_FILENO})
    if (::isatty(output) != 0) return ::fcntl(output, F_DUPFD_CLOEXEC, 0);
  return -1;
}

/// One that is not the controlling terminal has no foreground for this process.
bool is_foreign(int terminal) { return ::tcgetpgrp(terminal) < 0 && errno == ENOTTY; }

bool in_foreground() { return ::tcgetpgrp(STDIN_FILENO) == ::getpgrp(); }

bool is_pipe(int input) {
  struct stat kind {};
  return ::fstat(input, &kind) == 0 && S_ISFIFO(kind.st_mode);
}

/// -1: it is no socket.
int socket_type(int input) {
  int type = -1;
  socklen_t size = sizeof type;
  return ::getsockopt(input, SOL_SOCKET, SO_TYPE, &type, &size) == 0 ? type : -1;
}

/// Another process may read what `poll` announced: what can be read without waiting is.
ssize_t read_now(int input, char* bytes, std::size_t most) {
  const auto count = ::recv(input, bytes, most, MSG_DONTWAIT);
  return count < 0 && errno == ENOTSOCK ? ::read(input, bytes, most) : count;
}

/// What was a terminal and is closed cannot be asked any more what it is.
bool is_closed_terminal(int file) { return ::isatty(file) == 0 && errno == EIO; }

}  // namespace

void accept_stop_signals() {
  for (const int signal : kForwarded) {
    struct sigaction action {};
    if (::sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) ::signal(signal, SIG_DFL);
  }
  unblock(kForwarded);
}

StopInputs::StopInputs() {
  open_signal_pipe();
  handle_signals();
  unblock(kForwarded);
  open_input();
}

StopInputs::~StopInputs() {
  restore_terminal();
  restore_signals();
  for (const int end : signal_pipe) ::close(end);
  if (input_ != STDIN_FILENO) ::close(input_);
  if (other_terminal_ >= 0) ::close(other_terminal_);
}

/// O_NONBLOCK belongs to an open file, and that of standard input is shared with other processes.
void StopInputs::open_input() {
  terminal_ = ::isatty(STDIN_FILENO) != 0;
  foreign_terminal_ = terminal_ && is_foreign(STDIN_FILENO);
  const bool pipe = is_pipe(STDIN_FILENO);
  const int type = socket_type(STDIN_FILENO);
  datagrams_ = type == SOCK_DGRAM;
  connection_ = pipe || (type >= 0 && !datagrams_);
  if (terminal_ || pipe)
    input_ = std::max(::open("/dev/stdin", O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC), STDIN_FILENO);
  if (!terminal_ || foreign_terminal_) other_terminal_ = other_terminal();
  closed_before_ =
      std::ranges::any_of(std::array{STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}, is_closed_terminal);
  follow_foreground();
  reads_terminal_ = raw_;
}

void StopInputs::follow_foreground() {
  const bool foreground = terminal_ && in_foreground();
  if (!foreground) raw_ = false;
  if (foreground && !(raw_ && is_raw())) set_raw();
}

/// False once another program has changed the mode, as `stty sane` does.
bool StopInputs::is_raw() {
  termios mode;
  if (::tcgetattr(STDIN_FILENO, &mode) != 0) return true;
  return (mode.c_lflag & (ICANON | ECHO)) == 0 && (mode.c_iflag & IXON) == 0 && mode.c_cc[VMIN] == 1 &&
         mode.c_cc[VTIME] == 0 && mode.c_cc[VSUSP] == _POSIX_VDISABLE;
}

void StopInputs::set_raw() {
  termios raw;
  if (::tcgetattr(STDIN_FILENO, &raw) != 0) return;
  if (!std::exchange(mode_known_, true)) terminal_before = raw;
  raw_ = true;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

/// In the background the mode is that of another program.
void StopInputs::restore_terminal() {
  if (raw_ && in_foreground()) ::tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
}

StopInputs::Arrived StopInputs::wait(std::chrono::milliseconds timeout) {
  Arrived arrived;
  follow_foreground();
  const bool keys = !terminal_ || raw_;
  const bool asked = open_ && !std::exchange(paused_, false);
  pollfd inputs[] = {{signal_pipe[0], POLLIN, 0},
                     {asked ? input_ : -1, static_cast<short>(keys ? POLLIN : 0), 0},
                     {other_terminal_, 0, 0}};
  const int ready = ::poll(inputs, 3, static_cast<int>(timeout.count()));
  const bool any = ready > 0;
  arrived.hung_up =
      std::exchange(closed_before_, false) || (ready < 0 && errno != EINTR);  // no key would come
  read_signals(arrived);
  if (any && asked) read_input(inputs[1].revents, arrived);
  if (any && inputs[2].revents != 0) {
    arrived.hung_up = true;
    ::close(std::exchange(other_terminal_, -1));
  }
  return arrived;
}

void StopInputs::read_signals(Arrived& arrived) {
  char signals[64];
  for (auto count = ::read(signal_pipe[0], signals, sizeof signals); count > 0;
       count = ::read(signal_pipe[0], signals, sizeof signals))
    for (int s = 0; s < count; ++s) {
      if (signals[s] == SIGCONT)
        raw_ = false;  // a shell may have changed the mode while the process was suspended
      else if (signals[s] == SIGHUP)
        arrived.hung_up = true;
      else
        ++arrived.stops;
    }
}

/// The end of a terminal is what `poll` reports: reading may fail in its background too.
void StopInputs::read_input(int events, Arrived& arrived) {
  if (terminal_ && (events & (POLLHUP | POLLERR | POLLNVAL)) != 0) {
    open_ = false;
    arrived.hung_up = true;
  } else if (events != 0) {
    read_keys(arrived);
  }
}

void StopInputs::read_keys(Arrived& arrived) {
  char bytes[4096];
  const auto count = read_now(input_, bytes, sizeof bytes);
  if (count > 0) {
    arrived.bytes.assign(bytes, static_cast<std::size_t>(count));
    arrived.stops += static_cast<int>(std::ranges::count(arrived.bytes, kCtrlC));
    return;
  }
  paused_ = true;
  // No bytes are the end of a file, an error is that of a connection; anything else may pass.
  const bool ended =
      count == 0 ? !terminal_ && !datagrams_ : connection_ && errno != EINTR && errno != EAGAIN;
  if (!ended) return;
  open_ = false;
  arrived.input_closed = connection_;
}

void StopInputs::exit_now(int exit_code) {
  restore_terminal();
  ::_exit(exit_code);
}

}  // namespace tactus::app

#elif defined(_WIN32)
// Not tested: no one has run it on Windows yet.
#include <conio.h>
#include <io.h>
#include <windows.h>

#include <atomic>
#include <cstdio>

namespace tactus::app {
namespace {

std::atomic<int> stops{0};
std::atomic<bool> closed{false};

/// On a thread of its own. The process ends when it returns from a close: the outputs fade meanwhile.
BOOL WINAPI handle_control(DWORD event) {
  if (event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT) return ++stops, TRUE;
  closed = true;
  Sleep(INFINITE);
  return TRUE;
}

}  // namespace

void accept_stop_signals() {}

StopInputs::StopInputs() {
  SetConsoleCtrlHandler(handle_control, TRUE);
  reads_terminal_ = _isatty(_fileno(stdin)) != 0;
}
StopInputs::~StopInputs() { SetConsoleCtrlHandler(handle_control, FALSE); }

StopInputs::Arrived StopInputs::wait(std::chrono::milliseconds timeout) {
  Arrived arrived;
  Sleep(static_cast<DWORD>(timeout.count()));
  arrived.stops = stops.exchange(0);
  arrived.hung_up = closed.exchange(false);
  if (reads_terminal_) read_keys(arrived);
  return arrived;
}

/// Arrows arrive as 0 or 0xE0 and a code: they become the sequences of other terminals.
void StopInputs::read_keys(Arrived& arrived) {
  while (_kbhit() != 0) {
    const int key = _getch();
    if (key != 0 && key != 0xE0) {
      arrived.bytes += static_cast<char>(key);
      continue;
    }
    const int code = _getch();
    const char* arrow = code == 72 ? "A" : code == 80 ? "B" : code == 77 ? "C" : code == 75 ? "D" : "~";
    arrived.bytes += std::string{"\x1b["} + arrow;
  }
}

void StopInputs::restore_terminal() {}
void StopInputs::exit_now(int exit_code) { std::_Exit(exit_code); }

}  // namespace tactus::app
#endif
