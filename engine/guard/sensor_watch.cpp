#include "engine/guard/sensor_watch.h"

#include <algorithm>
#include <cmath>

#include "engine/core/every_block.h"

namespace tactus {
namespace {

/// A run of frames that are alike, of which `before` came earlier.
struct Run {
  std::int64_t at_end;  ///< how long it is behind the last frame
  std::int64_t full;    ///< the frame at which it reached `patience`, or -1
};

/// `frames` <= patience, so that only the run from before can become full. For a living sensor, whose first
/// and last frames are unlike those before, this looks at two frames.
template <class Alike>
Run follow(std::int64_t before, std::int64_t patience, int frames, Alike alike) noexcept {
  int leading = 0;
  while (leading < frames && alike(leading)) ++leading;
  const auto full =
      leading > 0 && before + leading >= patience ? std::max<std::int64_t>(0, patience - before - 1) : -1;
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
  const auto same = follow(same_, patience_, frames,
                           [&](int n) { return samples[n] == previous(n) || std::isnan(samples[n]); });
  const auto railed = follow(railed_, patience_, frames, [&](int n) {
    return std::abs(samples[n]) >= kRail && std::abs(previous(n) - samples[n]) < kRail;
  });
  const bool was_noisy = noisy_;
  detect_noise(samples, frames);
  same_ = same.at_end;
  railed_ = railed.at_end;
  before_ = frames > 1 ? samples[frames - 2] : last_;
  last_ = samples[frames - 1];
  if (reported_) return std::nullopt;
  const bool stuck = was_noisy && same.full >= 0;
  if (railed.full < 0 && !stuck) return std::nullopt;
  reported_ = true;
  if (railed.full >= 0 && (!stuck || railed.full <= same.full))
    return Found{static_cast<int>(railed.full), Fault::Railed};
  return Found{static_cast<int>(same.full), Fault::Stuck};
}

void SensorWatch::detect_noise(const double* samples, int frames) noexcept {
  if (noisy_) return;
  double last = last_, before = before_;
  for (int n = 0; n < frames; ++n) {
    turns_ += (samples[n] - last) * (last - before) < 0.0 ? 1 : 0;
    before = last;
    last = samples[n];
  }
  observed_ += frames;
  if (observed_ < kWindow) return;
  noisy_ = 3 * turns_ > kWindow;
  observed_ = turns_ = 0;
}

}  // namespace tactus
