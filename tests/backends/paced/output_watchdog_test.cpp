#include "backends/paced/output_watchdog.h"

#include <catch2/catch.hpp>

using namespace tactus;
using namespace std::chrono_literals;

TEST_CASE("frame stall: reported once, when no frame came for the patience") {
  FrameStall stall{500ms};
  CHECK_FALSE(stall.observe(0, 0ms));
  CHECK_FALSE(stall.observe(0, 499ms));
  CHECK(stall.observe(0, 500ms));
  CHECK_FALSE(stall.observe(0, 501ms));
  CHECK_FALSE(stall.observe(1, 600ms));  // the next frame
  CHECK_FALSE(stall.observe(2, 1s));
  CHECK_FALSE(stall.observe(2, 1'499ms));
  CHECK(stall.observe(2, 1'500ms));
}

TEST_CASE("frame stall: time without expected frames does not count") {
  FrameStall stall{500ms};
  CHECK_FALSE(stall.observe(5, 0ms));
  stall.pause();
  CHECK_FALSE(stall.observe(5, 10s));
  CHECK(stall.observe(5, 10'500ms));
}

#if defined(__linux__)
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "tests/support/wait_until.h"

namespace {

/// An output that keeps its value, in memory of several processes; each time it comes to zero a byte is sent.
class KeptOutput {
 public:
  KeptOutput() {
    memory_ =
        mmap(nullptr, sizeof(std::atomic<int>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    REQUIRE(memory_ != MAP_FAILED);
    value = new (memory_) std::atomic<int>{0};
    REQUIRE(pipe(ends_) == 0);
  }
  ~KeptOutput() {
    close(ends_[0]);
    close_sender();
    munmap(memory_, sizeof(std::atomic<int>));
  }
  auto watchdog() {
    return OutputWatchdog::start(
        [](void* self) {
          auto* output = static_cast<KeptOutput*>(self);
          *output->value = 0;
          (void)!write(output->ends_[1], "z", 1);
        },
        this, {ends_[1]});
  }
  void close_sender() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }
  /// Bytes that can be read until one has come, or nobody can send any more.
  int next() const {
    char byte = 0;
    return static_cast<int>(read(ends_[0], &byte, 1));
  }

  std::atomic<int>* value = nullptr;

 private:
  void* memory_ = nullptr;
  int ends_[2] = {-1, -1};
};

}  // namespace

TEST_CASE("output watchdog: a program that is killed leaves its output at zero") {
  KeptOutput output;
  const pid_t program = fork();
  if (program == 0) {
    const auto watchdog = output.watchdog();
    if (!watchdog) _exit(1);
    (*watchdog)->frame();
    *output.value = 5;
    kill(getpid(), SIGKILL);
    _exit(2);
  }
  output.close_sender();
  CHECK(output.next() == 1);  // from the watchdog
  CHECK(*output.value == 0);
  CHECK(output.next() == 0);  // and it has ended
  int status = 0;
  REQUIRE(waitpid(program, &status, 0) == program);
  CHECK(WIFSIGNALED(status));
}

TEST_CASE("output watchdog: an output comes to zero when frames stay out, and once at the end") {
  KeptOutput output;
  {
    const auto watchdog = output.watchdog();
    REQUIRE(watchdog);
    CHECK((*watchdog)->alive());
    *output.value = 5;
    (*watchdog)->frame();
    (*watchdog)->expect_frames(true);
    CHECK(output.next() == 1);
    CHECK(*output.value == 0);
    *output.value = 6;  // the loop goes on
    (*watchdog)->expect_frames(false);
  }
  CHECK(*output.value == 0);
  output.close_sender();
  CHECK(output.next() == 1);
  CHECK(output.next() == 0);
}

TEST_CASE("output watchdog: its end is noticed") {
  const auto watchdog = OutputWatchdog::start([](void*) { _exit(1); }, nullptr, {});
  REQUIRE(watchdog);
  CHECK((*watchdog)->alive());
  (*watchdog)->expect_frames(true);  // and none comes
  CHECK(test::wait_until([&] { return !(*watchdog)->alive(); }));
}

TEST_CASE("output watchdog: signals to the program's group do not end it") {
  KeptOutput output;
  const pid_t program = fork();
  if (program == 0) {
    setpgid(0, 0);
    const auto watchdog = output.watchdog();
    if (!watchdog) _exit(1);
    *output.value = 5;
    kill(0, SIGKILL);
    _exit(2);
  }
  output.close_sender();
  CHECK(output.next() == 1);
  CHECK(*output.value == 0);
  int status = 0;
  REQUIRE(waitpid(program, &status, 0) == program);
}
#endif
