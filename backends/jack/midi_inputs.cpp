#include "backends/jack/midi_inputs.h"

#include <algorithm>
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
      if (!is_open("jack:" + source))
        if (auto port = client->connect_midi(source)) add("jack:" + source, std::move(port));
  }

  void close() override {
    keep([](const auto&, auto&) { return false; });
  }

  const std::shared_ptr<PlayingClient> playing_;
  std::weak_ptr<Client> client_;  ///< whose ports are open
};

}  // namespace

std::shared_ptr<MidiInputs> make_midi_inputs(std::shared_ptr<PlayingClient> playing,
                                             std::chrono::milliseconds interval) {
  return MidiWorker::start(std::make_shared<JackMidi>(std::move(playing)), interval);
}

}  // namespace tactus::jack
