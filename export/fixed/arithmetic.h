#pragma once

// Thread: [control].

#include <functional>
#include <string>
#include <vector>

#include "export/fixed/fixed_value.h"

namespace tactus {

/// Operands must agree on a comparison for a bound to be valid: it may decide otherwise while they are nearer
/// to each other than `margin`.
struct FixedDecision {
  std::string path;
  double margin = 0;
};

/// Calculates with FixedValues: each function returns what a C expression gives, with its range and error.
/// Scales are powers of two, as fine as the range allows; what is coarser than that is not made finer. Text
/// is that of export/fixed/numbers.h.in.
class FixedArithmetic {
 public:
  explicit FixedArithmetic(int bits) : bits_(bits) {}
  int bits() const { return bits_; }

  static FixedValue number(double value);
  /// The finest exponent at which the range fits.
  int fitting(Interval range, bool wide = false) const;
  /// A constant as an integer. Modulo 2^bits where it does not fit, which sums that fit do not notice.
  std::string literal(double value, int exponent, bool wide = false) const;

  FixedValue sum(const FixedValue& a, const FixedValue& b, bool wide = false) const;
  FixedValue difference(const FixedValue& a, const FixedValue& b, bool wide = false) const;
  FixedValue negative(const FixedValue& a) const;
  FixedValue product(const FixedValue& a, const FixedValue& b, bool wide = false) const;
  /// `b` without 0.
  FixedValue quotient(const FixedValue& a, const FixedValue& b) const;
  FixedValue smaller(const FixedValue& a, const FixedValue& b, bool wide = false) const;
  FixedValue larger(const FixedValue& a, const FixedValue& b, bool wide = false) const;
  FixedValue size(const FixedValue& a) const;
  /// `sign`: "<", ">=" and so on.
  FixedValue comparison(const char* sign, const FixedValue& a, const FixedValue& b);
  FixedValue choice(const FixedValue& condition, const FixedValue& a, const FixedValue& b,
                    bool wide = false) const;
  /// "floor", "ceil" or "round".
  FixedValue whole(const char* how, const FixedValue& a);
  FixedValue modulo(const FixedValue& a, const FixedValue& b);
  FixedValue sign(const FixedValue& a);
  /// A trigger: at least 0.5.
  FixedValue trigger(const FixedValue& a);

  /// A word with the value of a wide one, rounded; words as they are.
  FixedValue word(const FixedValue& a) const;
  /// The same value with another exponent, as text. `rounding` grows by the error of it.
  std::string aligned(const FixedValue& a, int exponent, bool wide, double& rounding) const;
  /// What an expression gives, rounded to a word or left wide.
  FixedValue finished(std::string text, int exponent, bool is_wide, Interval range, double error,
                      bool wide) const;

  /// Where a decision depends on rounding.
  void decide(double margin);
  void set_path(std::string path) { path_ = std::move(path); }
  std::vector<FixedDecision> decisions;

 private:
  FixedValue combined(const char* name, const FixedValue& a, const FixedValue& b, Interval range,
                      double error, bool wide, const std::function<Interval(double)>& with_rounding) const;
  FixedValue scaled(const FixedValue& a, double factor, bool wide) const;
  FixedValue chosen(const char* name, const FixedValue& a, const FixedValue& b, bool low, bool wide) const;
  double most(bool wide) const { return std::ldexp(1.0, (wide ? 2 * bits_ : bits_) - 1) - 1; }

  int bits_;
  std::string path_;
};

}  // namespace tactus
