#pragma once

// Thread: [any].

#include "engine/dsp/kernel.h"

// The functions of engine/core/math_functions.h in C, with the same bits: see there for their errors. Only
// for numbers that are doubles.

/// The unevaluated sum of two doubles.
typedef struct tactus_pair {
  tactus_real high, low;
} tactus_pair;

typedef unsigned long long tactus_bits;

typedef union tactus_number_bits {
  tactus_real number;
  tactus_bits bits;
} tactus_number_bits;

static inline tactus_bits tactus_bits_of(tactus_real number) {
  tactus_number_bits both;
  both.number = number;
  return both.bits;
}
static inline tactus_real tactus_number_of(tactus_bits bits) {
  tactus_number_bits both;
  both.bits = bits;
  return both.number;
}

static inline tactus_pair tactus_pair_of(tactus_real high, tactus_real low) {
  tactus_pair pair;
  pair.high = high;
  pair.low = low;
  return pair;
}
static inline tactus_pair tactus_exact_sum(tactus_real a, tactus_real b) {
  const tactus_real sum = a + b, b_taken = sum - a;
  return tactus_pair_of(sum, (a - (sum - b_taken)) + (b - b_taken));
}
/// The first 26 bits of `a`, and the rest. |a| < 1e300.
static inline tactus_pair tactus_halves(tactus_real a) {
  const tactus_real c = 134217729.0 * a;
  const tactus_real high = c - (c - a);
  return tactus_pair_of(high, a - high);
}
static inline tactus_pair tactus_exact_product(tactus_real a, tactus_real b) {
  const tactus_real product = a * b;
  const tactus_pair x = tactus_halves(a), y = tactus_halves(b);
  return tactus_pair_of(product,
                        ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low);
}
static inline tactus_pair tactus_pair_product(tactus_pair a, tactus_pair b) {
  const tactus_pair p = tactus_exact_product(a.high, b.high);
  return tactus_pair_of(p.high, p.low + (a.high * b.low + a.low * b.high));
}

/// c[0] + c[1] x + c[2] x^2 + …
static inline tactus_real tactus_series(tactus_real x, const tactus_real* c, int count) {
  tactus_real sum = c[--count];
  while (count > 0) sum = c[--count] + x * sum;
  return sum;
}

static inline tactus_real tactus_magnitude(tactus_real x) { return x < 0 ? -x : x; }
static inline tactus_real tactus_clamped(tactus_real x, tactus_real low, tactus_real high) {
  return x < low ? low : x > high ? high : x;
}

/// |x| < 2^51; `bits`: modulo 2^51.
typedef struct tactus_rounded {
  tactus_real value;
  tactus_bits bits;
} tactus_rounded;

static inline tactus_rounded tactus_nearest_whole(tactus_real x) {
  const tactus_real sum = x + 0x1.8p52;
  tactus_rounded rounded;
  rounded.value = sum - 0x1.8p52;
  rounded.bits = tactus_bits_of(sum);
  return rounded;
}

/// A remainder, and how many times something was taken away.
typedef struct tactus_reduced {
  tactus_pair r;
  tactus_bits k;
} tactus_reduced;

/// x = k log 2 + r, |r| <= log(2) / 2
static inline tactus_reduced tactus_octave_of(tactus_pair x) {
  const tactus_rounded k = tactus_nearest_whole(x.high * 0x1.71547652b82fep+0);
  tactus_reduced octave;
  octave.r = tactus_exact_sum(x.high - k.value * 0x1.62e42feep-1, x.low - k.value * 0x1.a39ef35793c76p-33);
  octave.k = k.bits;
  return octave;
}
/// e^r - 1 without r itself, for |r| <= log(2) / 2.
static inline tactus_real tactus_bent_part(tactus_pair r) {
  static const tactus_real c[] = {0.16666666666666669,    0.041666666666666664,   0.008333333333330039,
                                  0.0013888888888886537,  0.00019841269863171557, 2.4801587317228724e-05,
                                  2.7557268276905696e-06, 2.7557282838800484e-07, 2.5100472505694996e-08,
                                  2.09112987659402e-09};
  const tactus_real x = r.high;
  return r.low + x * x * (0.5 + x * tactus_series(x, c, 10));
}
/// 2^k for -1022 <= k <= 1023
static inline tactus_real tactus_power_of_two(tactus_bits k) { return tactus_number_of((k + 1023) << 52); }

static inline tactus_real tactus_exp_of(tactus_pair x) {
  const tactus_real high = tactus_clamped(x.high, -746, 710);
  const tactus_reduced octave = tactus_octave_of(tactus_pair_of(high, high == x.high ? x.low : 0.0));
  const tactus_real mantissa = 1 + (octave.r.high + tactus_bent_part(octave.r));
  const tactus_bits half = ((octave.k + 2048) << 13 >> 14) - 1024;
  const tactus_real result = mantissa * tactus_power_of_two(half) * tactus_power_of_two(octave.k - half);
  return result < 2.2250738585072014e-308 ? 0 : result;
}
static inline tactus_real tactus_exp(tactus_real x) { return tactus_exp_of(tactus_pair_of(x, 0)); }

/// (e^2x - 1) / (e^2x + 1)
static inline tactus_real tactus_tanh(tactus_real x) {
  const tactus_reduced octave =
      tactus_octave_of(tactus_pair_of(tactus_clamped(2 * tactus_magnitude(x), 0, 44), 0));
  const tactus_real power = tactus_power_of_two(octave.k & 127);
  const tactus_real less_one = power * (octave.r.high + tactus_bent_part(octave.r)) + (power - 1);
  const tactus_real result = less_one / (less_one + 2);
  return x < 0 ? -result : result;
}

/// What the logarithm of 2 and the natural logarithm are to a base.
typedef struct tactus_base {
  tactus_pair of_two, of_e;
} tactus_base;

static const tactus_base tactus_base_e = {{0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45}, {1, 0}};
static const tactus_base tactus_base_2 = {{1, 0}, {0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56}};
static const tactus_base tactus_base_10 = {{0x1.34413509f78p-2, 0x1.fef311f12b358p-46},
                                           {0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57}};

/// log m = 2 s (1 + s^2 / 3 + s^4 q(s^2)), s = (m - 1) / (m + 1), for sqrt(1/2) <= m < sqrt(2)
static inline tactus_pair tactus_log_of_mantissa(tactus_real m) {
  static const tactus_real c[] = {0.2,
                                  0.14285714285714685,
                                  0.11111111110826383,
                                  0.09090909168049924,
                                  0.0769229744350359,
                                  0.0666740439940617,
                                  0.05853063232281699,
                                  0.058621635304233734};
  const tactus_pair sum = tactus_exact_sum(m, 1);
  const tactus_real s = (m - 1) / sum.high;
  const tactus_pair taken = tactus_exact_product(s, sum.high);
  const tactus_real s_low = (((m - 1) - taken.high) - taken.low - s * sum.low) / sum.high;
  tactus_pair square = tactus_exact_product(s, s), series, rest, half;
  tactus_real z;
  square.low += 2 * s * s_low;
  z = square.high;
  series = tactus_exact_sum(0x1.5555555555555p-2, z * tactus_series(z, c, 8));
  series.low += 0x1.5555555555555p-56;
  rest = tactus_pair_product(tactus_pair_of(s, s_low), tactus_pair_product(square, series));
  half = tactus_exact_sum(s, rest.high);
  return tactus_pair_of(2 * half.high, 2 * (half.low + (s_low + rest.low)));
}

/// Of a normal number above 0.
static inline tactus_pair tactus_log_of(tactus_real x, const tactus_base* base) {
  const tactus_bits one = (tactus_bits)1023 << 52, bits = tactus_bits_of(x);
  const tactus_bits biased = (bits + (one - 0x3fe6a09e667f3bcdu)) >> 52;  // sqrt(1/2) becomes 1
  const tactus_real exponent = tactus_number_of(biased | 0x4330000000000000u) - (0x1p52 + 1023);
  const tactus_real mantissa = tactus_number_of(bits - (biased << 52) + one);
  const tactus_pair rest = tactus_pair_product(tactus_log_of_mantissa(mantissa), base->of_e);
  const tactus_pair whole = tactus_exact_sum(exponent * base->of_two.high, rest.high);
  return tactus_pair_of(whole.high, whole.low + (exponent * base->of_two.low + rest.low));
}
static inline tactus_real tactus_log_checked(tactus_real x, const tactus_base* base) {
  const tactus_pair log = tactus_log_of(x, base);
  const tactus_real result = x <= 1.7976931348623157e308 ? log.high + log.low : x;
  return x >= 2.2250738585072014e-308 ? result : x > -2.2250738585072014e-308 ? -HUGE_VAL : (tactus_real)NAN;
}
static inline tactus_real tactus_log(tactus_real x) { return tactus_log_checked(x, &tactus_base_e); }
static inline tactus_real tactus_log2(tactus_real x) { return tactus_log_checked(x, &tactus_base_2); }
static inline tactus_real tactus_log10(tactus_real x) { return tactus_log_checked(x, &tactus_base_10); }

/// a^b. a > 0, or a = 0 and b >= 0, or b a whole number; 0^0 = 1.
static inline tactus_real tactus_pow(tactus_real a, tactus_real b) {
  const tactus_real size = tactus_magnitude(a);
  const tactus_pair log = tactus_log_of(size, &tactus_base_e);
  const tactus_real far = tactus_clamped(b, -0x1p65, 0x1p65);  // beyond: 0, 1 or infinite, and b even
  const tactus_pair high = tactus_exact_product(far, log.high);
  const tactus_real power = tactus_exp_of(tactus_pair_of(high.high, high.low + far * log.low));
  const int whole = floor(b) == b, odd = floor(0.5 * b) != 0.5 * b;
  const tactus_real signed_power = a > 0 ? power : !whole ? (tactus_real)NAN : odd ? -power : power;
  const tactus_real of_zero = b > 0 ? 0.0 : b < 0 ? HUGE_VAL : 1.0;
  return (size < 2.2250738585072014e-308 ? of_zero : signed_power) + ((a - a) + (b - b));
}

/// x = k pi / 2 + r, |r| <= pi / 4, k modulo 4.
static inline tactus_reduced tactus_quadrant_of(tactus_real x) {
  tactus_reduced quadrant;
  tactus_rounded k;
  tactus_real first, high;
  tactus_pair third, fourth, r;
  x = tactus_clamped(x, -0x1p1000, 0x1p1000) + (x - x);
  k = tactus_nearest_whole(x * 0x1.45f306dc9c883p-1);
  first = (x - k.value * 0x1.921fb4p+0) - k.value * 0x1.4442dp-24;
  third = tactus_exact_sum(first, -k.value * 0x1.846988p-48);
  fourth = tactus_exact_sum(third.high, -k.value * 0x1.8cc514p-72);
  r = tactus_exact_sum(fourth.high, (third.low + fourth.low) - k.value * 0x1.80dc1cd129024p-95);
  high = tactus_clamped(r.high, -0.7854, 0.7854);
  quadrant.r = tactus_pair_of(high, high == r.high ? r.low : 0.0);
  quadrant.k = k.bits & 3;
  return quadrant;
}
static inline tactus_real tactus_sin_in_quadrant(tactus_pair r) {
  static const tactus_real c[] = {-0.16666666666666666,   0.008333333333333331,    -0.0001984126984126506,
                                  2.7557319219335453e-06, -2.5052106231157904e-08, 1.605853141458901e-10,
                                  -7.586685070091267e-13};
  const tactus_real z = r.high * r.high, cubic = tactus_series(z, c, 7);
  return r.high + (r.high * z * cubic + r.low * (1 - 0.5 * z));
}
static inline tactus_real tactus_cos_in_quadrant(tactus_pair r) {
  static const tactus_real c[] = {0.041666666666666664,    -0.0013888888888887395, 2.4801587298763433e-05,
                                  -2.7557317270560326e-07, 2.0876146024689747e-09, -1.1382614868556325e-11};
  const tactus_real z = r.high * r.high, half = 0.5 * z, most = 1 - half;
  const tactus_real fourth = z * z * tactus_series(z, c, 6);
  return most + (((1 - most) - half) + (fourth - r.high * r.low));
}
static inline tactus_real tactus_sin_from(tactus_pair r, tactus_bits k) {
  const tactus_real size = (k & 1) != 0 ? tactus_cos_in_quadrant(r) : tactus_sin_in_quadrant(r);
  return (k & 2) != 0 ? -size : size;
}
/// x in rad
static inline tactus_real tactus_sin(tactus_real x) {
  const tactus_reduced quadrant = tactus_quadrant_of(x);
  return tactus_sin_from(quadrant.r, quadrant.k);
}
static inline tactus_real tactus_cos(tactus_real x) {
  const tactus_reduced quadrant = tactus_quadrant_of(x);
  return tactus_sin_from(quadrant.r, quadrant.k + 1);
}
static inline tactus_real tactus_tan(tactus_real x) {
  const tactus_reduced quadrant = tactus_quadrant_of(x);
  return tactus_sin_from(quadrant.r, quadrant.k & 1) / tactus_sin_from(quadrant.r, (quadrant.k & 1) + 1);
}

/// The angle of the point (x, y) against the x axis, in [-pi, pi]; 0 at the origin.
static inline tactus_real tactus_atan2(tactus_real y, tactus_real x) {
  static const tactus_real c[] = {-0.3333333333333333,  0.19999999999999804,  -0.14285714285659457,
                                  0.11111111105119366,  -0.09090908751706075, 0.07692296323157785,
                                  -0.06666423954373413, 0.058789182929757273, -0.05230375457576669,
                                  0.04551233844829568,  -0.03456132296826231, 0.01627552168389342};
  const int large = tactus_magnitude(x) > 0x1p1000 || tactus_magnitude(y) > 0x1p1000;
  const tactus_real scale = large ? 0x1p-100 : 1.0;
  const tactus_real up = tactus_magnitude(y) * scale, along = tactus_magnitude(x) * scale;
  // atan t = pi/4 + atan((t - 1) / (t + 1)) = pi/2 - atan(1 / t), so that the series begins below tan(pi/8).
  const int steep = up > 2.414213562373095 * along, diagonal = up > 0.41421356237309503 * along;
  const tactus_real above = steep ? -along : diagonal ? up - along : up;
  const tactus_real below = steep ? up : diagonal ? up + along : along;
  const tactus_real t = below == 0 ? 0.0 : above / below;
  const tactus_real z = t * t, cubic = tactus_series(z, c, 12);
  const tactus_real base = steep ? 0x1.921fb54442d18p+0 : diagonal ? 0x1.921fb54442d18p-1 : 0.0;
  const tactus_real base_low = steep ? 0x1.1a62633145c07p-54 : diagonal ? 0x1.1a62633145c07p-55 : 0.0;
  const tactus_real acute = base + (t + (base_low + t * z * cubic));
  const tactus_real angle = x < 0 ? 0x1.921fb54442d18p+1 - (acute - 0x1.1a62633145c07p-53) : acute;
  return y < 0 ? -angle : angle;
}
static inline tactus_real tactus_atan(tactus_real x) { return tactus_atan2(x, 1); }
/// sqrt(1 - x^2), NaN for |x| > 1
static inline tactus_real tactus_cathetus(tactus_real x) {
  const tactus_pair square = tactus_exact_product(x, x);
  return sqrt((1 - square.high) - square.low);
}
/// -1 <= x <= 1
static inline tactus_real tactus_asin(tactus_real x) { return tactus_atan2(x, tactus_cathetus(x)); }
static inline tactus_real tactus_acos(tactus_real x) { return tactus_atan2(tactus_cathetus(x), x); }

/// a - b floor(a / b), which lies in [0, b), or in (b, 0] if b < 0; b != 0.
static inline tactus_real tactus_mod(tactus_real a, tactus_real b) {
  const tactus_real scale = tactus_magnitude(a) > 0x1p900 || tactus_magnitude(b) > 0x1p900 ? 0x1p-200 : 1.0;
  const tactus_real x = (b < 0 ? -a : a) * scale, period = tactus_magnitude(b) * scale;
  const tactus_real periods = floor(x / period);
  const tactus_pair whole = tactus_exact_product(tactus_clamped(periods, -0x1p51, 0x1p51), period);
  tactus_real rest = (x - whole.high) - whole.low, result;
  rest = rest < 0 ? rest + period : rest;  // the quotient was rounded across a whole number
  rest = rest >= period ? rest - period : rest;
  // What lies closer below a multiple than the last bit of the period counts as the multiple.
  rest = rest >= 0 && rest < period && tactus_magnitude(periods) < 0x1p51 ? rest : 0;
  result = (b < 0 ? -rest : rest) * (1 / scale);
  return b == 0 ? (tactus_real)NAN : result + ((a - a) + (b - b));
}
