#pragma once
// Thread: [control]

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "backends/midi_output.h"
#include "remote/midi/midi_out_map.h"

namespace tactus {

/// Sends the events and controls of an instrument as MIDI messages, on a thread of its own: a library or a
/// device that does not answer holds up nothing else.
class MidiSender {
 public:
  /// `target` outlives it. Errors: of MidiOutMap::check.
  static Checked<std::unique_ptr<MidiSender>> start(std::unique_ptr<MidiOutput> output,
                                                    std::vector<RigMidiOut> bindings, RemoteTarget& target);
  /// Ends all notes.
  ~MidiSender();

  const MidiOutput& output() const { return *output_; }
  std::int64_t sent() const { return sent_.load(std::memory_order_relaxed); }

 private:
  MidiSender(std::unique_ptr<MidiOutput> output, std::vector<RigMidiOut> bindings, RemoteTarget& target);
  void run();

  std::unique_ptr<MidiOutput> output_;
  RemoteTarget& target_;
  std::atomic<std::int64_t> sent_{0};
  MidiOutMap map_;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace tactus
