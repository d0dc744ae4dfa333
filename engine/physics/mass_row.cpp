#include "engine/physics/mass_row.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "engine/dsp/lanes.h"

namespace tactus {

/// Where all numbers are. The same sums and products for one mass or for a register full of them, so the bits
/// do not tell which.
struct MassRow::Pass {
  const double *k, *b, *own_k, *own_b, *scale, *u, *push;
  double *q, *u_next;

  template <class Wide>
  static Wide load(const double* x) noexcept {
    if constexpr (std::is_same_v<Wide, double>)
      return *x;
    else
      return Wide::load(x);
  }
  static void store(double x, double* to) noexcept { *to = x; }
  static void store(const Lanes& x, double* to) noexcept { x.store(to); }
  static double moved_up(double, double below) noexcept { return below; }
  static Lanes moved_up(const Lanes& above, const Lanes& below) noexcept { return above.moved_up(below); }

  /// From the tension below mass i to the one above it, which it has with mass `next`.
  template <bool Pushed, class Wide>
  Wide advance(int i, int next, const Wide& below) const noexcept {
    const Wide here = load<Wide>(q + i), moved = load<Wide>(u + i);
    const Wide above = load<Wide>(k + i) * (load<Wide>(q + next) - here) +
                       load<Wide>(b + i) * (load<Wide>(u + next) - moved);
    Wide force =
        (above - moved_up(above, below)) - (load<Wide>(own_k + i) * here + load<Wide>(own_b + i) * moved);
    if constexpr (Pushed) force = force + load<Wide>(push + i);
    const Wide moving = moved + load<Wide>(scale + i) * force;
    store(moving, u_next + i);
    store(here + moving, q + i);
    return above;
  }
};

/// Goes upwards: what lies above still is where it was, what lies below is known by its tension.
template <bool Pushed>
Lanes MassRow::step_lanes(const Pass& where, const Run& run, Lanes below) noexcept {
  const Pass pass = where;  // a copy that no store of a register can be thought to change
  for (int i = run.first; i < run.last; i += Lanes::kCount) below = pass.advance<Pushed>(i, i + 1, below);
  return below;
}

MassRow::MassRow(std::span<const LinkOperator::Entry> links, std::span<const double> scale,
                 std::vector<LinkOperator::Entry>& left)
    : k_(scale.size()),
      b_(scale.size()),
      own_k_(scale.size()),
      own_b_(scale.size()),
      scale_(scale.begin(), scale.end()) {
  for (const auto& e : links) {
    const auto row = static_cast<std::size_t>(e.row);
    if (std::abs(e.column - e.row) > 1 || e.column >= masses()) {
      left.push_back(e);
      continue;
    }
    // A link to a neighbour stands on the diagonal too: what remains there goes to the ground.
    own_k_[row] += e.k;
    own_b_[row] += e.b;
    if (e.column == e.row + 1) k_[row] = -e.k, b_[row] = -e.b;
  }
  let_push(std::vector<bool>(scale.size()));
}

/// The last mass has none above it; without vector registers one by one is faster than eight by eight.
int MassRow::in_lanes() const {
  return Lanes::kInRegisters ? std::max(0, masses() - 1) / Lanes::kCount * Lanes::kCount : 0;
}

void MassRow::let_push(const std::vector<bool>& masses) {
  runs_.clear();
  for (int i = 0; i < in_lanes(); i += Lanes::kCount) {
    const auto first = masses.begin() + i;
    const bool pushed = std::find(first, first + Lanes::kCount, true) != first + Lanes::kCount;
    if (runs_.empty() || runs_.back().pushed != pushed) runs_.push_back({i, i, pushed});
    runs_.back().last = i + Lanes::kCount;
  }
}

void MassRow::fill(const double* rest, double* push) const noexcept {
  for (const auto& run : runs_)
    if (run.pushed) std::copy(rest + run.first, rest + run.last, push + run.first);
  std::copy(rest + in_lanes(), rest + masses(), push + in_lanes());
}

void MassRow::step(double* q, const double* u, double* u_next, const double* push) const noexcept {
  const Pass pass{k_.data(), b_.data(), own_k_.data(), own_b_.data(), scale_.data(), u, push, q, u_next};
  Lanes below = Lanes::same(0.0);
  for (const auto& run : runs_)
    below = run.pushed ? step_lanes<true>(pass, run, below) : step_lanes<false>(pass, run, below);
  double tensions[Lanes::kCount];
  below.store(tensions);
  double tension = tensions[Lanes::kCount - 1];
  for (int i = in_lanes(); i < masses(); ++i)
    tension = pass.advance<true>(i, std::min(i + 1, masses() - 1), tension);
}

}  // namespace tactus
