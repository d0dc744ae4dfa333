#pragma once
// Thread: [any]

#include <compare>
#include <numbers>

namespace tactus {

inline constexpr double kPi = std::numbers::pi;

/// A number with its unit as a type, so that `OnePole{48_kHz, 80_Hz}` does not compile with arguments
/// exchanged or with bare numbers. Conversions are explicit; `value` is in the SI unit.
template <class Tag>
struct Quantity {
  double value = 0.0;

  constexpr Quantity() = default;
  constexpr explicit Quantity(double si) : value(si) {}

  constexpr auto operator<=>(const Quantity&) const = default;
  constexpr Quantity operator+(Quantity other) const { return Quantity{value + other.value}; }
  constexpr Quantity operator-(Quantity other) const { return Quantity{value - other.value}; }
  constexpr Quantity operator*(double factor) const { return Quantity{value * factor}; }
  constexpr Quantity operator/(double divisor) const { return Quantity{value / divisor}; }
  constexpr double operator/(Quantity other) const { return value / other.value; }
};

using Hertz = Quantity<struct HertzTag>;
using Seconds = Quantity<struct SecondsTag>;

/// Frames (not rounded) in a time at a rate.
constexpr double frames_in(Seconds time, Hertz sample_rate) { return time.value * sample_rate.value; }

inline namespace literals {
constexpr Hertz operator""_Hz(long double v) { return Hertz{static_cast<double>(v)}; }
constexpr Hertz operator""_Hz(unsigned long long v) { return Hertz{static_cast<double>(v)}; }
constexpr Hertz operator""_kHz(long double v) { return Hertz{1e3 * static_cast<double>(v)}; }
constexpr Hertz operator""_kHz(unsigned long long v) { return Hertz{1e3 * static_cast<double>(v)}; }
constexpr Seconds operator""_s(long double v) { return Seconds{static_cast<double>(v)}; }
constexpr Seconds operator""_s(unsigned long long v) { return Seconds{static_cast<double>(v)}; }
constexpr Seconds operator""_ms(long double v) { return Seconds{1e-3 * static_cast<double>(v)}; }
constexpr Seconds operator""_ms(unsigned long long v) { return Seconds{1e-3 * static_cast<double>(v)}; }
}  // namespace literals

}  // namespace tactus
