#pragma once

#include <optional>
#include <string>

#include "tests/cards/ways.h"

namespace tactus::test {

/// A real ALSA card with a cable from its outputs to its inputs: snd-aloop's, in the virtual machine that
/// scripts/vm/run starts. There are two, equal but for their names.
class CableCard {
 public:
  /// Plugs card 1 or 2 in. Skips the test case outside of the virtual machine.
  explicit CableCard(int number = 1);
  /// Leaves it plugged in: the next test case finds both.
  ~CableCard();
  CableCard(const CableCard&) = delete;
  CableCard& operator=(const CableCard&) = delete;

  void plug() const;
  /// Takes it away from under whoever has it open.
  void pull() const;
  const std::string& name() const { return name_; }  ///< "CableA"
  /// Its two sides, as devices of a library; empty: not listed now.
  std::optional<Device> output_of(Backend& backend) const { return side(backend, 0); }
  std::optional<Device> input_of(Backend& backend) const { return side(backend, 1); }
  /// Both sides as one stream.
  StreamRequest request(Backend& backend, double rate, int block, int channels = 1) const;

 private:
  std::optional<Device> side(Backend& backend, int device) const;

  int number_;
  std::string name_;
};

/// RtAudio and PortAudio, as far as this build has them, over ALSA.
std::vector<Way> alsa_ways();

}  // namespace tactus::test
