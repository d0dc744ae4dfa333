#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "tests/cards/ways.h"
#include "tests/support/child_process.h"

namespace tactus::test {

/// How long to wait for what happens in the virtual machine, which is slow.
inline constexpr std::chrono::milliseconds kSlowMachine = std::chrono::seconds{120};

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
  std::string id() const { return number_ == 1 ? "CableA" : "CableB"; }  ///< ALSA's
  /// Device::hardware begins with it. The names of both cards are equal.
  std::string hardware() const { return "snd_aloop." + std::to_string(number_ - 1); }
  /// Its two sides, as devices of a library; empty: not listed now.
  std::optional<Device> output_of(Backend& backend) const { return side(backend, 0); }
  std::optional<Device> input_of(Backend& backend) const { return side(backend, 1); }
  /// Both sides as one stream.
  StreamRequest request(Backend& backend, double rate, int block, int channels = 1) const;

 private:
  std::optional<Device> side(Backend& backend, int device) const;
  bool is_side(const Device& listed, int device) const;

  int number_;
};

/// Plays, or records, one side of a card as another program, in 16 bit with two channels at 48 kHz: aplay and
/// arecord. While it does, the other end of the cable has no other format. Skips the test case where they are
/// not installed.
class OtherProgram {
 public:
  /// `file`: raw samples.
  static OtherProgram plays(const CableCard& card, int device, const std::string& file);
  static OtherProgram records(const CableCard& card, int device, const std::string& file);
  void end() { process_->terminate(); }

 private:
  OtherProgram(const CableCard& card, const std::string& program, int device, const std::string& file);

  std::unique_ptr<ChildProcess> process_;
};

/// MIDI ports of the kernel's own (snd-virmidi): what is written to it arrives at its sequencer port.
class VirtualKeyboard {
 public:
  /// Skips the test case outside of the virtual machine.
  VirtualKeyboard();
  void plug() const;
  void pull() const;
  void play(const std::array<std::uint8_t, 3>& bytes) const;
};

/// RtAudio and PortAudio, as far as this build has them, over ALSA.
std::vector<Way> alsa_ways();

}  // namespace tactus::test
