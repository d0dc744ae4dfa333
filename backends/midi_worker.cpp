#include "backends/midi_worker.h"

#include <exception>
#include <thread>
#include <utility>

namespace tactus {
namespace {

constexpr std::chrono::seconds kPatienceAtEnd{1};

}  // namespace

void receive_midi(MidiPort& port, std::span<const std::uint8_t> bytes) noexcept {
  auto message = parse_midi(bytes);
  if (!message) return;
  message->time = std::chrono::steady_clock::now();
  (void)port.queue.push(*message);  // full: not polled for a thousand
}

// A library that hangs keeps its thread, and what that needs, to itself.
std::shared_ptr<MidiInputs> MidiWorker::start(std::shared_ptr<MidiWorker> worker,
                                              std::chrono::milliseconds interval) {
  std::thread{[worker, interval] { worker->run(interval); }}.detach();
  return {worker.get(), [worker](MidiInputs*) { worker->stop(); }};
}

void MidiWorker::run(std::chrono::milliseconds interval) {
  while (true) {
    try {
      look();
    } catch (const std::exception& error) {
      report_error(error.what());
    }
    std::unique_lock lock{mutex_};
    if (wake_.wait_for(lock, interval, [this] { return stop_; })) break;
  }
  close();
  const std::lock_guard lock{mutex_};
  stopped_ = true;
  wake_.notify_all();
}

void MidiWorker::stop() {
  std::unique_lock lock{mutex_};
  stop_ = true;
  wake_.notify_all();
  wake_.wait_for(lock, kPatienceAtEnd, [this] { return stopped_; });
}

std::vector<std::string> MidiWorker::ports() {
  const std::lock_guard lock{mutex_};
  std::vector<std::string> ids;
  for (const auto& port : ports_) ids.push_back(port.first);
  return ids;
}

std::vector<MidiEvent> MidiWorker::poll() {
  const std::lock_guard lock{mutex_};
  std::vector<MidiEvent> events;
  for (const auto& [id, port] : ports_)
    for (MidiMessage message; port->queue.pop(message);) events.push_back({id, message});
  return events;
}

std::vector<std::string> MidiWorker::news() {
  const std::lock_guard lock{mutex_};
  return std::exchange(news_, {});
}

void MidiWorker::close() {
  keep([](const auto&, auto&) { return false; });
}

bool MidiWorker::is_open(const std::string& id) {
  const std::lock_guard lock{mutex_};
  return ports_.contains(id);
}

void MidiWorker::note(std::string message) {
  const std::lock_guard lock{mutex_};
  news_.push_back(std::move(message));
}

void MidiWorker::add(const std::string& id, std::shared_ptr<MidiPort> port) {
  const std::lock_guard lock{mutex_};
  ports_[id] = std::move(port);
  news_.push_back("MIDI from '" + id + "'");
  reported_error_.clear();
}

void MidiWorker::keep(const std::function<bool(const std::string&, MidiPort&)>& stays) {
  std::vector<std::shared_ptr<MidiPort>> closing;  // outside of the lock
  const std::lock_guard lock{mutex_};
  std::erase_if(ports_, [&](const auto& port) {
    if (stays(port.first, *port.second)) return false;
    for (MidiMessage message; port.second->queue.pop(message);) continue;  // it may be used for another one
    news_.push_back("'" + port.first + "' is disconnected; it is reopened when it reconnects");
    closing.push_back(port.second);
    return true;
  });
  // `lock` is released first: it was made last.
}

void MidiWorker::report_error(const std::string& text) {
  if (std::exchange(reported_error_, text) != text) note("no MIDI: " + text);
}

}  // namespace tactus
