#pragma once

// Thread: [realtime].

#include "engine/dsp/envelopes/stroke_kernel.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// `tactus_stroke_filter`, vectorised.
inline void filter_stroke(const tactus_stroke& s, tactus_stroke_bank& bank, const double* in,
                          int samples) noexcept {
  const auto load = [](const double* x) { return Lanes::load(x); };
  const Lanes b0 = load(s.b0), b1 = load(s.b1), b2 = load(s.b2), a1 = -load(s.a1), a2 = -load(s.a2);
  Lanes first = load(bank.first), second = load(bank.second), sum = load(bank.sum);
  for (int n = 0; n < samples; ++n) {
    const Lanes x = Lanes::broadcast(in[n]);
    const Lanes y = fused_multiply_add(b0, x, first);
    first = fused_multiply_add(b1, x, fused_multiply_add(a1, y, second));
    second = fused_multiply_add(b2, x, a2 * y);
    sum = fused_multiply_add(y, y, sum);
  }
  first.store(bank.first);
  second.store(bank.second);
  sum.store(bank.sum);
}

/// `tactus_stroke_judge`, vectorised.
inline double judge_stroke(const tactus_stroke_net& net,
                           const tactus_real x[TACTUS_STROKE_FEATURES][TACTUS_STROKE_BANDS],
                           const tactus_real after[TACTUS_STROKE_AGES]) noexcept {
  static_assert(TACTUS_STROKE_JOINT == 2 * Lanes::kCount && TACTUS_STROKE_HIDDEN % 4 == 0);
  const Lanes slope = Lanes::broadcast(0.05), zero = Lanes::broadcast(0);
  struct Sums {
    Lanes low, high;

    void add(double number, const tactus_real* weights) noexcept {
      const Lanes all = Lanes::broadcast(number);
      low = fused_multiply_add(all, Lanes::load(weights), low);
      high = fused_multiply_add(all, Lanes::load(weights + 8), high);
    }
  };
  Sums even{Lanes::load(net.joint_bias), Lanes::load(net.joint_bias + 8)}, odd{zero, zero};
  for (int i = 0; i < TACTUS_STROKE_AGES; ++i) odd.add(after[i], net.age[i]);
  for (int j = 0; j < TACTUS_STROKE_HIDDEN; j += 4) {
    // Four units at a time, because each is one chain of additions.
    Lanes h0 = Lanes::load(net.band_bias[j]), h1 = Lanes::load(net.band_bias[j + 1]);
    Lanes h2 = Lanes::load(net.band_bias[j + 2]), h3 = Lanes::load(net.band_bias[j + 3]);
    for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i) {
      const Lanes number = Lanes::load(x[i]);
      h0 = fused_multiply_add(number, Lanes::broadcast(net.band[i][j]), h0);
      h1 = fused_multiply_add(number, Lanes::broadcast(net.band[i][j + 1]), h1);
      h2 = fused_multiply_add(number, Lanes::broadcast(net.band[i][j + 2]), h2);
      h3 = fused_multiply_add(number, Lanes::broadcast(net.band[i][j + 3]), h3);
    }
    double bent[4][TACTUS_STROKE_BANDS];
    max(h0, slope * h0).store(bent[0]);
    max(h1, slope * h1).store(bent[1]);
    max(h2, slope * h2).store(bent[2]);
    max(h3, slope * h3).store(bent[3]);
    for (int k = 0; k < 4; ++k)
      for (int b = 0; b < TACTUS_STROKE_BANDS; b += 2) {
        even.add(bent[k][b], net.joint[b * TACTUS_STROKE_HIDDEN + j + k]);
        odd.add(bent[k][b + 1], net.joint[(b + 1) * TACTUS_STROKE_HIDDEN + j + k]);
      }
  }
  const Lanes low = even.low + odd.low, high = even.high + odd.high;
  return fused_multiply_add(max(high, slope * high), Lanes::load(net.last + 8),
                            max(low, slope * low) * Lanes::load(net.last))
             .sum() +
         net.last_bias;
}

/// `tactus_stroke_windows`, vectorised.
inline void stroke_windows(tactus_stroke& s) noexcept {
  const int all = TACTUS_STROKE_PAST - 1;
  Lanes loudest = Lanes::load(s.loud[s.slot]);
  Lanes steepest = loudest - Lanes::load(s.loudest[(s.slot - s.net->lookahead) & all]);
  steepest.store(s.rise[s.slot]);
  for (int i = 1; i < 8; ++i) {
    loudest = max(loudest, Lanes::load(s.loud[(s.slot - i) & all]));
    steepest = max(steepest, Lanes::load(s.rise[(s.slot - i) & all]));
  }
  loudest.store(s.loudest[s.slot]);
  steepest.store(s.steepest[s.slot]);
}

/// `tactus_stroke_numbers`, vectorised.
inline void stroke_numbers(tactus_stroke& s) noexcept {
  const int k = s.net->lookahead, early_from = tactus_stroke_early(k);
  const auto at = [&](const tactus_real past[][TACTUS_STROKE_BANDS], int ago) {
    return Lanes::load(past[(s.slot - ago) & (TACTUS_STROKE_PAST - 1)]);
  };
  const Lanes now = at(s.loud, 0), r1 = at(s.loudest, k);
  const Lanes r2 = max(at(s.loudest, k + 8), at(s.loudest, k + 16));
  const Lanes r3 = max(max(at(s.loudest, k + 24), at(s.loudest, k + 32)),
                       max(at(s.loudest, k + 40), at(s.loudest, k + 48)));
  const Lanes m12 = max(r1, r2), floor = Lanes::load(s.floor_db);
  const Lanes sum = Lanes::load(s.mean_sum) + (at(s.loud, k) - at(s.loud, k + 24));
  Lanes early = at(s.loud, k - 1);
  for (int i = early_from; i < k - 1; ++i) early = max(early, at(s.loud, i));
  Lanes recent = early;
  for (int i = 0; i < early_from; ++i) recent = max(recent, at(s.loud, i));
  const Lanes steepest = max(max(max(at(s.steepest, k + 2), at(s.steepest, k + 10)),
                                 max(at(s.steepest, k + 18), at(s.steepest, k + 26))),
                             at(s.steepest, k + 32));
  sum.store(s.mean_sum);
  recent.store(s.recent);
  const Lanes numbers[] = {now - r1,   recent - r1,    recent - m12, recent - max(m12, r3),
                           early - r1, r1 - r2,        r2 - r3,      m12 - sum * Lanes::broadcast(1.0 / 24),
                           r1 - floor, recent - floor, steepest,     recent - Lanes::load(s.struck)};
  const Lanes low = Lanes::broadcast(-25), high = Lanes::broadcast(40), scale = Lanes::broadcast(0.1);
  for (int i = 0; i < TACTUS_STROKE_FEATURES; ++i) (min(max(numbers[i], low), high) * scale).store(s.x[i]);
}

/// `tactus_stroke_follow`, vectorised.
inline int follow_stroke(tactus_stroke& s, const double* in, const double* reference, int samples,
                         double threshold, double hold) noexcept {
  tactus_stroke_measure(&s, in, samples);
  filter_stroke(s, s.heard, in, samples);
  if (reference) filter_stroke(s, s.thrown, reference, samples);
  if (!tactus_stroke_ends(&s, samples)) return 0;
  tactus_stroke_levels(&s, reference != nullptr);
  tactus_stroke_age(&s);
  stroke_windows(s);
  stroke_numbers(s);
  return tactus_stroke_decide(&s, judge_stroke(*s.net, s.x, s.after), threshold, hold);
}

}  // namespace tactus
