#include "apps/cli/stop_inputs.h"

#include <csignal>
#include <cstdlib>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace tactus::app {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGQUIT, SIGHUP, SIGPIPE, SIGTSTP};

// A process has one terminal and one handler of each signal.
termios terminal_before;
std::array<struct sigaction, kSignals.size()> handlers_before;
int signal_pipe[2] = {-1, -1};

extern "C" void forward_signal(int signal) {
  const auto byte = static_cast<char>(signal);
  [[maybe_unused]] const auto written = ::write(signal_pipe[1], &byte, 1);
}

/// A closed pipe is an error of a write, not the end; a program that is stopped by Ctrl-Z could not be
/// stopped any more.
bool is_ignored(int signal) { return signal == SIGPIPE || signal == SIGTSTP; }

void open_signal_pipe() {
  if (::pipe(signal_pipe) != 0) std::abort();
  for (const int end : signal_pipe) {
    ::fcntl(end, F_SETFL, O_NONBLOCK);
    ::fcntl(end, F_SETFD, FD_CLOEXEC);
  }
}

bool readable(int descriptor) {
  pollfd input{descriptor, POLLIN, 0};
  return ::poll(&input, 1, 0) > 0;
}

}  // namespace

StopInputs::StopInputs() {
  open_signal_pipe();
  for (std::size_t s = 0; s < kSignals.size(); ++s) {
    struct sigaction action {};
    action.sa_handler = is_ignored(kSignals[s]) ? SIG_IGN : forward_signal;
    action.sa_flags = SA_RESTART;
    ::sigaction(kSignals[s], &action, &handlers_before[s]);
  }
  if (::isatty(STDIN_FILENO) != 0) open_terminal();
}

StopInputs::~StopInputs() {
  restore_terminal();
  for (std::size_t s = 0; s < kSignals.size(); ++s) ::sigaction(kSignals[s], &handlers_before[s], nullptr);
  for (const int end : signal_pipe) ::close(end);
}

void StopInputs::open_terminal() {
  // A program in the background would be stopped where it reads.
  open_ = ::tcgetpgrp(STDIN_FILENO) == ::getpgrp();
  if (!open_ || ::tcgetattr(STDIN_FILENO, &terminal_before) != 0) return;
  terminal_ = true;
  auto raw = terminal_before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

void StopInputs::restore_terminal() {
  if (terminal_) ::tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
}

StopInputs::Arrived StopInputs::wait(std::chrono::milliseconds timeout) {
  Arrived arrived;
  pollfd inputs[] = {{signal_pipe[0], POLLIN, 0}, {STDIN_FILENO, POLLIN, 0}};
  (void)::poll(inputs, open_ ? 2 : 1, static_cast<int>(timeout.count()));
  char bytes[64];
  for (auto count = ::read(signal_pipe[0], bytes, sizeof bytes); count > 0;
       count = ::read(signal_pipe[0], bytes, sizeof bytes))
    for (int b = 0; b < count; ++b) {
      arrived.hung_up = arrived.hung_up || bytes[b] == SIGHUP;
      arrived.stops += bytes[b] == SIGHUP ? 0 : 1;
    }
  if (open_ && readable(STDIN_FILENO)) read_keys(arrived);
  return arrived;
}

void StopInputs::read_keys(Arrived& arrived) {
  char bytes[64];
  const auto count = ::read(STDIN_FILENO, bytes, sizeof bytes);
  if (count > 0) return void(arrived.bytes.assign(bytes, static_cast<std::size_t>(count)));
  if (count < 0 && (errno == EINTR || errno == EAGAIN)) return;
  open_ = false;
  arrived.hung_up = arrived.hung_up || terminal_;
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

StopInputs::StopInputs() {
  SetConsoleCtrlHandler(handle_control, TRUE);
  terminal_ = _isatty(_fileno(stdin)) != 0;
}
StopInputs::~StopInputs() { SetConsoleCtrlHandler(handle_control, FALSE); }

StopInputs::Arrived StopInputs::wait(std::chrono::milliseconds timeout) {
  Arrived arrived;
  Sleep(static_cast<DWORD>(timeout.count()));
  arrived.stops = stops.exchange(0);
  arrived.hung_up = closed.exchange(false);
  if (terminal_) read_keys(arrived);
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

void StopInputs::open_terminal() {}
void StopInputs::restore_terminal() {}
void StopInputs::exit_now(int exit_code) { std::_Exit(exit_code); }

}  // namespace tactus::app
#endif
