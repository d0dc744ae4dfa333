#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"

namespace tactus::test {

/// A real PipeWire server with its session manager and one virtual device, "cable": a null sink, whose
/// monitor gives out what was played. It runs in a folder of its own: no other server of the user is touched.
/// From its beginning to its end, this process and those that it begins use this server, over JACK's
/// interface if they are begun by `over_jack`, and as ALSA's default device.
class PipeWire {
 public:
  /// Skips the test case where PipeWire is not installed.
  PipeWire();
  ~PipeWire();
  PipeWire(const PipeWire&) = delete;
  PipeWire& operator=(const PipeWire&) = delete;

  /// Whether this build can play on it as an ALSA device.
  static bool has_alsa();
  /// The sample rate of the graph, under whoever is running; 0: the clients' choice.
  void force_rate(int rate) const;
  /// [frames] The block of the graph; 0: the clients' choice.
  void force_block(int frames) const;
  /// The command, with PipeWire's JACK library in the place of JACK's.
  static std::vector<std::string> over_jack(std::vector<std::string> command);

 private:
  void set(const std::string& key, int value) const;
  bool has_cable() const;

  TemporaryFolder folder_;
  std::unique_ptr<ChildProcess> server_;
};

}  // namespace tactus::test
