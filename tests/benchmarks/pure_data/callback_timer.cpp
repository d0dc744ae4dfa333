// A library to be loaded before a JACK client (LD_PRELOAD): it times the client's process callback from entry to
// exit, the same for every program, and writes at its end to $TACTUS_CALLBACK_TIMES: how many callbacks, and their
// median, 99.9th percentile and worst in microseconds. $TACTUS_CALLBACK_SKIP callbacks at the beginning do not count.
#include <dlfcn.h>
#include <jack/jack.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

constexpr std::size_t kMost = 1 << 20;

struct Timer {
  JackProcessCallback callback = nullptr;
  void* argument = nullptr;
  long skip = 0;
  std::vector<float> microseconds = std::vector<float>(kMost);
  std::atomic<std::size_t> count{0};

  ~Timer() {
    const char* file = std::getenv("TACTUS_CALLBACK_TIMES");
    const auto counted = std::min(count.load(), kMost);
    std::FILE* out = file != nullptr && counted > 0 ? std::fopen(file, "w") : nullptr;
    if (out == nullptr) return;
    microseconds.resize(counted);
    std::sort(microseconds.begin(), microseconds.end());
    const auto at = [&](double share) {
      return static_cast<double>(microseconds[static_cast<std::size_t>(share * static_cast<double>(counted - 1))]);
    };
    std::fprintf(out, "%zu %.2f %.2f %.2f\n", counted, at(0.5), at(0.999), at(1.0));
    std::fclose(out);
  }
};

Timer& timer() {
  static Timer one;
  return one;
}

int timed(jack_nframes_t frames, void*) {
  auto& t = timer();
  const auto begin = std::chrono::steady_clock::now();
  const int result = t.callback(frames, t.argument);
  const std::chrono::duration<float, std::micro> took = std::chrono::steady_clock::now() - begin;
  if (t.skip > 0) {
    --t.skip;
  } else if (const auto n = t.count.fetch_add(1); n < kMost) {
    t.microseconds[n] = took.count();
  }
  return result;
}

}  // namespace

extern "C" int jack_set_process_callback(jack_client_t* client, JackProcessCallback callback, void* argument) {
  using Set = int (*)(jack_client_t*, JackProcessCallback, void*);
  const auto set = reinterpret_cast<Set>(dlsym(RTLD_NEXT, "jack_set_process_callback"));
  auto& t = timer();
  t.callback = callback;
  t.argument = argument;
  if (const char* skip = std::getenv("TACTUS_CALLBACK_SKIP")) t.skip = std::atol(skip);
  return set(client, timed, nullptr);
}
