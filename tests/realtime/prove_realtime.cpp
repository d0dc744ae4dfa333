// Calls back everything that Tactus ships, on a thread of its own, while another thread moves the controls,
// and counts what the audio thread asks of the heap and of the kernel. Exit code 0: nothing. 1: something.
//   prove_realtime [callbacks = 10000000] [frames = 16] [break = nothing | heap | system-call]
// With a third argument it breaks the promise itself in the last callback of each, to show that it is seen.

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/realtime/subjects.h"
#include "tests/realtime/watch.h"

namespace {

using namespace tactus::realtime;

enum class Break { Nothing, Heap, SystemCall };

struct Run {
  bool trapped = false;
  Asked asked;
};

/// malloc through a pointer that the compiler cannot see through, or it would leave both calls out.
void break_promise(Break what) {
  static void* (*volatile allocate)(std::size_t) = std::malloc;
  if (what == Break::Heap) std::free(allocate(8));
  if (what == Break::SystemCall) (void)getppid();
}

Run on_audio_thread(Subject& subject, long callbacks, Break broken) {
  Run run;
  run.trapped = set_trap();
  for (long n = 0; n < callbacks; ++n) {
    subject.await();
    watch();
    subject.callback();
    if (n + 1 == callbacks) break_promise(broken);
    look_away();
  }
  run.asked = asked();
  return run;
}

Run prove(Subject& subject, long callbacks, Break broken) {
  Run run;
  std::atomic<bool> done{false};
  std::thread audio{[&] {
    run = on_audio_thread(subject, callbacks, broken);
    done = true;
  }};
  std::mt19937 random{1};
  while (!done) {
    subject.disturb(random);
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  audio.join();
  return run;
}

int threads() {
  int count = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task"))
    count += task.exists() ? 1 : 0;
  return count;
}

void print(const std::string& name, long callbacks, const Asked& asked, long edits) {
  std::printf("  %-20s %12ld %12ld %14ld %8ld\n", name.c_str(), callbacks, asked.heap_calls,
              asked.system_calls, edits);
}

int run(long callbacks, int frames, Break broken) {
  const auto subjects = all_subjects(TACTUS_SOURCE_DIR "/instruments", frames);
  const int started = threads() - 1;
  std::printf("%zu subjects, blocks of %d frames; threads that they started: %d\n\n", subjects.size(), frames,
              started);
  std::printf("  %-20s %12s %12s %14s %8s\n", "", "callbacks", "heap calls", "system calls", "edits");
  Asked all;
  long left = callbacks, edits = 0;
  for (std::size_t i = 0; i < subjects.size(); ++i) {
    const long share = left / static_cast<long>(subjects.size() - i);
    left -= share;
    const auto result = prove(*subjects[i], share, broken);
    if (!result.trapped)
      return std::fprintf(stderr, "this kernel cannot trap system calls (Linux 5.11 can)\n"), 2;
    print(subjects[i]->name, share, result.asked, subjects[i]->edits());
    edits += subjects[i]->edits();
    all.heap_calls += result.asked.heap_calls;
    all.system_calls += result.asked.system_calls;
    if (result.asked.system_calls > 0) all.last_system_call = result.asked.last_system_call;
  }
  print("all", callbacks, all, edits);
  if (all.system_calls > 0) std::printf("  the last system call was number %ld\n", all.last_system_call);
  return all.heap_calls + all.system_calls + started == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  const long callbacks = argc > 1 ? std::atol(argv[1]) : 10'000'000;
  const int frames = argc > 2 ? std::atoi(argv[2]) : 16;
  const std::string broken = argc > 3 ? argv[3] : "nothing";
  try {
    return run(callbacks, frames,
               broken == "heap"          ? Break::Heap
               : broken == "system-call" ? Break::SystemCall
                                         : Break::Nothing);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "prove_realtime: %s\n", error.what());
    return 2;
  }
}
