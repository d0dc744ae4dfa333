#pragma once
// Thread: [realtime] unless stated otherwise

#include <array>
#include <vector>

#include "engine/core/units.h"
#include "engine/guard/feedback_regression.h"
#include "engine/guard/guard_group.h"

namespace tactus {

/// A known pattern in the gain g of a drive, and whether what the drive is asked to do follows it. Through a
/// loop the wanted signal is the past output, w(t) = G y(t - D), so its level falls and rises with every dip
/// of the output, D later; an outside signal does not know the pattern. Levels are logarithms of the power of
/// slots, each smoothed with the same time constant s:
///
///   A  of the wanted signal,  U  of what the limits left of it,  Y = U with the gain g
///   r_k = A_k - U_{k-m},  x_k = Y_{k-m} - U_{k-m}      lag m, s of 1, 4, 8 and 16 slots
///   r_k = a + b k + β x_k + ε_k                        (feedback_regression.h)
///   R   = exp(mean(r - x))                             how much louder than the output it returns
///
/// A - U cancels what the signal does by itself where it returns. A pure loop has β = 1 and R = G, whatever
/// its delay; an outside signal has β = 0; of a stable loop, β R is the gain at most. So feedback is
///
///   β near 1  and  β R > 0.9  and  t > 8 (1 + log2(s) / 2),  after at least seven changes of the gain
///
/// for a lag and a smoothing. The pattern alternates 0 and -6 dB for lengths that grow from 3 to 29 slots, so
/// that no tremolo follows it. In a long pattern slots that are silent in A and in U_{k-m}, as a hole that
/// goes round in a loop is, say nothing and do not count.
///
///           slot (at 48 kHz)     pattern             lags         β
///   short   64 frames, 1.3 ms    4 to 39 ms, 0.25 s  up to 48 ms  0.6 to 1.7
///   long    256 frames, 5.3 ms   16 to 155 ms, 1 s   up to 0.5 s  0.7 to 1.4, for a third of a second: of
///   more lags more fit by chance
class FeedbackProbe {
 public:
  struct Reach {
    double slots_per_second;
    int lags;
    double least_response, most_response;  ///< of a loop
    int least_fits;                        ///< slots in a row in which one lag fits
  };
  static constexpr Reach kShort{750.0, 37, 0.6, 1.7, 1}, kLong{187.5, 95, 0.7, 1.4, 64};

  /// [control]
  FeedbackProbe(Hertz sample_rate, double ceiling);

  /// The gain is not 1 or may leave it.
  bool active() const noexcept { return running_ || muted_ || !gain_.idle(); }
  /// The pattern is running.
  bool running() const noexcept { return running_; }
  double gain_at(int position) const noexcept { return gain_.at(position); }
  void begin(const Reach& reach) noexcept;
  /// Without a result.
  void stop() noexcept { running_ = false; }
  /// Takes the drive to silence and back, in 5 and 21 ms at 48 kHz, while no pattern runs.
  void mute(bool on) noexcept { muted_ = on; }
  /// A frame while `active`: what was wanted, and what the limits left of it, before the gain.
  void observe(double wanted, double allowed, int position) noexcept {
    const double out = gain_at(position) * allowed;
    wanted_ += wanted * wanted;
    allowed_ += allowed * allowed;
    out_ += out * out;
  }
  /// A group is over. True: the wanted signal follows the pattern.
  bool end_group() noexcept;
  void forget() noexcept;

 private:
  static constexpr int kLags = kLong.lags;
  using Regressions = FeedbackRegressions<kLags>;
  /// Smoothing of the wanted signal and of the output, in slots. They differ where a resonance smooths.
  struct Smoothing {
    int wanted, out;
  };
  static constexpr std::array<Smoothing, 5> kSmoothings{{{1, 1}, {4, 4}, {4, 16}, {8, 8}, {16, 16}}};
  struct Levels {
    double wanted = 0.0, allowed = 0.0, out = 0.0;  ///< smoothed powers
    Regressions::Values u{}, x{};                   ///< [lag] of the slot so many before this one
    Regressions regressions;                        ///< [lag]
    std::array<unsigned char, kLags> fits{};        ///< slots in a row in which each lag fits
  };

  bool end_slot() noexcept;
  bool advance(Levels& levels, const Smoothing& smoothing) noexcept;
  bool is_feedback(const Regressions& regressions, const Regressions::Estimate& estimate, std::size_t lag,
                   int smoothing) const noexcept;
  void next_run() noexcept;

  int groups_in(const Reach& reach) const noexcept;

  Hertz sample_rate_;
  double ceiling_;
  Reach reach_ = kShort;
  int groups_ = 1;      ///< of a slot
  double floor_ = 0.0;  ///< added to the power of a slot
  GroupGain gain_;
  bool running_ = false, muted_ = false;
  int group_ = 0, slot_ = 0, run_ = 0, left_ = 0;
  std::array<int, kLags> runs_{};                    ///< [lag] of the slot so many before this one
  double wanted_ = 0.0, allowed_ = 0.0, out_ = 0.0;  ///< sums of squares of this slot
  std::vector<Levels> levels_;
};

}  // namespace tactus
