#include "tests/support/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <thread>
#ifdef __linux__
#include <sys/prctl.h>
#endif

namespace tactus::test {
namespace {

/// A file without a name, open for both programs.
int nameless_file() {
  std::FILE* file = std::tmpfile();
  if (file == nullptr) return -1;
  const int kept = ::fcntl(::fileno(file), F_DUPFD_CLOEXEC, 0);
  std::fclose(file);
  return kept;
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command, Stdout out, int stderr_to) {
  std::vector<char*> arguments;
  for (const auto& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int ends[2] = {-1, -1};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) std::abort();
  log_ = nameless_file();
  socket_ = ends[0];
  pid_ = ::fork();
  if (pid_ < 0) std::abort();
  if (pid_ == 0) {  // only calls that are safe between fork and exec
#ifdef __linux__
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    ::dup2(ends[1], STDIN_FILENO);
    ::dup2(out == Stdout::Read ? ends[1] : log_, STDOUT_FILENO);
    ::dup2(stderr_to < 0 ? log_ : stderr_to, STDERR_FILENO);
    ::execvp(arguments[0], arguments.data());
    ::_exit(kCannotRun);
  }
  ::close(ends[1]);
}

ChildProcess::~ChildProcess() {
  kill();
  ::close(socket_);
  ::close(log_);
}

bool ChildProcess::running() { return !wait(std::chrono::milliseconds{0}); }

void ChildProcess::send(int signal) const {
  if (!ended_ && pid_ > 0) ::kill(pid_, signal);
}

void ChildProcess::pause() const {
  send(SIGSTOP);
  siginfo_t state;
  ::waitid(P_PID, static_cast<id_t>(pid_), &state, WSTOPPED | WEXITED | WNOWAIT);
}

std::optional<int> ChildProcess::wait(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  while (!ended_) {
    int status = 0;
    if (::waitpid(pid_, &status, WNOHANG) == pid_)
      ended_ = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
    else if (std::chrono::steady_clock::now() >= deadline)
      return std::nullopt;
    else
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
  }
  return ended_;
}

int ChildProcess::terminate() {
  send(SIGTERM);
  if (!wait(std::chrono::seconds{3})) kill();
  return *ended_;
}

void ChildProcess::hang_up() const { ::shutdown(socket_, SHUT_WR); }

void ChildProcess::kill() {
  send(SIGKILL);
  wait(std::chrono::seconds{10});
}

bool ChildProcess::type(const std::string& bytes) const {
  return ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
}

std::string ChildProcess::hear(std::chrono::milliseconds patience) {
  const auto deadline = std::chrono::steady_clock::now() + patience;
  for (;;) {
    if (const auto end = unread_.find('\n'); end != std::string::npos) {
      auto line = unread_.substr(0, end);
      unread_.erase(0, end + 1);
      return line;
    }
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now());
    pollfd readable{socket_, POLLIN, 0};
    if (left.count() <= 0 || ::poll(&readable, 1, static_cast<int>(left.count())) <= 0) return "";
    char bytes[512];
    const auto count = ::read(socket_, bytes, sizeof bytes);
    if (count <= 0) return "";
    unread_.append(bytes, static_cast<std::size_t>(count));
  }
}

// `pread`: both programs share the place that `read` would move.
std::string ChildProcess::log() const {
  std::string text;
  char bytes[4096];
  for (ssize_t count = 0; (count = ::pread(log_, bytes, sizeof bytes, static_cast<off_t>(text.size()))) > 0;)
    text.append(bytes, static_cast<std::size_t>(count));
  return text;
}

}  // namespace tactus::test
