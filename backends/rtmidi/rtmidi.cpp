#include <RtMidi.h>

#include <algorithm>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "backends/jack_clients.h"
#include "backends/library_calls.h"
#include "backends/midi.h"
#include "engine/core/spsc_queue.h"

namespace tactus {
namespace {

using namespace std::chrono_literals;

constexpr auto kPatience = 1s;  // for the library, when all ends
constexpr int kChecksPerRetry = 4;

/// "nanoKONTROL2 CTRL 20:0" -> "nanoKONTROL2 CTRL": ALSA counts clients anew at each plugging in.
std::string without_address(const std::string& name) {
  const auto end = name.find_last_not_of("0123456789");
  if (end == std::string::npos || name[end] != ':' || end + 1 == name.size()) return name;
  const auto client = name.find_last_not_of("0123456789", end - 1);
  const bool address = client != std::string::npos && name[client] == ' ' && client + 1 < end;
  return address ? name.substr(0, client) : name;
}

/// What the library reports, or its cause where that is known.
std::string explained(const std::string& error) {
  std::error_code ignored;
  if (error.find("ALSA sequencer") != std::string::npos && !std::filesystem::exists("/dev/snd/seq", ignored))
    return "the kernel's MIDI sequencer is not loaded; load it with: sudo modprobe snd-seq";
  return error;
}

/// A port that is open. Its thread is the library's.
struct OpenPort {
  SpscQueue<MidiMessage> queue{1024};
  std::unique_ptr<RtMidiIn> in;

  static void receive(double, std::vector<unsigned char>* bytes, void* self) {
    auto message = parse_midi(*bytes);
    if (!message) return;
    message->time = std::chrono::steady_clock::now();
    (void)static_cast<OpenPort*>(self)->queue.push(*message);  // full: not polled for a thousand
  }
};

// Without one, the library prints what it thinks.
void ignore_error(RtMidiError::Type, const std::string&, void*) {}

/// Looks for ports and keeps them open, on its own thread; the control thread asks it for what came. Whoever
/// of the two lives longer keeps it.
class Worker final : public MidiInputs {
 public:
  Worker(std::string api, std::chrono::milliseconds interval) : api_(std::move(api)), interval_(interval) {}

  void run() {
    for (int checks = 0;; ++checks) {
      try {
        const bool retry = checks % kChecksPerRetry == 0;
        if (hold_ != nullptr && jack_clients_must_close()) close();
        if (scout_ == nullptr && retry) open_scout();
        if (scout_ != nullptr) update_ports();
      } catch (const std::exception& error) {
        scout_.reset();
        report_error(explained(error.what()));
      }
      std::unique_lock lock{mutex_};
      if (wake_.wait_for(lock, interval_, [this] { return stop_; })) break;
    }
    close();
    const std::lock_guard lock{mutex_};
    stopped_ = true;
    wake_.notify_all();
  }

  /// [control]
  void stop() {
    std::unique_lock lock{mutex_};
    stop_ = true;
    wake_.notify_all();
    wake_.wait_for(lock, kPatience, [this] { return stopped_; });
  }

  std::vector<std::string> ports() override {
    const std::lock_guard lock{mutex_};
    std::vector<std::string> ids;
    for (const auto& port : ports_) ids.push_back(port.first);
    return ids;
  }

  std::vector<MidiEvent> poll() override {
    const std::lock_guard lock{mutex_};
    std::vector<MidiEvent> events;
    for (const auto& [id, port] : ports_)
      for (MidiMessage message; port->queue.pop(message);) events.push_back({id, message});
    return events;
  }

  std::vector<std::string> news() override {
    const std::lock_guard lock{mutex_};
    return std::exchange(news_, {});
  }

 private:
  std::unique_ptr<RtMidiIn> make_client() const {
    const auto api = api_.empty() ? RtMidi::UNSPECIFIED : RtMidi::getCompiledApiByName(api_);
    if (api == RtMidi::UNSPECIFIED && !api_.empty())
      throw RtMidiError("this program was built without the MIDI backend '" + api_ + "'");
    auto client = std::make_unique<RtMidiIn>(api, "tactus_midi");
    client->setErrorCallback(ignore_error);
    return client;
  }

  void open_scout() {
    if (api_ == "jack" && hold_ == nullptr) hold_ = JackClientHold::acquire_watched("tactus_midi_watch");
    if (api_ != "jack" || hold_ != nullptr) scout_ = make_client();
  }

  void close() {
    if (hold_ != nullptr) hold_->closing();
    close_missing({});
    scout_.reset();
    hold_.reset();
  }

  void update_ports() {
    const auto available = names_by_id(*scout_);
    close_missing(available);
    const auto opened = ports();
    for (const auto& [id, name] : available)
      if (std::ranges::find(opened, id) == opened.end()) open(id, name);
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
    if (!port->in->isPortOpen()) return;
    const std::lock_guard lock{mutex_};
    ports_[id] = std::move(port);
    news_.push_back("MIDI from '" + id + "'");
    reported_error_.clear();
  }

  void close_missing(const std::map<std::string, std::string>& available) {
    std::vector<std::shared_ptr<OpenPort>> closing;  // outside of the lock
    const std::lock_guard lock{mutex_};
    std::erase_if(ports_, [&](const auto& port) {
      if (available.contains(port.first)) return false;
      news_.push_back("'" + port.first + "' is disconnected; it is reopened when it reconnects");
      closing.push_back(port.second);
      return true;
    });
    // `lock` is released first: it was made last.
  }

  void report_error(const std::string& text) {
    if (std::exchange(reported_error_, text) == text) return;
    const std::lock_guard lock{mutex_};
    news_.push_back("no MIDI: " + text);
  }

  const std::string api_;
  const std::chrono::milliseconds interval_;
  std::unique_ptr<JackClientHold> hold_;
  std::unique_ptr<RtMidiIn> scout_;  ///< only looks
  std::string reported_error_;
  std::mutex mutex_;  ///< of what follows; never held while the library is called
  std::condition_variable wake_;
  std::map<std::string, std::shared_ptr<OpenPort>> ports_;  ///< by id
  std::vector<std::string> news_;
  bool stop_ = false;
  bool stopped_ = false;
};

}  // namespace

// A library that hangs keeps its thread, and what that needs, to itself.
std::shared_ptr<MidiInputs> make_rtmidi(const std::string& api, std::chrono::milliseconds interval) {
  silence_library_logs();
  const auto worker = std::make_shared<Worker>(api, interval);
  std::thread{[worker] { worker->run(); }}.detach();
  return {worker.get(), [worker](MidiInputs*) { worker->stop(); }};
}

}  // namespace tactus
