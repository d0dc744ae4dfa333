// MIDI messages of a real program on a real server.
#include <jack/jack.h>
#include <jack/midiport.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "engine/core/spsc_queue.h"
#include "tests/cards/jack/playing.h"

using namespace tactus;
using test::OnServer;
using test::Playing;
using test::wait_until;

namespace {

/// `beat` triggers 20 times a second; without a level it has the highest velocity.
const std::string kBeat = R"(format = 1
name = "beat"
[controls]
rate = { value = "20 Hz", range = ["1 Hz", "40 Hz"], smooth = "0 ms" }
level = { value = 0.1, range = [0, 0.2] }
[nodes]
beat = { type = "clock", tempo = "rate" }
bump = { type = "decay", trigger = "beat", time = "5 ms" }
[outputs]
tone = { from = "level * bump", kind = "audio" }
)";

struct Received {
  jack_nframes_t frame = 0;
  std::array<std::uint8_t, 3> bytes{};
};

/// A JACK client with one MIDI input.
class Module {
 public:
  Module() {
    REQUIRE(wait_until([&] { return joins(); }));
  }
  ~Module() { jack_client_close(client_); }
  bool connect(const std::string& from) {
    return wait_until([&] {
      const int result = jack_connect(client_, from.c_str(), jack_port_name(port_));
      return result == 0 || result == EEXIST;
    });
  }
  std::vector<Received> take() {
    for (Received message; queue_.pop(message);) all_.push_back(message);
    return all_;
  }
  double seconds(jack_nframes_t frames) const {
    return frames / static_cast<double>(jack_get_sample_rate(client_));
  }

 private:
  bool joins() {
    client_ = jack_client_open("module", static_cast<jack_options_t>(JackNoStartServer | JackUseExactName),
                               nullptr);
    if (client_ == nullptr) return false;
    port_ = jack_port_register(client_, "in", JACK_DEFAULT_MIDI_TYPE, JackPortIsInput, 0);
    jack_set_process_callback(client_, process, this);
    if (port_ != nullptr && jack_activate(client_) == 0) return true;
    jack_client_close(client_);
    client_ = nullptr;
    return false;
  }
  static int process(jack_nframes_t frames, void* self) {
    auto& module = *static_cast<Module*>(self);
    void* buffer = jack_port_get_buffer(module.port_, frames);
    const auto count = jack_midi_get_event_count(buffer);
    for (jack_nframes_t i = 0; i < count; ++i) {
      jack_midi_event_t event;
      if (jack_midi_event_get(&event, buffer, i) != 0) continue;
      Received message{jack_last_frame_time(module.client_) + event.time, {}};
      std::copy_n(event.buffer, std::min<std::size_t>(event.size, 3), message.bytes.begin());
      (void)module.queue_.push(message);
    }
    return 0;
  }

  jack_client_t* client_ = nullptr;
  jack_port_t* port_ = nullptr;
  SpscQueue<Received> queue_{4096};
  std::vector<Received> all_;
};

std::vector<Received> of_status(const std::vector<Received>& all, int status) {
  std::vector<Received> some;
  for (const auto& message : all)
    if (message.bytes[0] == status) some.push_back(message);
  return some;
}

}  // namespace

TEST_CASE("midi out: events are notes at a port of the program's own, in their rhythm", "[cards][midi]") {
  const OnServer on;
  if (!on.server) return;
  const auto beat = on.folder.write("beat.toml", kBeat).string();
  Playing play{{beat, "--backend", "jack", "--midi", "jack", "--midi-out"}};
  REQUIRE(play.says("MIDI out  jack:tactus_out; beat: note 36 in channel 10"));
  Module module;
  REQUIRE(module.connect("tactus_out:events"));
  REQUIRE(wait_until([&] { return of_status(module.take(), 0x99).size() >= 40; }));
  const auto notes = of_status(module.take(), 0x99), ends = of_status(module.take(), 0x89);
  CHECK(notes[0].bytes == std::array<std::uint8_t, 3>{0x99, 36, 127});
  CHECK(ends.size() >= notes.size() - 1);
  const double span_s = module.seconds(notes.back().frame - notes.front().frame);
  CHECK(span_s / static_cast<double>(notes.size() - 1) == Approx(0.05).epsilon(0.02));
  play.press("q");
  CHECK(play.ends() == 0);
  CHECK(play.log().find(" messages") != std::string::npos);
  CHECK(of_status(module.take(), 0x89).size() >= of_status(module.take(), 0x99).size());  // no note stays
}

TEST_CASE("midi out: a rig says what is sent: a note with its velocity, a controller, a clock",
          "[cards][midi]") {
  const OnServer on;
  if (!on.server) return;
  const auto beat = on.folder.write("beat.toml", kBeat).string();
  const auto rig = on.folder
                       .write("rig.toml", R"(format = 1
[device]
output = "jack:system"
[outputs]
tone = { channel = 1 }
[midi_out]
beat  = { note = 60, channel = 2, softest = "-40 dB", loudest = "20 dB" }
level = { control = 7 }
rate  = { clock = true, per_beat = 4 }
)")
                       .string();
  Playing play{{beat, "--rig", rig, "--midi", "jack"}};
  REQUIRE(play.says("MIDI out  jack:tactus_out; beat: note 60 in channel 2; level: controller 7"));
  Module module;
  REQUIRE(module.connect("tactus_out:events"));
  REQUIRE(wait_until([&] { return of_status(module.take(), 0xf8).size() >= 241; }));
  const auto notes = of_status(module.take(), 0x91), pulses = of_status(module.take(), 0xf8);
  REQUIRE(notes.size() >= 20);
  CHECK(notes[0].bytes[2] == 85);  // 40 of 60 dB
  const double span_s = module.seconds(pulses.back().frame - pulses.front().frame);
  CHECK(span_s / static_cast<double>(pulses.size() - 1) ==
        Approx(1.0 / (24 * 5)).epsilon(0.02));  // 5 beats a second
  play.press("\x1b[B");                         // the second control
  play.press("\x1b[C");                         // up by a twentieth
  REQUIRE(wait_until([&] { return !of_status(module.take(), 0xb0).empty(); }));
  CHECK(of_status(module.take(), 0xb0).back().bytes == std::array<std::uint8_t, 3>{0xb0, 7, 70});  // 0.55
  play.press("q");
  CHECK(play.ends() == 0);
  CHECK(wait_until([&] { return of_status(module.take(), 0xfc).size() == 1; }));
}

TEST_CASE("midi out: what the program sends is not what it receives", "[cards][midi]") {
  const OnServer on;
  if (!on.server) return;
  const auto beat = on.folder.write("beat.toml", kBeat).string();
  const auto rig = on.folder
                       .write("rig.toml", R"(format = 1
[device]
output = "jack:system"
[outputs]
tone = { channel = 1 }
[midi]
level = { note = 36 }
)")
                       .string();
  Playing play{{beat, "--rig", rig, "--midi", "jack", "--midi-out"}};
  REQUIRE(play.says("MIDI out  jack:tactus_out"));
  Module module;
  REQUIRE(module.connect("tactus_out:events"));
  REQUIRE(wait_until(
      [&] { return of_status(module.take(), 0x99).size() >= 30; }));  // ports are looked for twice a second
  play.press("q");
  CHECK(play.ends() == 0);
  CHECK(play.log().find("MIDI from 'jack:tactus_out") == std::string::npos);
}

TEST_CASE("midi out: an output that is not there is an error with those that are", "[cards][midi]") {
  const OnServer on;
  if (!on.server) return;
  const auto beat = on.folder.write("beat.toml", kBeat).string();
  Playing play{{beat, "--backend", "jack", "--midi", "jack", "--midi-out", "telegraph"}};
  CHECK(play.ends() != 0);
  CHECK(play.log().find("--midi-out: there is no MIDI output 'telegraph'") != std::string::npos);
}
