#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "backends/midi.h"
#include "engine/core/spsc_queue.h"

namespace tactus {

/// An input that is open: messages go in on the thread of a library.
struct MidiPort {
  virtual ~MidiPort() = default;
  SpscQueue<MidiMessage> queue{1024};
};

/// [any] Reads `bytes` and queues what is of use to us, with the time of now. A full queue loses it.
void receive_midi(MidiPort& port, std::span<const std::uint8_t> bytes) noexcept;

/// Looks for ports and keeps them open, on a thread of its own, because servers may hang: a call that never
/// returns costs that thread and nothing else. Whoever of that thread and the control thread lives longer
/// keeps it.
class MidiWorker : public MidiInputs {
 public:
  /// [control] Starts `worker`, which looks for ports every `interval`.
  static std::shared_ptr<MidiInputs> start(std::shared_ptr<MidiWorker> worker,
                                           std::chrono::milliseconds interval);

  std::vector<std::string> ports() override;
  std::vector<MidiEvent> poll() override;
  std::vector<std::string> news() override;

 protected:
  // On the worker's own thread.
  /// Opens what appeared, closes what disappeared. A std::exception is reported as the reason for no MIDI.
  virtual void look() = 0;
  /// Closes whatever is open; also the last call.
  virtual void close();
  bool is_open(const std::string& id);
  void note(std::string message);
  void add(const std::string& id, std::shared_ptr<MidiPort> port);
  /// Removes the ports for which `stays` returns false.
  void keep(const std::function<bool(const std::string& id, MidiPort& port)>& stays);

 private:
  void run(std::chrono::milliseconds interval);
  void stop();
  void report_error(const std::string& text);

  std::string reported_error_;
  std::mutex mutex_;  ///< of what follows; never held while a library is called
  std::condition_variable wake_;
  std::map<std::string, std::shared_ptr<MidiPort>> ports_;  ///< by id
  std::vector<std::string> news_;
  bool stop_ = false;
  bool stopped_ = false;
};

}  // namespace tactus
