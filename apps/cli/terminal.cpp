#include "apps/cli/terminal.h"

#include <cerrno>
#include <cstdio>

#if defined(__unix__) || defined(__APPLE__)
#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace tactus::app {

void open_standard_streams() {
  int stream = 0;
  while (stream >= 0 && stream <= STDERR_FILENO) stream = open("/dev/null", O_RDWR);
  if (stream > STDERR_FILENO) close(stream);
}

static int terminal_size(unsigned short winsize::*of, int otherwise) {
  if (isatty(STDERR_FILENO) == 0) return 0;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.*of > 0 ? size.*of : otherwise;
}

int terminal_columns() { return terminal_size(&winsize::ws_col, 80); }
int terminal_rows() { return terminal_size(&winsize::ws_row, 24); }

bool write_to_stderr(std::string_view text) noexcept {
  while (!text.empty()) {
    const auto written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written > 0) {
      text.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno == EAGAIN) {
      pollfd output{STDERR_FILENO, POLLOUT, 0};
      (void)poll(&output, 1, -1);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

}  // namespace tactus::app
#else
namespace tactus::app {

void open_standard_streams() {}
int terminal_columns() { return 0; }
int terminal_rows() { return 0; }
bool write_to_stderr(std::string_view text) noexcept {
  return std::fwrite(text.data(), 1, text.size(), stderr) == text.size();
}

}  // namespace tactus::app
#endif
