// A JACK client that checks every sample which another client plays, in a process of its own (see
// scripts/soak).
//   port_watch CLIENT CHANNELS CEILING SLEW
// It listens to CLIENT:out_1, out_2, … whenever they are there, also of a server that was killed and started
// again, and plays hits and noise into CLIENT:in_1, …. Every second it prints a line of JSON; at once, each
// violation:
//   {"violation": "ceiling", "value": 0.51, "channel": 1, "frame": 4711}     above CEILING, full scale = 1
//   "slew"      a step of more than SLEW full scales a second on the first channel, also where the other
//   client
//               goes away; not where JACK stood still for longer than 0.2 s: what a card plays then is its
//               own
//   "disarmed"  sound while stdin's last line was "disarmed"; "armed" allows it again
// It ends with its stdin.
#include <fcntl.h>
#include <jack/jack.h>
#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace std::chrono_literals;
constexpr double kRounding = 1e-6;  // of doubles that were turned into floats
constexpr double kSilence = 1e-9;

enum Violation { Ceiling, Slew, Disarmed, kViolations };
constexpr const char* kNames[kViolations] = {"ceiling", "slew", "disarmed"};

/// The worst of one kind since it was last read.
struct Worst {
  std::atomic<double> value{0.0};
  std::atomic<long> count{0};
  std::atomic<int> channel{0};
  std::atomic<std::uint32_t> frame{0};

  void raise(double by, int of, std::uint32_t at) {
    ++count;
    if (by <= value) return;
    value = by, channel = of, frame = at;
  }
};

struct Watch {
  std::string client;
  int channels = 0;
  double ceiling = 1.0, slew = 0.0;
  jack_client_t* handle = nullptr;
  std::vector<jack_port_t*> heard, played;
  std::vector<double> last;
  bool continues = false;  ///< `last` is of the frame before this block
  std::uint32_t next_frame = 0;
  std::chrono::steady_clock::time_point last_block;
  std::uint64_t seed = 1;
  double rate = 48000.0, hit = 0.0;
  std::atomic<bool> armed{true}, lost{false}, freewheels{false};
  std::atomic<double> peak{0.0}, steepest{0.0};
  std::atomic<long> frames{0};
  Worst worst[kViolations];

  double random() {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(seed >> 11) / static_cast<double>(1ull << 52) - 1.0;
  }

  void check(int channel, double sample, std::uint32_t frame, bool follows) {
    auto& before = last[static_cast<std::size_t>(channel)];
    const double step = follows ? std::abs(sample - before) * rate : 0.0;
    before = sample;
    if (std::abs(sample) > peak) peak = std::abs(sample);
    if (channel == 0 && step > steepest) steepest = step;
    if (!(std::abs(sample) <= ceiling + kRounding))
      worst[Ceiling].raise(std::abs(sample), channel + 1, frame);
    if (channel == 0 && !(step <= slew + kRounding * rate)) worst[Slew].raise(step, channel + 1, frame);
    if (!armed && std::abs(sample) > kSilence) worst[Disarmed].raise(std::abs(sample), channel + 1, frame);
  }

  void listen(jack_nframes_t count) {
    const auto now = jack_last_frame_time(handle);
    const auto time = std::chrono::steady_clock::now();
    const bool follows = continues && now == next_frame && !freewheels && time - last_block <= 200ms;
    last_block = time;
    for (int c = 0; c < channels; ++c) {
      const auto* in =
          static_cast<const float*>(jack_port_get_buffer(heard[static_cast<std::size_t>(c)], count));
      for (jack_nframes_t n = 0; n < count; ++n)
        check(c, static_cast<double>(in[n]), now + n, follows || n > 0);
    }
    continues = true;
    next_frame = now + count;
    frames += count;
  }

  /// Noise, and a decaying hit now and then.
  void play(jack_nframes_t count) {
    for (auto* port : played) {
      auto* out = static_cast<float*>(jack_port_get_buffer(port, count));
      for (jack_nframes_t n = 0; n < count; ++n) {
        if (random() > 1.0 - 2.0 / rate) hit = 1.0;
        out[n] = static_cast<float>((hit + 1e-3) * random());
        hit *= 0.999;
      }
    }
  }

  bool open() {
    handle = jack_client_open("port-watch", JackNoStartServer, nullptr);
    if (handle == nullptr) return false;
    lost = continues = false;
    heard.clear(), played.clear();
    last.assign(static_cast<std::size_t>(channels), 0.0);
    rate = jack_get_sample_rate(handle);
    for (int c = 1; c <= channels; ++c) {
      heard.push_back(jack_port_register(handle, ("heard_" + std::to_string(c)).c_str(),
                                         JACK_DEFAULT_AUDIO_TYPE, JackPortIsInput, 0));
      played.push_back(jack_port_register(handle, ("played_" + std::to_string(c)).c_str(),
                                          JACK_DEFAULT_AUDIO_TYPE, JackPortIsOutput, 0));
    }
    jack_set_process_callback(
        handle,
        [](jack_nframes_t count, void* of) {
          static_cast<Watch*>(of)->listen(count);
          static_cast<Watch*>(of)->play(count);
          return 0;
        },
        this);
    jack_set_freewheel_callback(
        handle, [](int on, void* of) { static_cast<Watch*>(of)->freewheels = on != 0; }, this);
    jack_on_shutdown(
        handle, [](void* of) { static_cast<Watch*>(of)->lost = true; }, this);
    if (jack_activate(handle) == 0) return true;
    jack_client_close(handle);
    return false;
  }

  void connect() {
    for (int c = 0; c < channels; ++c) {
      const auto number = std::to_string(c + 1);
      const auto from = client + ":out_" + number, to = client + ":in_" + number;
      const auto at = static_cast<std::size_t>(c);
      if (jack_port_by_name(handle, from.c_str()) != nullptr)
        jack_connect(handle, from.c_str(), jack_port_name(heard[at]));
      if (jack_port_by_name(handle, to.c_str()) != nullptr)
        jack_connect(handle, jack_port_name(played[at]), to.c_str());
    }
  }
};

void report(Watch& watch) {
  std::printf("{\"frames\": %ld, \"peak\": %.6f, \"steepest\": %.1f}\n", watch.frames.load(),
              watch.peak.exchange(0.0), watch.steepest.exchange(0.0));
}

void report_violations(Watch& watch) {
  for (int kind = 0; kind < kViolations; ++kind) {
    auto& worst = watch.worst[kind];
    if (worst.count.load() == 0) continue;
    std::printf(
        "{\"violation\": \"%s\", \"value\": %.9g, \"channel\": %d, \"frame\": %u, \"samples\": %ld}\n",
        kNames[kind], worst.value.exchange(0.0), worst.channel.load(), worst.frame.load(),
        worst.count.exchange(0));
  }
}

/// False: stdin has ended.
bool read_orders(Watch& watch) {
  static std::string text;
  pollfd input{STDIN_FILENO, POLLIN, 0};
  while (poll(&input, 1, 0) > 0) {
    char c = 0;
    if (read(STDIN_FILENO, &c, 1) != 1) return false;
    if (c != '\n') {
      text += c;
      continue;
    }
    watch.armed = text == "armed";
    text.clear();
  }
  return true;
}

}  // namespace

int main(int count, char** arguments) {
  if (count != 5) return std::fprintf(stderr, "port_watch CLIENT CHANNELS CEILING SLEW\n"), 2;
  jack_set_error_function([](const char*) {});
  jack_set_info_function([](const char*) {});
  Watch watch;
  watch.client = arguments[1];
  watch.channels = std::atoi(arguments[2]);
  watch.ceiling = std::atof(arguments[3]);
  watch.slew = std::atof(arguments[4]);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  auto reported = std::chrono::steady_clock::now();
  while (read_orders(watch)) {
    if (watch.lost && watch.handle != nullptr) {
      jack_client_close(watch.handle);
      watch.handle = nullptr;
    }
    if (watch.handle == nullptr && !watch.open()) watch.handle = nullptr;
    if (watch.handle != nullptr) watch.connect();
    report_violations(watch);
    if (const auto now = std::chrono::steady_clock::now(); now - reported >= 1s) {
      reported = now;
      report(watch);
    }
    std::this_thread::sleep_for(20ms);
  }
  if (watch.handle != nullptr) jack_client_close(watch.handle);
  report_violations(watch);
}
