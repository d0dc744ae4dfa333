#include "backends/jack/midi_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace tactus::jack {
namespace {

class JackMidi final : public MidiWorker {
 public:
  explicit JackMidi(std::shared_ptr<PlayingClient> playing) : playing_(std::move(playing)) {}

 private:
  void look() override {
    const auto client = playing_->get();
    if (!client || client != client_.lock()) close();
    client_ = client;
    if (!client) return;
    const auto sources = client->midi_sources();
    keep([&](const std::string& id, MidiPort& port) {
      return static_cast<MidiInPort&>(port).is_there && std::ranges::count(sources, id.substr(5)) > 0;
    });
    for (const auto& source : sources)
      if (!is_open("jack:" + source)) open(*client, source);
  }
  void open(Client& client, const std::string& source) {
    const auto id = "jack:" + source;
    if (ports().size() == MidiIn::kMostPorts) {
      if (refused_.insert(id).second)
        note(fmt::format("no MIDI from '{}': {} sources are connected already", id, MidiIn::kMostPorts));
    } else if (auto port = client.connect_midi(source)) {
      refused_.erase(id);
      add(id, std::move(port));
    }
  }

  const std::shared_ptr<PlayingClient> playing_;
  std::weak_ptr<Client> client_;   ///< whose ports are open
  std::set<std::string> refused_;  ///< sources for which there was no port, once reported
};

}  // namespace

std::shared_ptr<MidiInputs> make_midi_inputs(std::shared_ptr<PlayingClient> playing,
                                             std::chrono::milliseconds interval) {
  return MidiWorker::start(std::make_shared<JackMidi>(std::move(playing)), interval);
}

}  // namespace tactus::jack
