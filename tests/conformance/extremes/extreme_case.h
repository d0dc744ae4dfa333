#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/conformance/extremes/subject.h"

namespace tactus::test {

enum class Verdict {
  Refused,  ///< with place and remedy, and only where it may be
  Right,    ///< a law or an equation gives the number
  Finite,   ///< the same for all block sizes and without a fault, but nothing gives the number
  Wrong,
};
inline constexpr const char* kVerdicts[] = {"refused", "right", "finite", "wrong"};

struct Judgement {
  Verdict verdict = Verdict::Finite;
  std::string reason = {};  ///< what is wrong, or by what it is right
};

/// One number of one subject is extreme, as a number in the file or as a signal while it runs.
struct ExtremeCase {
  const ExtremeSubject* subject = nullptr;
  int slot = 0;
  bool by_signal = false;
  double rate = 48e3;
  double value = 0;

  const Slot& tested() const { return subject->slots[static_cast<std::size_t>(slot)]; }
  /// "low_pass.cutoff = 1e+30 by a signal at 48 kHz"
  std::string name() const;
};

/// 0 and -0, denormal and tiny numbers, huge ones of either sign, the ends of the declared range and what
/// lies just beyond them.
std::vector<double> extreme_values(const Interval& declared, bool whole);

/// What the engine takes a number of a file or of a signal for: denormal ones are 0.
inline double taken_for(double x) { return std::abs(x) < std::numeric_limits<double>::min() ? 0.0 : x; }

/// All cases of a subject.
std::vector<ExtremeCase> extreme_cases(const ExtremeSubject& subject, const std::vector<double>& rates);

/// [control] Loads and runs it, also beside its equation and the laws that hold for every node: a number
/// beyond the declared range is refused, a signal counts as the nearest end of it; a signal at rest is the
/// same as a number; what is next to 0 acts as 0; another system of units changes nothing; blocks change no
/// bit.
Judgement judge(const ExtremeCase& extreme);

}  // namespace tactus::test
