#include "apps/cli/stop_inputs.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <string>

#ifdef __linux__
#include <sys/syscall.h>
#endif

using namespace tactus;
using namespace tactus::app;
using namespace std::chrono_literals;

namespace {

/// Standard input is this file while it lives.
class StandardInput {
 public:
  explicit StandardInput(int file) : before_(::dup(STDIN_FILENO)) {
    ::dup2(file, STDIN_FILENO);
    ::close(file);
  }
  ~StandardInput() {
    ::dup2(before_, STDIN_FILENO);
    ::close(before_);
  }

 private:
  int before_;
};

/// Both ends of a connection; the first one is standard input.
class Connection {
 public:
  explicit Connection(int type) : other_end_(-1), input_(connect(type)) {}
  ~Connection() { close(); }
  void send(const std::string& bytes) const {
    REQUIRE(::send(other_end_, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  }
  void close() {
    if (other_end_ >= 0) ::close(other_end_);
    other_end_ = -1;
  }

 private:
  int connect(int type) {
    int ends[2] = {-1, -1};
    REQUIRE(::socketpair(AF_UNIX, type, 0, ends) == 0);
    other_end_ = ends[1];
    return ends[0];
  }

  int other_end_;
  StandardInput input_;
};

}  // namespace

TEST_CASE("stop inputs: a datagram without bytes is not the end, and the next one is read", "[live]") {
  Connection connection{SOCK_DGRAM};
  StopInputs inputs;
  for (int n = 0; n < 3; ++n) {
    connection.send("");
    connection.send("q");
    CHECK(inputs.wait(0ms).bytes.empty());
    CHECK(inputs.wait(0ms).bytes.empty());  // nothing came: it is not asked in this turn
    const auto arrived = inputs.wait(0ms);
    CHECK(arrived.bytes == "q");
    CHECK_FALSE(arrived.input_closed);
  }
}

TEST_CASE("stop inputs: a closed connection is reported once", "[live]") {
  const auto type = GENERATE(SOCK_STREAM, SOCK_SEQPACKET);
  Connection connection{type};
  StopInputs inputs;
  connection.send("m");
  CHECK(inputs.wait(0ms).bytes == "m");
  connection.close();
  CHECK(inputs.wait(0ms).input_closed);
  CHECK_FALSE(inputs.wait(0ms).input_closed);
}

TEST_CASE("stop inputs: what polls readable and cannot be read is asked in every other turn at most",
          "[live]") {
  const StandardInput input{::open("/dev/null", O_WRONLY)};
  StopInputs inputs;
  const auto begin = std::chrono::steady_clock::now();
  for (int turn = 0; turn < 10; ++turn) CHECK_FALSE(inputs.wait(20ms).input_closed);
  CHECK(std::chrono::steady_clock::now() - begin >= 5 * 20ms);
}

#if defined(__linux__)
/// This process gets a signal as if a fault of its own had caused it.
void fault(int signal) {
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  const StopInputs inputs;
  siginfo_t info{};
  info.si_signo = signal;
  info.si_code = 1;  // TRAP_BRKPT, SYS_SECCOMP
  ::syscall(SYS_rt_sigqueueinfo, ::getpid(), signal, &info);
  ::_exit(0);
}

TEST_CASE("stop inputs: a breakpoint or a forbidden system call ends the process, as without it", "[live]") {
  const auto signal = GENERATE(SIGTRAP, SIGSYS);
  const int child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) fault(signal);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == signal);
}
#endif

TEST_CASE("stop inputs: before there are any, signals that its parent had ignored or blocked end the process",
          "[live]") {
  const auto signal = GENERATE(SIGTERM, SIGINT, SIGHUP, SIGQUIT);
  const int child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::signal(signal, SIG_IGN);
    sigset_t blocked;
    sigfillset(&blocked);
    ::sigprocmask(SIG_BLOCK, &blocked, nullptr);
    accept_stop_signals();
    ::raise(signal);
    ::_exit(0);
  }
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
  CHECK(WTERMSIG(status) == signal);
}

TEST_CASE("stop inputs: a terminal that was closed before is reported, once", "[live]") {
  const int window = ::posix_openpt(O_RDWR | O_NOCTTY);
  REQUIRE(window >= 0);
  REQUIRE(::grantpt(window) == 0);
  REQUIRE(::unlockpt(window) == 0);
  const StandardInput terminal{::open(::ptsname(window), O_RDWR | O_NOCTTY)};
  ::close(window);
  StopInputs inputs;
  CHECK(inputs.wait(0ms).hung_up);
  CHECK_FALSE(inputs.wait(0ms).hung_up);
}

TEST_CASE("stop inputs: Ctrl-C that comes as a byte is a stop", "[live]") {
  Connection connection{SOCK_STREAM};
  StopInputs inputs;
  connection.send("m\x03");
  CHECK(inputs.wait(0ms).stops == 1);
  CHECK(inputs.wait(0ms).stops == 0);
}

TEST_CASE("stop inputs: where they can no longer be waited for, it is as if the terminal had been closed",
          "[live]") {
  Connection connection{SOCK_STREAM};
  StopInputs inputs;
  CHECK_FALSE(inputs.wait(0ms).hung_up);
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &before) == 0);
  rlimit none = before;
  none.rlim_cur = 1;  // poll(2): EINVAL for more files than that
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &none) == 0);
  const auto arrived = inputs.wait(0ms);
  REQUIRE(::setrlimit(RLIMIT_NOFILE, &before) == 0);
  CHECK(arrived.hung_up);
}
