// A JACK client for tests, in a process of its own (see tests/support/sound_server.h).
//   delay_client --hand NAME                                              changes other clients as asked
//   delay_client --card NAME CHANNELS DELAY GAIN NOISE IN_LATENCY OUT_LATENCY REVERSED HARDWARE
//     a sound card of known delay; REVERSED 1: its last channel's ports are registered first; HARDWARE: what
//     its driver calls it, as an alias of its ports; empty: none
// It says "ready" once the server answers, then answers each line of stdin until that ends.
#include <jack/jack.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <memory>
#include <numbers>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace std::chrono_literals;
constexpr int kTaps = 64;  // of the sinc that makes a fraction of a frame
constexpr std::size_t kRing = 1 << 17;

struct Channel {
  jack_port_t* playback = nullptr;
  jack_port_t* capture = nullptr;
  std::vector<float> ring = std::vector<float>(kRing);
};

struct Card {
  std::vector<Channel> channels;
  std::size_t whole_delay = 0;
  std::vector<double> taps;  ///< empty: a whole delay, which changes no bit
  double gain = 1.0, noise = 0.0;
  jack_nframes_t input_latency = 0, output_latency = 0;
  std::size_t written = 0;
  std::uint64_t seed = 1;
  std::atomic<int> sleep_ms{0};
  std::atomic<long> xruns{0};

  double received(const Channel& channel, std::size_t at) const {
    const auto frame = [&](std::size_t back) { return channel.ring[(at - back) & (kRing - 1)]; };
    if (taps.empty()) return static_cast<double>(frame(whole_delay));
    double sum = 0.0;
    for (std::size_t t = 0; t < taps.size(); ++t)
      sum += taps[t] * static_cast<double>(frame(whole_delay - kTaps / 2 + t));
    return sum;
  }
  double random() {
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(seed >> 11) / static_cast<double>(1ull << 52) - 1.0;
  }
};

/// sin(pi x) / (pi x) under a Blackman window, for x = n - kTaps / 2 - fraction. From 20 Hz to 20 kHz at 48
/// kHz its delay is right to 7e-5 frames, and to 5e-7 on average over a sweep.
std::vector<double> sinc(double fraction) {
  std::vector<double> taps;
  for (int n = 0; n <= kTaps; ++n) {
    const double x = n - kTaps / 2 - fraction;
    const double turn = 2 * std::numbers::pi * (x + kTaps / 2.0 + 1.0) / (kTaps + 2.0);
    const double window = 0.42 - 0.5 * std::cos(turn) + 0.08 * std::cos(2 * turn);
    taps.push_back(window * (x == 0.0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x)));
  }
  return taps;
}

int process(jack_nframes_t frames, void* of) {
  auto& card = *static_cast<Card*>(of);
  if (const int ms = card.sleep_ms.load(); ms > 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds{ms});
    card.sleep_ms = 0;
  }
  for (auto& channel : card.channels) {
    const auto* in = static_cast<const float*>(jack_port_get_buffer(channel.playback, frames));
    auto* out = static_cast<float*>(jack_port_get_buffer(channel.capture, frames));
    for (jack_nframes_t n = 0; n < frames; ++n) channel.ring[(card.written + n) & (kRing - 1)] = in[n];
    for (jack_nframes_t n = 0; n < frames; ++n) {
      const double noise = card.noise > 0.0 ? card.noise * card.random() : 0.0;
      out[n] = static_cast<float>(card.gain * card.received(channel, card.written + n) + noise);
    }
  }
  card.written += frames;
  return 0;
}

void tell_latency(jack_latency_callback_mode_t mode, void* of) {
  const auto& card = *static_cast<Card*>(of);
  const auto frames = mode == JackCaptureLatency ? card.input_latency : card.output_latency;
  jack_latency_range_t range{frames, frames};
  for (const auto& channel : card.channels)
    jack_port_set_latency_range(mode == JackCaptureLatency ? channel.capture : channel.playback, mode,
                                &range);
}

jack_client_t* open(const char* name) {
  jack_set_error_function([](const char*) {});
  jack_set_info_function([](const char*) {});
  const auto deadline = std::chrono::steady_clock::now() + 8s;
  while (std::chrono::steady_clock::now() < deadline && ::getppid() != 1) {
    const auto options = static_cast<jack_options_t>(JackNoStartServer | JackUseExactName);
    if (auto* client = jack_client_open(name, options, nullptr)) return client;
    std::this_thread::sleep_for(10ms);
  }
  std::exit(1);
}

bool make_card(jack_client_t* client, Card& card, char** arguments) {
  card.channels.resize(std::strtoul(arguments[0], nullptr, 10));
  const double delay = std::atof(arguments[1]);
  card.whole_delay = static_cast<std::size_t>(delay);
  if (delay != std::floor(delay)) card.taps = sinc(delay - std::floor(delay));
  card.gain = std::atof(arguments[2]);
  card.noise = std::atof(arguments[3]);
  card.input_latency = static_cast<jack_nframes_t>(std::atoi(arguments[4]));
  card.output_latency = static_cast<jack_nframes_t>(std::atoi(arguments[5]));
  const bool reversed = std::atoi(arguments[6]) != 0;
  const std::string hardware = arguments[7];
  for (std::size_t n = 0; n < card.channels.size(); ++n) {
    const auto c = reversed ? card.channels.size() - 1 - n : n;
    const auto port = [&](const char* kind, unsigned long direction) {
      const auto name = kind + std::to_string(c + 1);
      auto* made = jack_port_register(client, name.c_str(), JACK_DEFAULT_AUDIO_TYPE, direction, 0);
      if (made != nullptr && !hardware.empty()) jack_port_set_alias(made, (hardware + ":" + name).c_str());
      return made;
    };
    card.channels[c].capture = port("capture_", JackPortIsOutput);
    card.channels[c].playback = port("playback_", JackPortIsInput);
    if (card.channels[c].capture == nullptr || card.channels[c].playback == nullptr) return false;
  }
  jack_set_process_callback(client, process, &card);
  jack_set_latency_callback(client, tell_latency, &card);
  jack_set_xrun_callback(
      client,
      [](void* of) {
        ++static_cast<Card*>(of)->xruns;
        return 0;
      },
      &card);
  return jack_activate(client) == 0;
}

std::vector<std::string> connections(jack_client_t* client, const std::string& name) {
  std::vector<std::string> found;
  const auto* port = jack_port_by_name(client, name.c_str());
  const char** others = port == nullptr ? nullptr : jack_port_get_all_connections(client, port);
  for (const char** other = others; other != nullptr && *other != nullptr; ++other)
    found.emplace_back(*other);
  jack_free(others);
  return found;
}

bool disconnect(jack_client_t* client, const std::string& other) {
  const char** ports = jack_get_ports(client, ("^" + other + ":").c_str(), nullptr, 0);
  if (ports == nullptr) return false;
  for (const char** port = ports; *port != nullptr; ++port)
    jack_port_disconnect(client, jack_port_by_name(client, *port));
  jack_free(ports);
  return true;
}

/// The server tells of the gap a little later, if there was one.
void sleep_once(Card& card, int ms) {
  const long before = card.xruns;
  card.sleep_ms = ms;
  while (card.sleep_ms > 0) std::this_thread::sleep_for(1ms);
  for (int wait = 0; wait < 500 && card.xruns == before; ++wait) std::this_thread::sleep_for(1ms);
}

bool answer(jack_client_t* client, Card& card, const std::string& line) {
  std::istringstream words{line};
  std::string what, first, second;
  words >> what >> first >> second;
  if (what == "sleep") return sleep_once(card, std::stoi(first)), true;
  if (what == "period")
    return jack_set_buffer_size(client, static_cast<jack_nframes_t>(std::stoi(first))) == 0;
  if (what == "freewheel") return jack_set_freewheel(client, std::stoi(first)) == 0;
  if (what == "connect") return jack_connect(client, first.c_str(), second.c_str()) == 0;
  if (what == "disconnect") return disconnect(client, first);
  if (what == "connections")
    for (const auto& other : connections(client, first)) std::cout << other << "\n";
  return what == "connections";
}

}  // namespace

int main(int count, char** arguments) {
  const bool is_card = count == 11 && std::strcmp(arguments[1], "--card") == 0;
  if (!is_card && (count != 3 || std::strcmp(arguments[1], "--hand") != 0)) return 2;
  jack_client_t* client = open(arguments[2]);
  Card card;
  jack_on_info_shutdown(
      client, [](jack_status_t, const char*, void*) { std::_Exit(0); }, nullptr);
  if (is_card && !make_card(client, card, arguments + 3)) return 1;
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    if (line == "xruns")
      std::cout << card.xruns << std::endl;
    else
      std::cout << (answer(client, card, line) ? "done" : "failed") << std::endl;
  }
  jack_client_close(client);
}
