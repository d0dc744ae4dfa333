#pragma once
// Thread: [control]

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "backends/take/take.h"
#include "backends/wav_file.h"
#include "engine/guard/guarded.h"

namespace tactus {

/// What is played into a processor, a block after the other, whatever its length.
struct OfflineInput {
  Hertz sample_rate = 48_kHz;
  int channels = 0;
  std::int64_t frames = 0;
  /// The next `count` frames into to[channel][0 …].
  std::function<void(double* const* to, int count)> read;
};
/// Samples in memory, which outlive it.
OfflineInput offline_input(const Samples& samples);

/// Prepares `processor` and runs it on `input`, without hardware and without a clock, as fast as the machine
/// goes. Non-finite samples become 0. Block sizes (at least one, >= 1 frame each) are used in turn and over
/// again; the last block is as long as what is left. `sink` takes each block of outputs. However the run
/// ends, the processor gets one block more, in `Guarded::finish`. Errors: those of `prepare` and of `sink`.
[[nodiscard]] Status run_offline(Guarded& processor, const OfflineInput& input, int out_channels,
                                 const std::vector<int>& block_frames,
                                 const std::function<Status(const double* const* out, int frames)>& sink);

/// What a take is played through. The entries of the engine (`Take::engine`) are its own affair: give them to
/// Player::set_journal.
struct ReplayHost {
  Guarded& guarded;          ///< the same: made with `guard` and `armed` of the header
  std::vector<int> sensors;  ///< [input] its recorded sensor; -1: silence
  int out_channels = 0;
  std::function<Status(const TakeEdit&)>
      replace;       ///< puts it in place for the next block; empty: edits are left out
  bool same = true;  ///< it is what was recorded, and its drives are compared
};

struct Replayed {
  /// Where drives are not what was recorded.
  struct Difference {
    std::int64_t frame;
    int channel;
    float recorded, replayed;
  };
  std::int64_t frames = 0;
  std::optional<Difference> first_difference;
};

/// [control] How far it can be replayed: to where both the samples and the journal are whole.
std::int64_t frames_to_replay(const Take& take, const WavReader& wav);

/// [control] Prepares `guarded` and plays the take through it, in blocks of these sizes in turn: they do not
/// matter. `sink` takes the drives. Errors: BadFile if the WAV is not that of the take; those of `prepare`,
/// `replace` and `sink`.
Result<Replayed> replay(const Take& take, WavReader& wav, const ReplayHost& host,
                        const std::vector<int>& block_frames,
                        const std::function<Status(const double* const*, int)>& sink);

}  // namespace tactus
