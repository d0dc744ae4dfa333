#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "tests/support/child_process.h"

namespace tactus::test {

/// A real JACK server on its dummy driver, under a name of its own, for the life of this object: the default
/// server of this process and of those that it begins. All calls return when what they say has happened.
///
/// Begin it by `start_sound_server`, before whatever uses it, so that it ends after it.
class SoundServer {
 public:
  struct Settings {
    int rate = 48000;
    int period = 256;         ///< [frames] shorter ones lose frames on a virtual machine
    int channels = 8;         ///< of the device "system", each way
    bool synchronous = true;  ///< one late client is one xrun; otherwise it is left out and the others go on
  };

  ~SoundServer();
  const std::string& name() const { return name_; }
  const Settings& settings() const { return settings_; }

  void kill();            ///< SIGKILL
  void stop_answering();  ///< SIGSTOP
  void go_on();           ///< SIGCONT
  void restart();         ///< after `kill`; under the same name

  void set_period(int frames);
  /// Frames run as fast as clients can.
  void freewheel(bool on);
  /// Takes away every connection of a client.
  void disconnect(const std::string& client);
  void connect(const std::string& from_port, const std::string& to_port);
  /// Ports that are connected to this one, in no order, one a line.
  std::string connections(const std::string& port);

 private:
  friend std::unique_ptr<SoundServer> start_sound_server(const SoundServer::Settings& settings);
  SoundServer() = default;

  bool begin();
  bool try_to_begin();
  std::string why_not();
  void end();
  std::string ask(const std::string& question);

  Settings settings_;
  std::string name_;
  int lock_ = -1;               ///< no other test has this name while it is open
  bool first_of_user_ = false;  ///< no other server of the user was there before
  std::unique_ptr<ChildProcess> server_;
  std::unique_ptr<ChildProcess> hand_;  ///< a client that changes other clients as asked
};

/// Skips the test case where no JACK server can run.
std::unique_ptr<SoundServer> start_sound_server(const SoundServer::Settings& settings = {});

/// A sound card of known delay: a JACK client in a process of its own. What goes into `NAME:playback_1` comes
/// out of `NAME:capture_1` exactly `delay_frames` later, and so on for every channel; JACK adds one period
/// for the loop through two clients.
class DelayClient {
 public:
  struct Settings {
    std::string name = "card";  ///< the process id is added: names must differ between all servers of a user
    int channels = 2;
    double delay_frames = 960;  ///< a fraction needs at least 32; whole ones change no bit
    double gain = 1.0;
    double noise = 0.0;     ///< [full scale] peak of what is added, white
    int input_latency = 0;  ///< [frames] what it says of itself
    int output_latency = 0;
    bool reversed = false;                    ///< the ports of the last channel are registered first
    std::string hardware = "dummy_pcm:CARD";  ///< what its driver calls it; empty: the server does not know
  };

  explicit DelayClient(const Settings& settings);
  DelayClient() : DelayClient(Settings{}) {}
  ~DelayClient();

  /// As JACK calls it.
  const std::string& name() const { return name_; }
  /// Its next callback takes this long, once. Returns when that is over and the server reported an xrun to
  /// it, or half a second later.
  void sleep_once(std::chrono::milliseconds time);
  /// That the server reported to it, since it began.
  std::int64_t xruns();
  /// Of the process, for faults of your own.
  ChildProcess& process() { return *process_; }

 private:
  std::string name_;
  std::unique_ptr<ChildProcess> process_;
};

}  // namespace tactus::test
