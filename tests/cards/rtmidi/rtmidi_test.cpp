#include <jack/jack.h>
#include <jack/midiport.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <memory>

#include "backends/midi.h"
#include "engine/core/spsc_queue.h"
#include "tests/cards/watched_stream.h"
#include "tests/cards/ways.h"
#include "tests/support/skip.h"
#include "tests/support/sound_server.h"
#include "tests/support/wait_until.h"

// RtMidi against a real server: a JACK client plays, and what it plays must be heard.

using namespace tactus;
using namespace std::chrono_literals;

namespace {

using Bytes = std::array<std::uint8_t, 3>;

/// A JACK client with one MIDI output, as a keyboard is one.
class Keyboard {
 public:
  explicit Keyboard(const std::string& name) {
    client_ = jack_client_open(name.c_str(), JackNoStartServer, nullptr);
    REQUIRE(client_ != nullptr);
    port_ = jack_port_register(client_, "keys", JACK_DEFAULT_MIDI_TYPE, JackPortIsOutput, 0);
    jack_set_process_callback(client_, process, this);
    REQUIRE(jack_activate(client_) == 0);
  }
  ~Keyboard() { jack_client_close(client_); }
  void play(const Bytes& bytes) { REQUIRE(offer(bytes)); }
  bool offer(const Bytes& bytes) { return queue_.push(bytes); }

 private:
  static int process(jack_nframes_t frames, void* self) {
    auto& keyboard = *static_cast<Keyboard*>(self);
    void* buffer = jack_port_get_buffer(keyboard.port_, frames);
    jack_midi_clear_buffer(buffer);
    jack_nframes_t at = 0;
    for (Bytes bytes; at < frames && keyboard.queue_.pop(bytes); ++at)
      jack_midi_event_write(buffer, at, bytes.data(), bytes.size());
    return 0;
  }

  SpscQueue<Bytes> queue_{256};
  jack_client_t* client_ = nullptr;
  jack_port_t* port_ = nullptr;
};

std::shared_ptr<MidiInputs> jack_inputs() { return make_rtmidi("jack", 20ms); }

bool opens(MidiInputs& inputs, const std::string& id) {
  return test::wait_until([&] {
    const auto ports = inputs.ports();
    return std::find(ports.begin(), ports.end(), id) != ports.end();
  });
}

bool closes(MidiInputs& inputs) {
  return test::wait_until([&] { return inputs.ports().empty(); });
}

/// What is heard until as many came as were played.
std::vector<MidiEvent> hear(MidiInputs& inputs, std::size_t many) {
  std::vector<MidiEvent> heard;
  test::wait_until([&] {
    for (auto& event : inputs.poll()) heard.push_back(std::move(event));
    return heard.size() >= many;
  });
  return heard;
}

/// JACK connects some periods after the port is listed, and loses what is played before: played until it
/// comes.
bool arrives(MidiInputs& inputs, Keyboard& keyboard) {
  static int number = 0;
  const auto value = static_cast<std::uint8_t>(++number % 128);  // not what an earlier keyboard played
  return test::wait_until([&] {
    keyboard.offer({0xb0, 7, value});
    return std::ranges::any_of(inputs.poll(),
                               [&](const MidiEvent& event) { return event.message.value == value; });
  });
}

std::string first_news(const std::string& api) {
  const auto inputs = make_rtmidi(api);
  std::vector<std::string> news;
  REQUIRE(test::wait_until([&] {
    for (auto& text : inputs->news()) news.push_back(text);
    return !news.empty();
  }));
  return news.front();
}

}  // namespace

TEST_CASE("rtmidi: every message of a keyboard comes in order, by the id of its port", "[cards]") {
  const auto server = test::start_sound_server();
  Keyboard keyboard{"tactus_keys"};
  const auto inputs = jack_inputs();
  REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
  for (std::uint8_t value = 0; value < 100; ++value) keyboard.play({0xb4, 7, value});
  keyboard.play({0x90, 36, 100});
  keyboard.play({0x80, 36, 0});
  keyboard.play({0xe0, 1, 64});
  const auto heard = hear(*inputs, 103);
  REQUIRE(heard.size() == 103);
  for (int value = 0; value < 100; ++value) {
    CHECK(heard[static_cast<std::size_t>(value)].message.value == value);
    CHECK(heard[static_cast<std::size_t>(value)].message.channel == 5);
  }
  CHECK(heard[0].port == "jack:tactus_keys:keys");
  CHECK(heard[100].message.kind == MidiMessage::Kind::NoteOn);
  CHECK(heard[101].message.kind == MidiMessage::Kind::NoteOff);
  CHECK(heard[102].message.value == 8193);
}

TEST_CASE("rtmidi: a keyboard that is unplugged and plugged in again is heard again under the same id",
          "[cards]") {
  const auto server = test::start_sound_server();
  const auto inputs = jack_inputs();
  for (int time = 0; time < 3; ++time) {
    {
      Keyboard keyboard{"tactus_keys"};
      REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
      CHECK(arrives(*inputs, keyboard));
      CHECK(inputs->news().back() == "MIDI from 'jack:tactus_keys:keys'");
    }
    REQUIRE(closes(*inputs));  // that it is away is seen by looking now and then
  }
  CHECK(inputs->news().back() ==
        "'jack:tactus_keys:keys' is disconnected; it is reopened when it reconnects");
}

TEST_CASE("rtmidi: lives on when its server is killed, and hears again when there is a new one", "[cards]") {
  const auto server = test::start_sound_server();
  const auto inputs = jack_inputs();
  auto keyboard = std::make_unique<Keyboard>("tactus_keys");
  REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
  server->kill();
  keyboard.reset();
  REQUIRE(closes(*inputs));
  CHECK(inputs->poll().empty());
  server->restart();
  keyboard = std::make_unique<Keyboard>("tactus_keys");
  REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
  CHECK(arrives(*inputs, *keyboard));
}

// JACK's library deletes all other clients of the process when one is opened after a death.
/// Known to crash in one of ten runs on a busy machine (docs/sound_cards.md, JACK): not run by default.
TEST_CASE("rtmidi: beside a stream over JACK, both come back when their server was killed", "[.known]") {
  const auto server = test::start_sound_server();
  const auto inputs = jack_inputs();
  StreamRequest request;
  request.device = "jack:system";
  request.in_channels = request.out_channels = 1;
  request.client_name = "tactus-" + std::to_string(::getpid());
  test::WatchedStream watched{test::backend_named("jack"), request, 4800, 30s};
  for (int time = 1; time <= 5; ++time) {
    server->kill();
    REQUIRE(watched.until(StreamState::Lost));
    server->restart();
    REQUIRE(watched.comes_back(time));
    {
      Keyboard keyboard{"tactus_keys"};
      REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
      CHECK(arrives(*inputs, keyboard));
    }
    REQUIRE(closes(*inputs));
  }
}

TEST_CASE("rtmidi: a server that hangs holds up nobody, not even the end", "[cards]") {
  const auto server = test::start_sound_server();
  Keyboard keyboard{"tactus_keys"};
  auto inputs = jack_inputs();
  REQUIRE(opens(*inputs, "jack:tactus_keys:keys"));
  server->stop_answering();
  CHECK(inputs->poll().empty());
  CHECK(inputs->ports().size() == 1);
  inputs.reset();  // returns, although the library does not
  server->go_on();
}

TEST_CASE("rtmidi: without a server there are no ports, and an API that is not there is reported",
          "[cards]") {
  const auto none = jack_inputs();
  CHECK(none->ports().empty());
  CHECK(none->poll().empty());
  CHECK(first_news("telegraph") == "no MIDI: this program was built without the MIDI backend 'telegraph'");
}

TEST_CASE("rtmidi: where the kernel has no sequencer, the command that loads it is printed", "[cards]") {
  if (std::filesystem::exists("/dev/snd/seq")) test::skip("the sequencer is loaded on this machine");
  CHECK(first_news("alsa") ==
        "no MIDI: the kernel's MIDI sequencer is not loaded; load it with: sudo modprobe snd-seq");
}
