#include "apps/play/live/controls/keyboard.h"

#include <thread>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

namespace tactus::app {

struct Keyboard::Terminal {
  bool open = false;
  bool ended = false;
  termios before{};

  bool readable(std::chrono::milliseconds timeout) const {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    return poll(&input, 1, static_cast<int>(timeout.count())) > 0;
  }
  std::optional<char> next() {
    char c = 0;
    if (::read(STDIN_FILENO, &c, 1) == 1) return c;
    ended = true;
    return std::nullopt;
  }
};

Keyboard::Keyboard() : terminal_(std::make_unique<Terminal>()) {
  auto& terminal = *terminal_;
  if (isatty(STDIN_FILENO) == 0) return;
  if (tcgetpgrp(STDIN_FILENO) != getpgrp()) {  // in the background reading would stop the program
    terminal.ended = true;
    return;
  }
  if (tcgetattr(STDIN_FILENO, &terminal.before) != 0) return;
  terminal.open = true;
  auto raw = terminal.before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VSUSP] = _POSIX_VDISABLE;  // a program that is stopped leaves its drives where they are
  raw.c_cc[VMIN] = 1;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
}

Keyboard::~Keyboard() {
  if (terminal_->open) tcsetattr(STDIN_FILENO, TCSANOW, &terminal_->before);
}

bool Keyboard::is_terminal() const { return terminal_->open; }

std::optional<char> Keyboard::wait(std::chrono::milliseconds timeout) {
  if (terminal_->ended) {
    std::this_thread::sleep_for(timeout);
    return std::nullopt;
  }
  if (!terminal_->readable(timeout)) return std::nullopt;
  const auto first = terminal_->next();
  // Arrows come as ESC [ A … D, all at once; an Escape comes alone.
  constexpr std::chrono::milliseconds kRest{20};
  if (first != '\x1b' || !terminal_->readable(kRest) || terminal_->next() != '[' ||
      !terminal_->readable(kRest))
    return first;
  constexpr char kArrows[] = {kUpKey, kDownKey, kRightKey, kLeftKey};
  const char last = terminal_->next().value_or(0);
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

struct Keyboard::Terminal {};
Keyboard::Keyboard() = default;
Keyboard::~Keyboard() = default;
bool Keyboard::is_terminal() const { return false; }
std::optional<char> Keyboard::wait(std::chrono::milliseconds timeout) {
  std::this_thread::sleep_for(timeout);
  return std::nullopt;
}
void open_standard_streams() {}
int terminal_columns() { return 0; }

}  // namespace tactus::app
#endif
