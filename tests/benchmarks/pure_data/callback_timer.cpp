// A library to be loaded before a JACK client (LD_PRELOAD): it times the client's process callback from entry
// to exit, the same for every program. $TACTUS_CALLBACK_SECONDS after the first callback (the first second
// does not count) it writes to $TACTUS_CALLBACK_TIMES how many there were, and their median, 99.9th
// percentile and worst in microseconds.
#include <dlfcn.h>
#include <jack/jack.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMost = 1 << 20;

struct Timer {
  JackProcessCallback callback = nullptr;
  void* argument = nullptr;
  std::atomic<bool> counting{false};
  std::atomic<std::size_t> count{0};
  std::vector<float> microseconds = std::vector<float>(kMost);
};

/// Never destroyed: the server's thread may call until the very end.
Timer& timer() {
  static auto* one = new Timer;
  return *one;
}

int timed(jack_nframes_t frames, void*) {
  auto& t = timer();
  const auto begin = Clock::now();
  const int result = t.callback(frames, t.argument);
  const std::chrono::duration<float, std::micro> took = Clock::now() - begin;
  if (!t.counting.load()) return result;
  if (const auto n = t.count.fetch_add(1); n < kMost) t.microseconds[n] = took.count();
  return result;
}

void write(const std::string& file) {
  auto& t = timer();
  t.counting = false;
  std::vector<float> times(t.microseconds.begin(),
                           t.microseconds.begin() + static_cast<long>(std::min(t.count.load(), kMost)));
  if (times.empty()) return;
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return static_cast<double>(
        times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))]);
  };
  if (std::FILE* out = std::fopen(file.c_str(), "w"); out != nullptr) {
    std::fprintf(out, "%zu %.2f %.2f %.2f\n", times.size(), at(0.5), at(0.999), at(1.0));
    std::fclose(out);
  }
}

}  // namespace

extern "C" int jack_set_process_callback(jack_client_t* client, JackProcessCallback callback,
                                         void* argument) {
  using Set = int (*)(jack_client_t*, JackProcessCallback, void*);
  const auto set = reinterpret_cast<Set>(dlsym(RTLD_NEXT, "jack_set_process_callback"));
  auto& t = timer();
  const bool first = t.callback == nullptr;
  t.callback = callback;
  t.argument = argument;
  const char* file = std::getenv("TACTUS_CALLBACK_TIMES");
  const char* seconds = std::getenv("TACTUS_CALLBACK_SECONDS");
  if (first && file != nullptr && seconds != nullptr)
    std::thread{[path = std::string{file}, length = std::atof(seconds)] {
      std::this_thread::sleep_for(std::chrono::seconds{1});
      timer().counting = true;
      std::this_thread::sleep_for(std::chrono::duration<double>{length});
      write(path);
    }}.detach();
  return set(client, timed, nullptr);
}
