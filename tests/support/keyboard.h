#pragma once

#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <utility>

namespace tactus::test {

/// Standard input of this process while it lives. POSIX only.
class Keyboard {
 public:
  Keyboard() : before_(::dup(STDIN_FILENO)) {
    if (::socketpair(AF_UNIX, SOCK_STREAM, 0, ends_) != 0) std::abort();
    ::dup2(ends_[0], STDIN_FILENO);
  }
  ~Keyboard() {
    ::dup2(before_, STDIN_FILENO);
    for (const int file : {before_, ends_[0], ends_[1]})
      if (file >= 0) ::close(file);
  }
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  void close() { ::close(std::exchange(ends_[1], -1)); }
  void press(char key) const {
    if (::send(ends_[1], &key, 1, 0) != 1) std::abort();
  }

 private:
  int before_;
  int ends_[2] = {-1, -1};
};

}  // namespace tactus::test
