#pragma once
// Thread: [control]

#include <optional>
#include <string>
#include <string_view>

namespace tactus {

/// What a number measures, as exponents of the SI base units. Exponents are real because the stiffness of a
/// power-law contact is in N/m^1.5. Decibels, per cent, radians and full scale are plain numbers: all zero.
///
/// `radian` is remembered and compared by nothing but `is_angular_velocity` and texts: an angle is a plain
/// number, and a torque over an angle is in N m as well as in N m/rad. It tells rad/s from Hz, which differ
/// by 2 pi.
struct Dimension {
  double metre = 0, kilogram = 0, second = 0, ampere = 0, radian = 0;

  bool operator==(const Dimension& other) const;
  bool plain() const { return *this == Dimension{}; }
  Dimension operator*(const Dimension& other) const;
  Dimension operator/(const Dimension& other) const;
  Dimension pow(double exponent) const;
};

/// 1/s with an angle: rad/s, deg/s. A frequency is in turns: Hz, rpm, bpm.
bool is_angular_velocity(const Dimension& dimension);
bool is_frequency(const Dimension& dimension);

/// A quantity where one of the dimension `to`, equal to `from`, is wanted: turns into radians, or back.
double converted(double si, const Dimension& from, const Dimension& to);

/// What takes the place of a quantity of translation where things turn: rad for m, N m for N, kg m^2 for kg.
/// In energies, powers and electrical quantities nothing changes.
///   N^a m^b s^c A^d  becomes  (N m)^a rad^b s^c A^d
Dimension in_rotation(const Dimension& translation);

/// As text: "N/m", "m/s", "kg m^2"; "" for a plain number.
std::string to_string(const Dimension& dimension);

/// A unit as written in a file: SI value = factor * number, or that many decibels, 10^(factor * number / 20),
/// when `decibel`: dB, cents and semitones, which are ratios.
struct Unit {
  Dimension dimension;
  double factor = 1.0;
  bool decibel = false;

  double to_si(double number) const;
  double from_si(double si) const;
};

/// "ms", "µs", "N/m^1.5", "T m", "kg/s", "m/s^2", "full scale", "dB", "%", "" (plain). Frequencies are
/// turns: 1 Hz = 60 rpm = 60 bpm; "rad/s" and "deg/s" are angular velocities (see `converted`). Factors
/// are separated by a space or '*'; everything after a '/' up to the next '/' divides once ("N s/m" is N·s
/// per m, "N/m/s" N per m per s). nullopt: not a unit.
std::optional<Unit> parse_unit(std::string_view text);

/// The longest beginning of `text` that reads as a unit inside an expression; "" if there is none. Factors
/// are joined by spaces or by a '/' without spaces around it: "N/m * x" begins with "N/m", "N / m" with "N".
std::string_view unit_prefix(std::string_view text);

/// True for one unit symbol ("ms", "ohm", "dB").
bool is_unit_symbol(std::string_view word);

/// The unit that was meant by its name or by letters of the wrong case: "ms" for "msec", "kHz" for "KHZ"; ""
/// if none is known.
std::string meant_unit(std::string_view text);

/// A number with a unit or without.
struct QuantityValue {
  double si = 0;
  Unit unit;
  bool bare = false;  ///< no unit given: counts in SI
};

/// "15 ms", "-34 dB", "0.6": number, then unit. nullopt: not a quantity.
std::optional<QuantityValue> parse_quantity(std::string_view text);

}  // namespace tactus
