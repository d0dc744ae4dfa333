#include "engine/physics/solvers/mass_row.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/physics/numbers.h"

namespace tactus {

/// Where all numbers are.
struct MassRow::Pass {
  const double *k, *b, *own_k, *own_b, *scale, *u, *push;
  double *q, *u_next;

  template <class Vector>
  struct Constants {
    Vector k, b, own_k, own_b, scale;
  };
  template <class Vector>
  Constants<Vector> constants(int i) const noexcept {
    return {load<Vector>(k + i), load<Vector>(b + i), load<Vector>(own_k + i), load<Vector>(own_b + i),
            load<Vector>(scale + i)};
  }

  /// From the tension below mass i to the one above it; `next` is the mass after the last one of `Vector`.
  template <bool Pushed, class Vector>
  Vector advance(int i, int next, const Constants<Vector>& c, const Vector& below) const noexcept {
    const Vector here = load<Vector>(q + i), moved = load<Vector>(u + i);
    const Vector above =
        c.k * (moved_down(here, q + next) - here) + c.b * (moved_down(moved, u + next) - moved);
    Vector force = (above - moved_up(above, below)) - (c.own_k * here + c.own_b * moved);
    if constexpr (Pushed) force = force + load<Vector>(push + i);
    const Vector moving = moved + c.scale * force;
    store(moving, u_next + i);
    store(here + moving, q + i);
    return above;
  }
};

/// Goes upwards: masses above are at their old places; those below act by their tension.
template <MassRow::Run::Kind kind>
Lanes MassRow::step_lanes(const Pass& where, const Run& run, Lanes below) noexcept {
  const Pass pass = where;  // a copy: no store can alias it
  const int last = run.last;
  auto constants = pass.constants<Lanes>(run.first);
  for (int i = run.first; i < last; i += Lanes::kCount) {
    if constexpr (kind != Run::Kind::Alike) constants = pass.constants<Lanes>(i);
    below = pass.advance<kind == Run::Kind::Pushed>(i, i + Lanes::kCount, constants, below);
  }
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
    const auto row = index(e.row);
    if (std::abs(e.column - e.row) > 1 || e.column >= masses()) {
      left.push_back(e);
      continue;
    }
    // A link to a neighbour is on the diagonal too: the remainder goes to the ground.
    own_k_[row] += e.k;
    own_b_[row] += e.b;
    if (e.column == e.row + 1) k_[row] = -e.k, b_[row] = -e.b;
  }
  let_push(std::vector<bool>(scale.size()));
}

/// The last mass has none above it.
int MassRow::vectorised() const { return in_lanes(masses() - 1); }

bool MassRow::alike(int one, int other) const {
  const auto same = [&](const AlignedNumbers& list) { return list[index(one)] == list[index(other)]; };
  return same(k_) && same(b_) && same(own_k_) && same(own_b_) && same(scale_);
}

MassRow::Run::Kind MassRow::kind_of(int first, const std::vector<bool>& pushed) const {
  auto kind = Run::Kind::Alike;
  for (int i = first; i < first + Lanes::kCount; ++i) {
    if (pushed[index(i)]) return Run::Kind::Pushed;
    if (!alike(i, first)) kind = Run::Kind::Own;
  }
  return kind;
}

void MassRow::let_push(const std::vector<bool>& masses) {
  runs_.clear();
  for (int i = 0; i < vectorised(); i += Lanes::kCount) {
    const auto kind = kind_of(i, masses);
    const bool goes_on = !runs_.empty() && runs_.back().kind == kind &&
                         (kind != Run::Kind::Alike || alike(i, runs_.back().first));
    if (!goes_on) runs_.push_back({kind, i, i});
    runs_.back().last = i + Lanes::kCount;
  }
}

void MassRow::fill(const double* rest, double* push) const noexcept {
  const auto copy = [&](int first, int last) { copy_samples(rest + first, last - first, push + first); };
  for (const auto& run : runs_)
    if (run.kind == Run::Kind::Pushed) copy(run.first, run.last);
  copy(vectorised(), masses());
}

void MassRow::step(double* q, const double* u, double* u_next, const double* push) const noexcept {
  using Kind = Run::Kind;
  const Pass pass{k_.data(), b_.data(), own_k_.data(), own_b_.data(), scale_.data(), u, push, q, u_next};
  Lanes below = Lanes::broadcast(0.0);
  for (const auto& run : runs_)
    below = run.kind == Kind::Alike ? step_lanes<Kind::Alike>(pass, run, below)
            : run.kind == Kind::Own ? step_lanes<Kind::Own>(pass, run, below)
                                    : step_lanes<Kind::Pushed>(pass, run, below);
  double tension = highest(below);
  for (int i = vectorised(); i < masses(); ++i)
    tension = pass.advance<true>(i, std::min(i + 1, masses() - 1), pass.constants<double>(i), tension);
}

}  // namespace tactus
