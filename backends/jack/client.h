#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "backends/card_callback.h"
#include "backends/jack/client_hold.h"
#include "backends/jack/midi_in.h"
#include "backends/library_calls.h"

// As JACK's own headers name them.
struct _jack_client;
struct _jack_port;

namespace tactus::jack {

using Names = std::vector<std::string>;

/// From one port to another, by their full names.
struct Wire {
  std::string from, to;
};

/// [any] "card" of the port "card:playback_1".
inline std::string client_of(const std::string& port) { return port.substr(0, port.find(':')); }

/// [control] Those that a function of JACK's listed, which is freed; nullptr: none.
Names names_of(const char** listed);

/// [any] Errors of this backend.
Status cannot(const std::string& what, const std::string& remedy);
tl::unexpected<Error> no_answer();

/// [control] A call that may hang; gives up after two seconds. `call` owns whatever it touches and returns a
/// Result.
template <class Call>
auto ask_server(Call call) -> decltype(call()) {
  if (auto answer = result_with_timeout(std::move(call))) return std::move(*answer);
  return no_answer();
}

/// A client of the running server, closed with its last owner. Any call that waits for the server's answer
/// may hang: such calls are made by `ask_server` and own the client, and it closes itself with the
/// same patience.
class Client {
 public:
  /// [control, may hang] Errors: Device, if no server answers.
  static Result<std::shared_ptr<Client>> open(const std::string& name);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// [control & inactive, may hang] Ports in_1, in_2, … and out_1, out_2, … Errors: Device.
  Status add_ports(int inputs, int outputs);
  /// [control]
  std::string input_port(int channel) const;
  std::string output_port(int channel) const;

  /// [control, may hang] Blocks come, and every wire is connected. Errors: Device.
  Status activate();
  /// [control, may hang] No block comes any more.
  void deactivate();

  /// [control] See Stream.
  std::vector<OtherWriter> other_writers() const;
  /// [control] Those that connected since the last call, even if they are gone again.
  std::vector<OtherWriter> take_passing_writers();
  /// [control & active] Ports of others that MIDI comes out of, by their full names.
  Names midi_sources() const;
  /// [control, may hang] What the server calls the client of this name; empty: it has none, or no id for it.
  std::string id_of(const std::string& name);
  /// [control & active, may hang] What comes out of `source` is received. Empty: it cannot be connected now.
  std::shared_ptr<MidiInPort> connect_midi(const std::string& source);
  /// [control & active] For each wire: is it connected?
  std::vector<bool> connected() const;

  _jack_client* const handle;
  std::unique_ptr<CardCallback> card;  ///< set before `activate`
  /// Counts ends of wires that got other names. Set with the wires.
  std::shared_ptr<std::atomic<int>> renames;
  /// It is lost when an end of one goes away or gets another name. Those to the inputs come first, each
  /// channel's in turn.
  std::vector<Wire> wires;
  std::atomic<bool> lost{false};  ///< by the end of a wire, or the server went away or changed its rate
  const int sample_rate;
  std::atomic<int> new_rate{0};  ///< [Hz] that the server changed to; 0: it did not
  std::atomic<int> block_frames;
  std::atomic<int> rewirings{0};    ///< how often wires were connected or disconnected
  std::atomic<int> output_cuts{0};  ///< how often one of an output was disconnected

 private:
  Client(_jack_client* opened, std::unique_ptr<ClientHold> hold);
  static Client& client(void* self) { return *static_cast<Client*>(self); }
  void set_callbacks();
  Names connections_of(const std::string& port) const;
  bool is_of_device(const _jack_port* port) const;
  void note_rate(int rate) noexcept;
  void note_xrun() noexcept;
  void note_connection(std::uint32_t from, std::uint32_t to);
  void note_disconnection(std::uint32_t from, std::uint32_t to);
  void note_removal(std::uint32_t port);
  void note_rename(std::uint32_t port, const std::string& before);
  void process(int frames) noexcept;
  void note_lost_frames(int frames) noexcept;

  const std::unique_ptr<ClientHold> hold_;
  std::mutex requests_;  ///< the answers to two threads that ask the server at once are mixed up
  MidiIn midi_;
  std::mutex passing_mutex_;
  std::vector<OtherWriter> passing_writers_;
  std::vector<_jack_port*> inputs_, outputs_;
  std::vector<const float*> in_;
  std::vector<float*> out_;
  std::atomic<bool> freewheels_{false};  ///< blocks come as fast as they can
  bool first_ = true;
  std::uint32_t next_frame_ = 0;  ///< where the next block should begin, on the server's clock
};

}  // namespace tactus::jack
