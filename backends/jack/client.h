#pragma once
// Thread: [control] unless stated otherwise

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "backends/card_callback.h"
#include "backends/library_calls.h"

struct _jack_client;  // as JACK calls them
struct _jack_port;

namespace tactus::jack {

/// From one port to another, by their full names.
struct Wire {
  std::string from, to;
};

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

  _jack_client* handle() const { return handle_; }
  double sample_rate() const;
  int block_frames() const { return block_frames_.load(); }

  /// [control & inactive, may hang] Ports in_1, in_2, … and out_1, out_2, … Errors: Device.
  Status add_ports(int inputs, int outputs);
  std::string input_port(int channel) const;
  std::string output_port(int channel) const;
  /// [control & inactive] Plays through `callback`, and is lost when an end of a wire goes away. Wires to the
  /// inputs come first, each channel's in turn.
  void play_through(std::unique_ptr<CardCallback> callback, std::vector<Wire> wires);
  CardCallback& callback() const { return *callback_; }
  const std::vector<Wire>& wires() const { return wires_; }
  /// [control, may hang] Blocks come, and every wire is connected. Errors: Device.
  Status activate();
  /// [control, may hang]
  void deactivate();

  /// [any] The server went away, or the other end of a wire did.
  bool lost() const { return lost_.load(); }
  /// [any] How often wires were connected or disconnected.
  int rewirings() const { return rewirings_.load(); }
  /// [control & active] For each wire: is it connected?
  std::vector<bool> connected() const;

 private:
  explicit Client(_jack_client* handle);
  void set_callbacks();
  void process(int frames) noexcept;
  void note_lost_frames(int frames) noexcept;
  void check_ports();

  _jack_client* handle_;
  std::vector<_jack_port*> inputs_, outputs_;
  std::vector<const float*> in_;
  std::vector<float*> out_;
  std::vector<Wire> wires_;
  std::unique_ptr<CardCallback> callback_;
  std::atomic<bool> lost_{false};
  std::atomic<int> block_frames_, rewirings_{0};
  bool first_ = true;
  std::uint32_t next_frame_ = 0;  ///< where the next block should begin, on the server's clock
};

/// [control] The server did not answer. Errors: Device, always.
tl::unexpected<Error> no_answer();

/// [control] A call that may hang; gives up after two seconds. `call` owns whatever it touches and returns a
/// Result.
template <class Call>
auto ask_server(Call call) -> decltype(call()) {
  if (auto answer = result_with_timeout(std::move(call))) return std::move(*answer);
  return no_answer();
}

}  // namespace tactus::jack
