#include <RtMidi.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

#include "backends/library_calls.h"
#include "backends/midi_worker.h"

namespace tactus {
namespace {

constexpr int kChecksPerRetry = 4;

/// "nanoKONTROL2 CTRL 20:0" -> "nanoKONTROL2 CTRL": ALSA counts clients anew at each plugging in.
std::string without_address(const std::string& name) {
  const auto end = name.find_last_not_of("0123456789");
  if (end == std::string::npos || name[end] != ':' || end + 1 == name.size()) return name;
  const auto client = name.find_last_not_of("0123456789", end - 1);
  const bool address = client != std::string::npos && name[client] == ' ' && client + 1 < end;
  return address ? name.substr(0, client) : name;
}

/// Without it, RtMidi's constructor prints an error of its own.
void check_sequencer(RtMidi::Api api) {
  std::error_code ignored;
  if (api == RtMidi::LINUX_ALSA && !std::filesystem::exists("/dev/snd/seq", ignored))
    throw RtMidiError("the kernel's MIDI sequencer is not loaded; load it with: sudo modprobe snd-seq");
}

/// Its thread is the library's.
struct OpenPort final : MidiPort {
  std::unique_ptr<RtMidiIn> in;

  static void receive(double, std::vector<unsigned char>* bytes, void* self) {
    receive_midi(*static_cast<OpenPort*>(self), *bytes);
  }
};

// Without one, the library prints what it thinks.
void ignore_error(RtMidiError::Type, const std::string&, void*) {}

/// The APIs that this program uses: JACK's MIDI comes with its stream, since RtMidi does not notice the death
/// of a JACK server.
std::vector<RtMidi::Api> apis() {
  std::vector<RtMidi::Api> compiled;
  RtMidi::getCompiledApi(compiled);
  std::erase(compiled, RtMidi::UNIX_JACK);
  return compiled;
}

class RtMidiWorker final : public MidiWorker {
 public:
  explicit RtMidiWorker(std::string api) : api_(std::move(api)) {}

 private:
  void look() override {
    const bool retry = checks_++ % kChecksPerRetry == 0;
    try {
      if (scout_ == nullptr && retry) scout_ = make_client();
      if (scout_ != nullptr) update_ports();
    } catch (const RtMidiError& error) {
      scout_.reset();
      throw std::runtime_error{error.what()};
    }
  }

  void close() override {
    MidiWorker::close();
    scout_.reset();
  }

  std::unique_ptr<RtMidiIn> make_client() const {
    const auto available = apis();
    const auto named = [this](RtMidi::Api api) { return api_.empty() || RtMidi::getApiName(api) == api_; };
    const auto api = std::ranges::find_if(available, named);
    if (api == available.end())
      throw RtMidiError("this program was built without the MIDI backend '" + api_ + "'");
    check_sequencer(*api);
    auto client = std::make_unique<RtMidiIn>(*api, "tactus_midi");
    client->setErrorCallback(ignore_error);
    return client;
  }

  void update_ports() {
    const auto available = names_by_id(*scout_);
    keep([&](const std::string& id, auto&) { return available.contains(id); });
    for (const auto& [id, name] : available)
      if (!is_open(id)) open(id, name);
  }

  static std::map<std::string, std::string> names_by_id(RtMidiIn& client) {
    std::map<std::string, std::string> names;
    const auto api = RtMidi::getApiName(client.getCurrentApi());
    const auto count = client.getPortCount();
    for (unsigned i = 0; i < count; ++i) {
      const auto name = client.getPortName(i);
      if (name.empty()) continue;  // gone meanwhile
      const auto first = api + ":" + without_address(name);
      auto id = first;
      for (int twin = 2; names.contains(id); ++twin) id = first + " #" + std::to_string(twin);
      names[id] = name;
    }
    return names;
  }

  void open(const std::string& id, const std::string& name) {
    auto port = std::make_shared<OpenPort>();
    port->in = make_client();
    const auto count = port->in->getPortCount();
    for (unsigned i = 0; i < count && !port->in->isPortOpen(); ++i) {
      if (port->in->getPortName(i) != name) continue;
      port->in->setCallback(OpenPort::receive, port.get());
      port->in->openPort(i, "in");
    }
    if (port->in->isPortOpen()) add(id, std::move(port));
  }

  const std::string api_;
  std::unique_ptr<RtMidiIn> scout_;  ///< only looks
  int checks_ = 0;
};

}  // namespace

std::shared_ptr<MidiInputs> make_rtmidi(const std::string& api, std::chrono::milliseconds interval) {
  silence_library_logs();
  return MidiWorker::start(std::make_shared<RtMidiWorker>(api), interval);
}

}  // namespace tactus
