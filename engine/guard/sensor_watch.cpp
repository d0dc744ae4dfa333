#include "engine/guard/sensor_watch.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "engine/core/every_block.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {
namespace {

constexpr int kAllLanes = (1 << Lanes::kCount) - 1;

/// Whether each sample is `value`; a NaN is not.
bool all_are(double value, const double* samples, int frames) noexcept {
  const auto wanted = Lanes::broadcast(value);
  int n = 0, same = kAllLanes;
  for (; n + Lanes::kCount <= frames; n += Lanes::kCount) {
    const auto here = Lanes::load(samples + n);
    same &= at_least(here, wanted) & at_least(wanted, here);
  }
  return same == kAllLanes &&
         std::all_of(samples + n, samples + frames, [value](double sample) { return sample == value; });
}

/// Whether a signal turns back at a sample.
bool turns(double before, double last, double sample) noexcept {
  return (sample - last) * (last - before) < 0.0;
}

/// At how many samples from the third on.
int count_turns(const double* samples, int frames) noexcept {
  int count = 0, n = 2;
  for (; n + Lanes::kCount <= frames; n += Lanes::kCount) {
    const auto last = Lanes::load(samples + n - 1);
    const auto product = (Lanes::load(samples + n) - last) * (last - Lanes::load(samples + n - 2));
    const auto zero = Lanes::broadcast(0.0);
    count += std::popcount(static_cast<unsigned>(at_least(zero, product) & ~at_least(product, zero)));
  }
  for (; n < frames; ++n) count += turns(samples[n - 2], samples[n - 1], samples[n]) ? 1 : 0;
  return count;
}

/// A run of frames that are alike, of which `before` came earlier.
struct Run {
  std::int64_t at_end;  ///< how long it is behind the last frame
  std::int64_t full;    ///< the frame at which it reached `patience`, or -1
};

/// The frame of a run of `leading` more at which it becomes full, or -1.
std::int64_t full_at(std::int64_t before, std::int64_t patience, int leading) noexcept {
  return leading > 0 && before + leading >= patience ? std::max<std::int64_t>(0, patience - before - 1) : -1;
}

/// `frames` <= patience, so that only the run from before can become full. For a living sensor, whose first
/// and last frames are unlike those before, this looks at two frames.
template <class Alike>
Run follow(std::int64_t before, std::int64_t patience, int frames, Alike alike) noexcept {
  int leading = 0;
  while (leading < frames && alike(leading)) ++leading;
  const auto full = full_at(before, patience, leading);
  if (leading == frames) return {before + leading, full};
  int trailing = frames;
  while (alike(trailing - 1)) --trailing;
  return {frames - trailing, full};
}

}  // namespace

TACTUS_EVERY_BLOCK std::optional<SensorWatch::Found> SensorWatch::observe(const double* samples,
                                                                          int frames) noexcept {
  std::optional<Found> found;
  for (int done = 0; done < frames;) {
    const int part =
        static_cast<int>(std::min<std::int64_t>({frames - done, kWindow - observed_, patience_}));
    const auto here = observe_part(samples + done, part);
    if (here && !found) found = Found{done + here->frame, here->fault};
    done += part;
  }
  return found;
}

TACTUS_EVERY_BLOCK std::optional<SensorWatch::Found> SensorWatch::observe_part(const double* samples,
                                                                               int frames) noexcept {
  const auto previous = [&](int n) { return n > 0 ? samples[n - 1] : last_; };
  const bool rests = all_are(last_, samples, frames);
  const auto same = rests ? Run{same_ + frames, full_at(same_, patience_, frames)}
                          : follow(same_, patience_, frames, [&](int n) {
                              return samples[n] == previous(n) || std::isnan(samples[n]);
                            });
  const auto railed = follow(railed_, patience_, frames, [&](int n) {
    return std::abs(samples[n]) >= kRail && std::abs(previous(n) - samples[n]) < kRail;
  });
  const bool was_noisy = noisy_;
  if (!noisy_) {
    if (!rests) {
      turns_ += turns(before_, last_, samples[0]) ? 1 : 0;
      if (frames > 1) turns_ += turns(last_, samples[0], samples[1]) ? 1 : 0;
      turns_ += count_turns(samples, frames);
    }
    detect_noise(frames);
  }
  same_ = same.at_end;
  railed_ = railed.at_end;
  before_ = previous(frames - 1);
  last_ = samples[frames - 1];
  if (reported_) return std::nullopt;
  const bool stuck = was_noisy && same.full >= 0;
  if (railed.full < 0 && !stuck) return std::nullopt;
  reported_ = true;
  if (railed.full >= 0 && (!stuck || railed.full <= same.full))
    return Found{static_cast<int>(railed.full), Fault::Railed};
  return Found{static_cast<int>(same.full), Fault::Stuck};
}

/// The turns of so many further frames are counted.
inline void SensorWatch::detect_noise(int frames) noexcept {
  observed_ += frames;
  if (observed_ < kWindow) return;
  noisy_ = 3 * turns_ > kWindow;
  observed_ = turns_ = 0;
}

}  // namespace tactus
