#include "apps/play/live/controls/keyboard.h"

#include <thread>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

namespace tactus::app {
namespace {

termios terminal_before;  // as it was: a process has only one

bool readable(std::chrono::milliseconds timeout) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  return poll(&input, 1, static_cast<int>(timeout.count())) > 0;
}

}  // namespace

Keyboard::Keyboard() {
  if (isatty(STDIN_FILENO) == 0) return;
  ended_ = tcgetpgrp(STDIN_FILENO) != getpgrp();  // in the background reading would stop the program
  if (ended_ || tcgetattr(STDIN_FILENO, &terminal_before) != 0) return;
  open_ = true;
  auto raw = terminal_before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;  // a program that is stopped leaves its drives where they are
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (open_) tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
}

std::optional<char> Keyboard::next() {
  char c = 0;
  if (::read(STDIN_FILENO, &c, 1) == 1) return c;
  ended_ = true;
  return std::nullopt;
}

std::optional<char> Keyboard::wait(std::chrono::milliseconds timeout) {
  if (ended_) {
    std::this_thread::sleep_for(timeout);
    return std::nullopt;
  }
  if (!readable(timeout)) return std::nullopt;
  const auto first = next();
  // Arrows come as ESC [ A … D, all at once; an Escape comes alone.
  constexpr std::chrono::milliseconds kRest{20};
  if (first != '\x1b' || !readable(kRest) || next() != '[' || !readable(kRest)) return first;
  constexpr char kArrows[] = {kUpKey, kDownKey, kRightKey, kLeftKey};
  const char last = next().value_or(0);
  return last >= 'A' && last <= 'D' ? kArrows[last - 'A'] : *first;
}

void open_standard_streams() {
  int stream = 0;
  while (stream >= 0 && stream <= STDERR_FILENO) stream = open("/dev/null", O_RDWR);
  if (stream > STDERR_FILENO) close(stream);
}

int terminal_columns() {
  if (isatty(STDERR_FILENO) == 0) return 0;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace tactus::app
#else
namespace tactus::app {

Keyboard::Keyboard() = default;
Keyboard::~Keyboard() = default;
std::optional<char> Keyboard::wait(std::chrono::milliseconds timeout) {
  std::this_thread::sleep_for(timeout);
  return std::nullopt;
}
void open_standard_streams() {}
int terminal_columns() { return 0; }

}  // namespace tactus::app
#endif
