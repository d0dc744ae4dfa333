#pragma once
// Thread: [any]

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

/// The mathematical functions of the audio path, in additions, multiplications, divisions and square roots of
/// IEEE 754 alone: the same bits on every machine, for every vector width and with every C library. No
/// tables, and no branches, so that loops over them can be vectorised.
///
/// Largest error over the whole domain, in units in the last place, against long double; measured and
/// bounded by tests/engine/core/math_functions_test.cpp:
///
///   exp 0.9   log log2 log10 0.51   pow 0.9   sin cos 0.8   tan 2.2   asin 2.1   acos 2.4   atan atan2 1.8
///   tanh 2.4   floor ceil round 0   mod 0.5
///
/// sin, cos and tan keep their error up to |x| = 1.5e9 rad. Beyond, the phase is off by up to 2 units in the
/// last place of x, which is what x itself is known to; results stay in [-1, 1].
///
/// Arguments and results below 2.3e-308 count as 0, as on the audio thread (NoDenormals). Arguments are
/// finite; outside the domain the result is NaN, at a pole or beyond the largest double it is infinite.
namespace tactus::math {

inline constexpr double kLargest = std::numeric_limits<double>::max();
inline constexpr double kSmallestNormal = std::numeric_limits<double>::min();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// ---- arithmetic with twice the digits: T. J. Dekker, Numer. Math. 18, 1971

/// The unevaluated sum of two doubles.
struct Pair {
  double high = 0, low = 0;
};

inline Pair exact_sum(double a, double b) noexcept {
  const double sum = a + b, b_taken = sum - a;
  return {sum, (a - (sum - b_taken)) + (b - b_taken)};
}
/// The first 26 bits of `a`, and the rest. |a| < 1e300.
inline Pair halves(double a) noexcept {
  const double c = 134217729.0 * a;
  const double high = c - (c - a);
  return {high, a - high};
}
inline Pair exact_product(double a, double b) noexcept {
  const double product = a * b;
  const Pair x = halves(a), y = halves(b);
  return {product, ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low};
}
inline Pair product(Pair a, Pair b) noexcept {
  const Pair p = exact_product(a.high, b.high);
  return {p.high, p.low + (a.high * b.low + a.low * b.high)};
}

/// c0 + c1 x + c2 x^2 + …
inline double polynomial(double, double c0) noexcept { return c0; }
template <class... Rest>
double polynomial(double x, double c0, Rest... rest) noexcept {
  return c0 + x * polynomial(x, rest...);
}

inline double clamped(double x, double low, double high) noexcept {
  return x < low ? low : x > high ? high : x;
}
inline double magnitude(double x) noexcept { return x < 0 ? -x : x; }

/// Adding it leaves the nearest whole number in the last bits of a sum.
inline constexpr double kRounder = 0x1.8p52;

/// |x| < 2^51
struct Rounded {
  double value;
  std::uint64_t bits;  ///< modulo 2^51
};
inline Rounded nearest_whole(double x) noexcept {
  const double sum = x + kRounder;
  return {sum - kRounder, std::bit_cast<std::uint64_t>(sum)};
}

// ---- exponentials

/// Of 32 and 53 bits, so that products of the first with a whole number below 2^20 are exact.
inline constexpr Pair kLog2{0x1.62e42feep-1, 0x1.a39ef35793c76p-33};

/// x = k log 2 + r, |r| <= log(2) / 2
struct Octave {
  Pair r;
  std::uint64_t k;  ///< modulo 2^51
};
inline Octave octave_of(Pair x) noexcept {
  const auto k = nearest_whole(x.high * 0x1.71547652b82fep+0);
  return {exact_sum(x.high - k.value * kLog2.high, x.low - k.value * kLog2.low), k.bits};
}
/// e^r - 1 without r itself, for |r| <= log(2) / 2.
inline double bent_part(Pair r) noexcept {
  const double x = r.high;
  const double cubic =
      polynomial(x, 0.16666666666666669, 0.041666666666666664, 0.008333333333330039, 0.0013888888888886537,
                 0.00019841269863171557, 2.4801587317228724e-05, 2.7557268276905696e-06,
                 2.7557282838800484e-07, 2.5100472505694996e-08, 2.09112987659402e-09);
  return r.low + x * x * (0.5 + x * cubic);
}
/// 2^k for -1022 <= k <= 1023
inline double power_of_two(std::uint64_t k) noexcept { return std::bit_cast<double>((k + 1023) << 52); }

inline double exp(Pair x) noexcept {
  const double high = clamped(x.high, -746, 710);
  const auto [r, k] = octave_of({high, high == x.high ? x.low : 0.0});
  const double mantissa = 1 + (r.high + bent_part(r));
  const std::uint64_t half = ((k + 2048) << 13 >> 14) - 1024;  // rounded down, from the 51 bits of k
  const double result = mantissa * power_of_two(half) * power_of_two(k - half);
  return result < kSmallestNormal ? 0 : result;
}
/// e^x
inline double exp(double x) noexcept { return exp(Pair{x, 0}); }

/// (e^2x - 1) / (e^2x + 1)
inline double tanh(double x) noexcept {
  const auto [r, k] = octave_of({clamped(2 * magnitude(x), 0, 44), 0});
  const double power = power_of_two(k & 127);
  const double less_one = power * (r.high + bent_part(r)) + (power - 1);
  const double result = less_one / (less_one + 2);
  return x < 0 ? -result : result;
}

// ---- logarithms

/// What the logarithm of 2 and the natural logarithm are to a base.
struct Base {
  Pair of_two;  ///< of 42 and 53 bits, so that products with exponents are exact
  Pair of_e;
};
inline constexpr Base kBaseE{{0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45}, {1, 0}};
inline constexpr Base kBase2{{1, 0}, {0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56}};
inline constexpr Base kBase10{{0x1.34413509f78p-2, 0x1.fef311f12b358p-46},
                              {0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57}};

/// log m = 2 s (1 + s^2 / 3 + s^4 q(s^2)), s = (m - 1) / (m + 1), for sqrt(1/2) <= m < sqrt(2)
inline Pair log_of_mantissa(double m) noexcept {
  const Pair sum = exact_sum(m, 1);
  const double s = (m - 1) / sum.high;
  const Pair taken = exact_product(s, sum.high);
  const double s_low = (((m - 1) - taken.high) - taken.low - s * sum.low) / sum.high;
  Pair square = exact_product(s, s);
  square.low += 2 * s * s_low;
  const double z = square.high;
  const double fourth =
      z * polynomial(z, 0.2, 0.14285714285714685, 0.11111111110826383, 0.09090909168049924,
                     0.0769229744350359, 0.0666740439940617, 0.05853063232281699, 0.058621635304233734);
  Pair series = exact_sum(0x1.5555555555555p-2, fourth);
  series.low += 0x1.5555555555555p-56;
  const Pair rest = product({s, s_low}, product(square, series));
  const Pair half = exact_sum(s, rest.high);
  return {2 * half.high, 2 * (half.low + (s_low + rest.low))};
}

/// Of a normal number above 0.
inline Pair log(double x, const Base& base) noexcept {
  constexpr std::uint64_t kExponentOfOne = std::uint64_t{1023} << 52;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t biased = (bits + (kExponentOfOne - 0x3fe6a09e667f3bcdu)) >> 52;  // sqrt(1/2) becomes 1
  const double exponent = std::bit_cast<double>(biased | 0x4330000000000000u) - (0x1p52 + 1023);
  const double mantissa = std::bit_cast<double>(bits - (biased << 52) + kExponentOfOne);
  const Pair rest = product(log_of_mantissa(mantissa), base.of_e);
  const Pair whole = exact_sum(exponent * base.of_two.high, rest.high);
  return {whole.high, whole.low + (exponent * base.of_two.low + rest.low)};
}
inline double log_checked(double x, const Base& base) noexcept {
  const Pair log = math::log(x, base);
  const double result = x <= kLargest ? log.high + log.low : x;
  return x >= kSmallestNormal ? result : x > -kSmallestNormal ? -kInfinity : kNotANumber;
}
/// x > 0
inline double log(double x) noexcept { return log_checked(x, kBaseE); }
inline double log2(double x) noexcept { return log_checked(x, kBase2); }
inline double log10(double x) noexcept { return log_checked(x, kBase10); }

/// a^b. a > 0, or a = 0 and b >= 0, or b a whole number; 0^0 = 1.
inline double pow(double a, double b) noexcept {
  const double size = magnitude(a);
  const Pair log = math::log(size, kBaseE);
  const double far = clamped(b, -0x1p65, 0x1p65);  // beyond, the result is 0, 1 or infinite, and b even
  const Pair high = exact_product(far, log.high);
  const double power = exp(Pair{high.high, high.low + far * log.low});
  const bool whole = std::floor(b) == b, odd = std::floor(0.5 * b) != 0.5 * b;
  const double signed_power = a > 0 ? power : !whole ? kNotANumber : odd ? -power : power;
  const double of_zero = b > 0 ? 0.0 : b < 0 ? kInfinity : 1.0;
  return (size < kSmallestNormal ? of_zero : signed_power) + ((a - a) + (b - b));
}

// ---- circular functions

/// x = k pi / 2 + r, |r| <= pi / 4. W. J. Cody & W. Waite, 1980, with five parts of pi / 2, of which products
/// with whole numbers below 2^30 are exact.
struct Quadrant {
  Pair r;
  std::uint64_t k;  ///< modulo 4
};
inline Quadrant quadrant_of(double x) noexcept {
  x = clamped(x, -0x1p1000, 0x1p1000) + (x - x);
  const auto k = nearest_whole(x * 0x1.45f306dc9c883p-1);
  const double first = (x - k.value * 0x1.921fb4p+0) - k.value * 0x1.4442dp-24;
  const Pair third = exact_sum(first, -k.value * 0x1.846988p-48);
  const Pair fourth = exact_sum(third.high, -k.value * 0x1.8cc514p-72);
  const Pair r = exact_sum(fourth.high, (third.low + fourth.low) - k.value * 0x1.80dc1cd129024p-95);
  const double high = clamped(r.high, -0.7854, 0.7854);
  return {{high, high == r.high ? r.low : 0.0}, k.bits & 3};
}
inline double sin_in_quadrant(Pair r) noexcept {
  const double z = r.high * r.high;
  const double cubic = polynomial(z, -0.16666666666666666, 0.008333333333333331, -0.0001984126984126506,
                                  2.7557319219335453e-06, -2.5052106231157904e-08, 1.605853141458901e-10,
                                  -7.586685070091267e-13);
  return r.high + (r.high * z * cubic + r.low * (1 - 0.5 * z));
}
inline double cos_in_quadrant(Pair r) noexcept {
  const double z = r.high * r.high, half = 0.5 * z, most = 1 - half;
  const double fourth = z * z *
                        polynomial(z, 0.041666666666666664, -0.0013888888888887395, 2.4801587298763433e-05,
                                   -2.7557317270560326e-07, 2.0876146024689747e-09, -1.1382614868556325e-11);
  return most + (((1 - most) - half) + (fourth - r.high * r.low));
}
inline double sin_from(Pair r, std::uint64_t k) noexcept {
  const double sine = sin_in_quadrant(r), cosine = cos_in_quadrant(r);
  const double size = (k & 1) != 0 ? cosine : sine;
  return (k & 2) != 0 ? -size : size;
}
/// x in rad
inline double sin(double x) noexcept {
  const auto [r, k] = quadrant_of(x);
  return sin_from(r, k);
}
inline double cos(double x) noexcept {
  const auto [r, k] = quadrant_of(x);
  return sin_from(r, k + 1);
}
inline double tan(double x) noexcept {
  const auto [r, k] = quadrant_of(x);
  return sin_from(r, k & 1) / sin_from(r, (k & 1) + 1);
}

/// The angle of the point (x, y) against the x axis, in [-pi, pi]; 0 at the origin.
inline double atan2(double y, double x) noexcept {
  const bool large = magnitude(x) > 0x1p1000 || magnitude(y) > 0x1p1000;
  const double scale = large ? 0x1p-100 : 1.0;
  const double up = magnitude(y) * scale, along = magnitude(x) * scale;
  // atan t = pi/4 + atan((t - 1) / (t + 1)) = pi/2 - atan(1 / t), so that the series begins below tan(pi/8).
  const bool steep = up > 2.414213562373095 * along, diagonal = up > 0.41421356237309503 * along;
  const double above = steep ? -along : diagonal ? up - along : up;
  const double below = steep ? up : diagonal ? up + along : along;
  const double quotient = above / below;
  const double t = below == 0 ? 0.0 : quotient;
  const double z = t * t;
  const double cubic =
      polynomial(z, -0.3333333333333333, 0.19999999999999804, -0.14285714285659457, 0.11111111105119366,
                 -0.09090908751706075, 0.07692296323157785, -0.06666423954373413, 0.058789182929757273,
                 -0.05230375457576669, 0.04551233844829568, -0.03456132296826231, 0.01627552168389342);
  const double base = steep ? 0x1.921fb54442d18p+0 : diagonal ? 0x1.921fb54442d18p-1 : 0.0;
  const double base_low = steep ? 0x1.1a62633145c07p-54 : diagonal ? 0x1.1a62633145c07p-55 : 0.0;
  const double acute = base + (t + (base_low + t * z * cubic));
  const double angle = x < 0 ? 0x1.921fb54442d18p+1 - (acute - 0x1.1a62633145c07p-53) : acute;
  return y < 0 ? -angle : angle;
}
inline double atan(double x) noexcept { return atan2(x, 1); }
/// sqrt(1 - x^2), NaN for |x| > 1
inline double cathetus(double x) noexcept {
  const Pair square = exact_product(x, x);
  return std::sqrt((1 - square.high) - square.low);
}
/// -1 <= x <= 1
inline double asin(double x) noexcept { return atan2(x, cathetus(x)); }
inline double acos(double x) noexcept { return atan2(cathetus(x), x); }

// ---- whole numbers

inline double floor(double x) noexcept { return std::floor(x); }
inline double ceil(double x) noexcept { return std::ceil(x); }
/// Halves away from zero.
inline double round(double x) noexcept {
  // The largest double below 1/2: 1/2 itself would round 0.49999999999999994 up.
  const double up = std::floor(magnitude(x) + 0.49999999999999994);
  return x < 0 ? -up : up;
}

/// a - b floor(a / b), which lies in [0, b), or in (b, 0] if b < 0; b != 0. Exact where |a / b| < 2^51;
/// beyond, where neighbouring doubles are periods apart, 0.
inline double mod(double a, double b) noexcept {
  const double scale = magnitude(a) > 0x1p900 || magnitude(b) > 0x1p900 ? 0x1p-200 : 1.0;
  const double x = (b < 0 ? -a : a) * scale, period = magnitude(b) * scale;
  const double periods = std::floor(x / period);
  const Pair whole = exact_product(clamped(periods, -0x1p51, 0x1p51), period);
  double rest = (x - whole.high) - whole.low;
  rest = rest < 0 ? rest + period : rest;  // the quotient was rounded across a whole number
  rest = rest >= period ? rest - period : rest;
  // What lies closer below a multiple than the last bit of the period counts as the multiple.
  rest = rest >= 0 && rest < period && magnitude(periods) < 0x1p51 ? rest : 0;
  const double result = (b < 0 ? -rest : rest) * (1 / scale);
  return b == 0 ? kNotANumber : result + ((a - a) + (b - b));
}

}  // namespace tactus::math
