#pragma once

// Thread: [any], except where a function says otherwise
#include <span>
#include <vector>

#include "engine/dsp/simd/lanes.h"
#include "engine/physics/numbers.h"
#include "engine/physics/solvers/link_operator.h"

namespace tactus {

/// One explicit step of masses in a row, in one pass over the memory:
///     f_i = k_i (q_i+1 - q_i) + b_i (u_i+1 - u_i)            tension between neighbours
///     e_i = s_i (f_i - f_i-1 - K_i q_i - B_i u_i + p_i)      K, B: to whatever is fixed
///     u+ = u + e,   q+ = q + u+
/// with q [m], u = q - q- [m], s = step^2 / mass [s^2/kg], and p [N] whatever else pushes. Each tension is
/// worked out once and acts on both of its masses: action equals reaction to the bit. Where neighbours are
/// alike (chains, rings) their numbers stay in registers: of the memory only q, u and u+ are passed.
class MassRow {
 public:
  MassRow() = default;
  /// [control] `links` as in `LinkOperator::entries`; takes those between neighbours and on the diagonal and
  /// leaves the others in `left`. `scale` is s.
  MassRow(std::span<const LinkOperator::Entry> links, std::span<const double> scale,
          std::vector<LinkOperator::Entry>& left);

  /// [control] Whatever pushes may push these masses only (none at first); the others' p is never read.
  void let_push(const std::vector<bool>& masses);

  /// [realtime] p = `rest` where something may push.
  void fill(const double* rest, double* push) const noexcept;
  /// [realtime] q becomes q+; u and u+ are two places.
  void step(double* q, const double* u, double* u_next, const double* push) const noexcept;

 private:
  /// Masses that are stepped in lanes, first ... last - 1: all with the same numbers, each with its own, or
  /// such that something may push.
  struct Run {
    enum class Kind { Alike, Own, Pushed } kind;
    int first, last;
  };
  struct Pass;
  template <Run::Kind kind>
  static Lanes step_lanes(const Pass& where, const Run& run, Lanes below) noexcept;

  int masses() const { return static_cast<int>(scale_.size()); }
  int vectorised() const;
  bool alike(int one, int other) const;
  Run::Kind kind_of(int first, const std::vector<bool>& pushed) const;

  AlignedNumbers k_, b_, own_k_, own_b_, scale_;
  std::vector<Run> runs_;
};

}  // namespace tactus
