#include <jack/jack.h>
#include <jack/midiport.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "backends/midi.h"
#include "engine/core/spsc_queue.h"
#include "tests/cards/watched_stream.h"
#include "tests/cards/ways.h"
#include "tests/support/sound_server.h"
#include "tests/support/wait_until.h"

// MIDI inputs of a stream on a real server: another JACK client sends messages, which must arrive.

using namespace tactus;
using namespace std::chrono_literals;

namespace {

constexpr int kTrial = 16;  // channel of the messages of Player::hears

using Bytes = std::array<std::uint8_t, 3>;

/// A JACK client with one MIDI output, as a keyboard is one. A busy server may refuse to activate it: it
/// joins again until it plays.
class Keyboard {
 public:
  explicit Keyboard(const std::string& name) {
    REQUIRE(test::wait_until([&] { return joins(name); }));
  }
  ~Keyboard() { jack_client_close(client_); }
  void play(const Bytes& bytes) { REQUIRE(offer(bytes)); }
  bool offer(const Bytes& bytes) { return queue_.push(bytes); }

 private:
  bool joins(const std::string& name) {
    client_ = jack_client_open(name.c_str(),
                               static_cast<jack_options_t>(JackNoStartServer | JackUseExactName), nullptr);
    if (client_ == nullptr) return false;
    port_ = jack_port_register(client_, "keys", JACK_DEFAULT_MIDI_TYPE, JackPortIsOutput, 0);
    jack_set_process_callback(client_, process, this);
    if (port_ != nullptr && jack_activate(client_) == 0) return true;
    jack_client_close(client_);
    client_ = nullptr;
    return false;
  }

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

/// A stream that plays on the server's card, and the MIDI inputs of its client.
struct Player : test::WatchedStream {
  Player() : WatchedStream(test::backend_named("jack"), request(), 4800, 30s) {}

  bool opens(const std::string& id) {
    return until([&] { return std::ranges::count(inputs->ports(), id) > 0; });
  }
  bool closes() {
    return until([&] { return inputs->ports().empty(); });
  }
  /// JACK connects some periods after the port is listed, and loses what is played before: played until it
  /// comes.
  bool hears(Keyboard& keyboard) {
    static int number = 0;
    const auto value = static_cast<std::uint8_t>(++number % 128);  // not what an earlier keyboard played
    return until([&] {
      keyboard.offer({0xb0 + kTrial - 1, 7, value});
      return std::ranges::any_of(inputs->poll(),
                                 [&](const MidiEvent& event) { return event.message.value == value; });
    });
  }

  static StreamRequest request() {
    StreamRequest request;
    request.device = "jack:system";
    request.in_channels = request.out_channels = 1;
    request.client_name = client();
    return request;
  }
  static std::string client() { return "tactus-" + std::to_string(::getpid()); }

  std::shared_ptr<MidiInputs> inputs = backend->midi_inputs(20ms);
};

const std::string kKeys = "jack:tactus_keys:keys";

/// Waits until `many` messages have arrived, those of Player::hears not counted.
std::vector<MidiEvent> hear(MidiInputs& inputs, std::size_t many) {
  std::vector<MidiEvent> heard;
  test::wait_until([&] {
    for (auto& event : inputs.poll())
      if (event.message.channel != kTrial) heard.push_back(std::move(event));
    return heard.size() >= many;
  });
  return heard;
}

}  // namespace

TEST_CASE("jack: every MIDI message of a keyboard comes in order, by the id of its port", "[cards][jack]") {
  const auto server = test::start_sound_server();
  Keyboard keyboard{"tactus_keys"};
  Player player;
  REQUIRE(player.opens(kKeys));
  REQUIRE(player.hears(keyboard));
  for (std::uint8_t value = 0; value < 100; ++value) keyboard.play({0xb4, 7, value});
  keyboard.play({0x94, 36, 100});
  keyboard.play({0x84, 36, 0});
  keyboard.play({0xe4, 1, 64});
  const auto heard = hear(*player.inputs, 103);
  REQUIRE(heard.size() == 103);
  for (int value = 0; value < 100; ++value) {
    CHECK(heard[static_cast<std::size_t>(value)].message.value == value);
    CHECK(heard[static_cast<std::size_t>(value)].message.channel == 5);
  }
  CHECK(heard[0].port == kKeys);
  CHECK(heard[100].message.kind == MidiMessage::Kind::NoteOn);
  CHECK(heard[101].message.kind == MidiMessage::Kind::NoteOff);
  CHECK(heard[102].message.value == 8193);
}

TEST_CASE("jack: two keyboards have a MIDI port each, and messages come from the right one",
          "[cards][jack]") {
  const auto server = test::start_sound_server();
  Player player;
  Keyboard first{"tactus_keys"}, second{"tactus_pads"};
  REQUIRE(player.opens(kKeys));
  REQUIRE(player.opens("jack:tactus_pads:keys"));
  CHECK(player.hears(first));
  CHECK(player.hears(second));
  player.inputs->poll();
  second.play({0x90, 40, 99});
  REQUIRE(player.until([&] {
    const auto heard = player.inputs->poll();
    return std::ranges::any_of(heard, [](const MidiEvent& event) {
      return event.port == "jack:tactus_pads:keys" && event.message.number == 40;
    });
  }));
}

TEST_CASE("jack: a keyboard that leaves and returns is heard again under the same id, by the same port",
          "[cards][jack]") {
  const auto server = test::start_sound_server();
  Player player;
  for (int time = 0; time < 3; ++time) {
    {
      Keyboard keyboard{"tactus_keys"};
      REQUIRE(player.opens(kKeys));
      CHECK(player.hears(keyboard));
      CHECK(player.inputs->news().back() == "MIDI from '" + kKeys + "'");
      CHECK(server->connections("tactus_keys:keys") == Player::client() + ":midi_1\n");
    }
    REQUIRE(player.closes());
  }
  CHECK(player.inputs->news().back() == "'" + kKeys + "' is disconnected; it is reopened when it reconnects");
}

TEST_CASE("jack: a stream and its MIDI come back together when their server was killed", "[cards][jack]") {
  const auto server = test::start_sound_server();
  Player player;
  for (int time = 1; time <= 5; ++time) {
    server->kill();
    REQUIRE(player.until(StreamState::Lost));
    server->restart();
    REQUIRE(player.comes_back(time));
    {
      Keyboard keyboard{"tactus_keys"};
      REQUIRE(player.opens(kKeys));
      CHECK(player.hears(keyboard));
    }
    REQUIRE(player.closes());
  }
}

TEST_CASE("jack: the MIDI inputs are not held up by a server that hangs", "[cards][jack]") {
  const auto server = test::start_sound_server();
  Keyboard keyboard{"tactus_keys"};
  Player player;
  REQUIRE(player.opens(kKeys));
  server->stop_answering();
  CHECK(player.inputs->poll().empty());
  CHECK(player.inputs->ports() == std::vector{kKeys});
  player.inputs.reset();  // returns, whatever the server does
  server->go_on();
}

TEST_CASE("jack: without a stream that plays there is no MIDI", "[cards][jack]") {
  const auto server = test::start_sound_server();
  Keyboard keyboard{"tactus_keys"};
  Player player;
  REQUIRE(player.opens(kKeys));
  REQUIRE(player.stream->stop());
  CHECK(player.closes());
  CHECK(player.inputs->poll().empty());
  REQUIRE(player.stream->start());
  REQUIRE(player.opens(kKeys));
  CHECK(player.hears(keyboard));
}
