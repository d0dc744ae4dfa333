#include <RtMidi.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>

#include "backends/library_calls.h"
#include "backends/midi_output.h"
#include "backends/midi_worker.h"

namespace tactus {
namespace {

/// "nanoKONTROL2 CTRL 20:0" -> "nanoKONTROL2 CTRL": ALSA counts clients anew at each plugging in.
std::string without_address(const std::string& name) {
  const auto end = name.find_last_not_of("0123456789");
  if (end == std::string::npos || name[end] != ':' || end + 1 == name.size()) return name;
  const auto client = name.find_last_not_of("0123456789", end - 1);
  const bool address = client != std::string::npos && name[client] == ' ' && client + 1 < end;
  return address ? name.substr(0, client) : name;
}

/// Without it, RtMidi's constructor prints an error of its own. Throws an RtMidiError.
void check_sequencer(RtMidi::Api api) {
  std::error_code ignored;
  if (api == RtMidi::LINUX_ALSA && !std::filesystem::exists("/dev/snd/seq", ignored))
    throw RtMidiError("the kernel's MIDI sequencer is not loaded; load it with: sudo modprobe snd-seq");
}

/// The names of the ports by their ids (see make_rtmidi).
std::map<std::string, std::string> rtmidi_ports(RtMidi& client, const std::string& api) {
  std::map<std::string, std::string> names;
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

// Without one, the library prints what it thinks.
void ignore_rtmidi_error(RtMidiError::Type, const std::string&, void*) {}

constexpr int kChecksPerRetry = 4;

/// Its thread is the library's.
struct OpenPort final : MidiPort {
  std::unique_ptr<RtMidiIn> in;

  static void receive(double, std::vector<unsigned char>* bytes, void* self) {
    receive_midi(*static_cast<OpenPort*>(self), *bytes);
  }
};

/// The APIs that this program uses: JACK's MIDI comes with its stream, since RtMidi does not notice the death
/// of a JACK server.
std::vector<RtMidi::Api> apis() {
  std::vector<RtMidi::Api> compiled;
  RtMidi::getCompiledApi(compiled);
  std::erase(compiled, RtMidi::UNIX_JACK);
  return compiled;
}

/// The first one, or the one of this name, if it can be used. Throws an RtMidiError.
RtMidi::Api choose(const std::vector<RtMidi::Api>& available, const std::string& name) {
  const auto api = std::ranges::find_if(available, [&](RtMidi::Api candidate) {
    return name.empty() || RtMidi::getApiName(candidate) == name;
  });
  if (api == available.end())
    throw RtMidiError("this program was built without the MIDI backend '" + name + "'");
  check_sequencer(*api);
  return *api;
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
    const auto api = choose(apis(), api_);
    auto client = std::make_unique<RtMidiIn>(api, "tactus_midi");
    client->setErrorCallback(ignore_rtmidi_error);
    return client;
  }

  void update_ports() {
    auto available = rtmidi_ports(*scout_, RtMidi::getApiName(scout_->getCurrentApi()));
    std::erase_if(available, [](const auto& port) { return is_own_output(port.second); });
    keep([&](const std::string& id, auto&) { return available.contains(id); });
    for (const auto& [id, name] : available)
      if (!is_open(id)) open(id, name);
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

// Output.

constexpr const char* kOwnPort = "events";

std::unique_ptr<RtMidiOut> make_output_client(const std::string& api_name) {
  auto available = apis();
  if (api_name == "jack") RtMidi::getCompiledApi(available);
  const auto api = choose(available, api_name);
  auto client = std::make_unique<RtMidiOut>(api, kMidiOutClient);
  client->setErrorCallback(ignore_rtmidi_error);
  return client;
}

std::string api_of(RtMidiOut& client) { return RtMidi::getApiName(client.getCurrentApi()); }

class RtMidiOutput final : public MidiOutput {
 public:
  /// A port of our own.
  explicit RtMidiOutput(std::unique_ptr<RtMidiOut> client)
      : name_(api_of(*client) + ":" + kMidiOutClient), client_(std::move(client)) {
    client_->openVirtualPort(kOwnPort);
  }
  /// That of a device.
  RtMidiOutput(std::unique_ptr<RtMidiOut> client, std::string id)
      : name_(std::move(id)), of_device_(true), client_(std::move(client)) {
    open();
  }

  const std::string& name() const override { return name_; }
  void send(std::span<const std::uint8_t> bytes) override {
    if (client_->isPortOpen() || !of_device_) client_->sendMessage(bytes.data(), bytes.size());
  }
  std::optional<std::string> look() override {
    if (!of_device_) return std::nullopt;
    const bool open_before = client_->isPortOpen();
    const bool there = rtmidi_ports(*client_, api_of(*client_)).contains(name_);
    if (there == open_before) return std::nullopt;
    if (!there) {
      client_->closePort();
      return "MIDI output " + name_ + " is gone";
    }
    open();
    return client_->isPortOpen() ? std::optional{"MIDI output " + name_ + " is back"} : std::nullopt;
  }

 private:
  void open() {
    const auto ports = rtmidi_ports(*client_, api_of(*client_));
    const auto port = ports.find(name_);
    const auto count = port == ports.end() ? 0 : client_->getPortCount();
    for (unsigned i = 0; i < count && !client_->isPortOpen(); ++i)
      if (client_->getPortName(i) == port->second) client_->openPort(i, kOwnPort);
  }

  std::string name_;
  bool of_device_ = false;
  std::unique_ptr<RtMidiOut> client_;
};

Result<std::unique_ptr<MidiOutput>> open_now(const std::string& api, const std::string& port) {
  auto client = make_output_client(api);
  if (port.empty()) {
    if (client->getCurrentApi() == RtMidi::WINDOWS_MM)
      return fail(Errc::Device, "--midi-out", "Windows has no MIDI ports of programs",
                  "install a virtual MIDI cable, and name it with --midi-out NAME");
    return std::make_unique<RtMidiOutput>(std::move(client));
  }
  std::vector<std::string> ids;
  for (const auto& [id, name] : rtmidi_ports(*client, api_of(*client))) {
    if (id == port || id.find(port) != std::string::npos)
      return std::make_unique<RtMidiOutput>(std::move(client), id);
    ids.push_back(id);
  }
  return fail(Errc::UnknownName, "--midi-out", "there is no MIDI output '" + port + "'",
              ids.empty() ? "there is none; without a name, other programs can connect to a port of this one"
                          : fmt::format("there is {}", fmt::join(ids, ", ")));
}

}  // namespace

std::shared_ptr<MidiInputs> make_rtmidi(const std::string& api, std::chrono::milliseconds interval) {
  silence_library_logs();
  return MidiWorker::start(std::make_shared<RtMidiWorker>(api), interval);
}

Result<std::unique_ptr<MidiOutput>> open_midi_output(const std::string& api, const std::string& port) {
  silence_library_logs();
  using Opened = Result<std::unique_ptr<MidiOutput>>;
  auto opened = result_with_timeout([api, port]() -> std::shared_ptr<Opened> {
    try {
      return std::make_shared<Opened>(open_now(api, port));
    } catch (const RtMidiError& error) {
      return std::make_shared<Opened>(fail(Errc::Device, "--midi-out", error.what(), ""));
    }
  });
  if (!opened) return fail(Errc::Device, "--midi-out", "the MIDI system does not answer", "restart it");
  return std::move(**opened);
}

}  // namespace tactus
