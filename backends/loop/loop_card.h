#pragma once

#include <string>
#include <vector>

#include "backends/paced/paced_stream.h"
#include "engine/core/error.h"
#include "engine/core/units.h"

namespace tactus {

/// A simulated sound card with a cable from its outputs to its inputs, and everything that can go wrong with
/// one. What is played at frame n is recorded at frame n + D:
///   D = delay + delay_frames + delay_blocks * block
struct LoopCard {
  enum class Cable {
    Straight,  ///< every output reaches the input of its number
    Crossed,   ///< on the next one
    None,
  };
  /// Input frames that never arrive (positive), or arrive twice.
  struct Drop {
    Seconds at;
    Seconds every{0.0};  ///< 0: once
    int frames = 0;
  };

  // The path.
  Seconds delay{0.0};
  double delay_frames = 0.0;  ///< any fraction
  int delay_blocks = 0;       ///< in the driver's buffers
  Cable cable = Cable::Straight;
  double gain = 1.0;   ///< negative: inverted
  Hertz high_pass{0};  ///< corner of the coupling capacitor; 0: none
  double noise = 0.0;  ///< rms
  double dc = 0.0;
  double clip = 1.0;  ///< the input ends there
  int bits = 0;       ///< of both converters; 0: no steps

  // What else happens to it.
  bool agc = false;          ///< towards peaks of 0.1, with gains up to 40 dB
  bool echo_cancel = false;  ///< an adaptive filter fed with what is played
  /// What is captured is played too: in hardware whatever the block, in software as late as all that is
  /// played.
  double monitor_gain = 0.0;
  bool monitor_in_software = false;
  std::vector<Drop> drops;
  bool drops_reported = true;  ///< as gaps in Health
  double input_ppm = 0.0;      ///< by which the input's clock is faster than the output's

  // What the driver makes of it.
  int unstable_frames = 0;    ///< the delay is longer by up to that, another time at each opening
  int unstable_blocks = 0;    ///< the same in blocks
  double rate_factor = 1.0;   ///< of the rate at which it truly runs
  double block_factor = 1.0;  ///< of the frames that a block truly has; (0, 1]
  bool real_time = true;      ///< false: blocks come as fast as they are processed
  /// Blocks of one frame, at 1 to 20 kHz, by the loop that data acquisition cards have.
  bool per_sample = false;
  PacedSettings pace;  ///< of that loop
};

/// [any] A device id without its "loop:": the name of one of `loop_cards`, or settings such as
///   delay=960.25,gain=-20dB,noise=-80dB,ppm=50
/// after the name of a card, or by themselves. Errors: UnknownName.
Result<LoopCard> loop_card(const std::string& text);

struct NamedLoopCard {
  const char* name;
  const char* about;
  const char* settings;  ///< besides a delay of 20 ms, noise of -90 dB and 24 bits
};
/// [any] The first is the default.
const std::vector<NamedLoopCard>& loop_cards();

}  // namespace tactus
