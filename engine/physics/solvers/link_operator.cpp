#include "engine/physics/solvers/link_operator.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "engine/core/index.h"
#include "engine/physics/numbers.h"

namespace tactus {
namespace {

// Below this many entries on a diagonal the loop over it costs more than it saves.
constexpr std::size_t kShortestDiagonal = 16;

// Diagonals of one pass: a grid has five. More need more registers for addresses than there are.
constexpr std::size_t kMostDiagonals = 5;

}  // namespace

LinkOperator::LinkOperator(std::vector<Entry> entries, std::vector<double> constant)
    : constant_(constant.begin(), constant.end()) {
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.row, a.column) < std::tie(b.row, b.column);
  });
  for (const auto& entry : entries) {
    if (!entries_.empty() && entries_.back().row == entry.row && entries_.back().column == entry.column) {
      entries_.back().k += entry.k;
      entries_.back().b += entry.b;
      entries_.back().inertia += entry.inertia;
    } else {
      entries_.push_back(entry);
    }
  }
  split();
}

void LinkOperator::split() {
  std::map<int, std::vector<Entry>> by_offset;
  for (const auto& entry : entries_) by_offset[entry.column - entry.row].push_back(entry);
  const auto masses = constant_.size();
  const bool short_chain = few() && by_offset.size() == 3 && by_offset.begin()->first == -1 &&
                           by_offset.rbegin()->first == 1 && entries_.size() == 3 * masses - 2;
  for (auto& [offset, list] : by_offset) {
    const int first = list.front().row;
    const auto span = index(list.back().row - first + 1);
    if (!short_chain && (list.size() < kShortestDiagonal || 2 * list.size() < span)) continue;
    Diagonal diagonal{offset, first, static_cast<int>(span), AlignedNumbers(span), AlignedNumbers(span)};
    for (const auto& entry : list) {
      diagonal.k[index(entry.row - first)] = entry.k;
      diagonal.b[index(entry.row - first)] = entry.b;
    }
    diagonals_.push_back(std::move(diagonal));
    list.clear();
  }
  chain_ = is_chain();
  if (chain_)
    diagonals_[2].k.push_back(0.0), diagonals_[2].b.push_back(0.0);  // none above the last
  else
    arrange_bands();
  for (const auto& e : entries_)
    if (!by_offset[e.column - e.row].empty()) scattered_.push_back(e);
}

bool LinkOperator::few() const { return constant_.size() < kShortestDiagonal; }

bool LinkOperator::is_chain() const {
  return diagonals_.size() == 3 && diagonals_[0].offset == -1 && diagonals_[1].offset == 0 &&
         diagonals_[2].offset == 1 && diagonals_[1].count == static_cast<int>(constant_.size()) &&
         diagonals_[0].count == diagonals_[1].count - 1 && diagonals_[2].count == diagonals_[0].count;
}

void LinkOperator::apply(const double* q, const double* u, double* y) const noexcept {
  if (chain_ && few())
    apply_chain<true>(q, u, y);
  else if (chain_)
    apply_chain<false>(q, u, y);
  else
    apply_bands(q, u, y);
  apply_scattered(q, u, y);
}

void LinkOperator::apply_scattered(const double* q, const double* u, double* y) const noexcept {
  for (auto e = scattered_.begin(); e != scattered_.end();) {
    const int row = e->row;
    double sum = y[row];  // in a register: through memory each term would wait for the one before
    for (; e != scattered_.end() && e->row == row; ++e) sum -= e->k * q[e->column] + e->b * u[e->column];
    y[row] = sum;
  }
}

/// One pass. K and B are symmetric, so what mass i feels from i - 1 is read from the row of i - 1.
struct LinkOperator::ChainPass {
  const double *constant, *own_k, *own_b, *next_k, *next_b, *q, *u;
  double* y;

  /// `next` is the mass after the last one of `Vector`. From what the mass below does to mass i to what mass
  /// i does to the one above. Few masses add up in the order of the columns, as those do that are no chain.
  template <bool BelowFirst, class Vector>
  Vector apply(int i, int next, const Vector& below) const noexcept {
    const Vector here = load<Vector>(q + i), moved = load<Vector>(u + i);
    const Vector k = load<Vector>(next_k + i), b = load<Vector>(next_b + i), up = k * here + b * moved;
    const Vector own = load<Vector>(own_k + i) * here + load<Vector>(own_b + i) * moved;
    const Vector above = k * moved_down(here, q + next) + b * moved_down(moved, u + next);
    const Vector c = load<Vector>(constant + i), under = moved_up(up, below);
    store(BelowFirst ? ((c - under) - own) - above : ((c - own) - above) - under, y + i);
    return up;
  }
};

template <bool BelowFirst>
void LinkOperator::apply_chain(const double* q, const double* u, double* y) const noexcept {
  const auto &own = diagonals_[1], &next = diagonals_[2];
  const ChainPass pass{constant_.data(), own.k.data(), own.b.data(), next.k.data(), next.b.data(), q, u, y};
  const int last = own.count - 1, vectorised = in_lanes(last);
  Lanes below = Lanes::broadcast(0.0);
  for (int i = 0; i < vectorised; i += Lanes::kCount)
    below = pass.apply<BelowFirst>(i, i + Lanes::kCount, below);
  double up = highest(below);
  for (int i = vectorised; i <= last; ++i) up = pass.apply<BelowFirst>(i, std::min(i + 1, last), up);
}

/// From each row at which a diagonal begins or ends to the next.
void LinkOperator::arrange_bands() {
  std::vector<int> ends = {0, static_cast<int>(constant_.size())};
  for (const auto& d : diagonals_) ends.insert(ends.end(), {d.first, d.first + d.count});
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  for (std::size_t i = 0; i + 1 < ends.size(); ++i) {
    std::vector<const Diagonal*> covering;
    for (const auto& d : diagonals_)
      if (d.covers(ends[i])) covering.push_back(&d);
    std::size_t done = 0;
    do {
      const auto now = std::min(kMostDiagonals, covering.size() - done);
      bands_.push_back(band(ends[i], ends[i + 1], std::span(covering).subspan(done, now)));
      bands_.back().goes_on = done > 0;
      done += now;
    } while (done < covering.size());
  }
  diagonals_.clear();
}

LinkOperator::Band LinkOperator::band(int first, int last, std::span<const Diagonal* const> diagonals) const {
  Band band{first, last - first, false, {}, {}};
  for (const auto* d : diagonals) band.offsets.push_back(d->offset);
  const int vectorised = in_lanes(band.count);
  for (int row = 0; row < band.count;) {
    const int rows = row < vectorised ? Lanes::kCount : 1;
    for (const auto* d : diagonals)
      for (const auto* values : {&d->k, &d->b})
        for (int lane = 0; lane < rows; ++lane)
          band.values.push_back(-(*values)[index(first + row + lane - d->first)]);
    row += rows;
  }
  return band;
}

template <int Diagonals>
void LinkOperator::apply_band(const Band& band, const double* q, const double* u, double* y) const noexcept {
  std::array<std::ptrdiff_t, Diagonals> offsets;
  std::copy_n(band.offsets.begin(), Diagonals, offsets.begin());
  const double* start = (band.goes_on ? y : constant_.data()) + band.first;
  const double* values = band.values.data();
  q += band.first, u += band.first, y += band.first;
  for_all(index(band.count), [=]<class Vector>(std::size_t i) {
    constexpr std::size_t kWidth = sizeof(Vector) / sizeof(double);
    Vector sum = load<Vector>(start + i);
    const double* value = values + 2 * Diagonals * i;
    for (const auto offset : offsets) {
      sum = fused_multiply_add(load<Vector>(value), load<Vector>(q + i + offset), sum);
      sum = fused_multiply_add(load<Vector>(value + kWidth), load<Vector>(u + i + offset), sum);
      value += 2 * kWidth;
    }
    store(sum, y + i);
  });
}

void LinkOperator::apply_bands(const double* q, const double* u, double* y) const noexcept {
  const auto apply = [&]<int... Diagonals>(const Band& band, std::integer_sequence<int, Diagonals...>) {
    (void)((std::ssize(band.offsets) == Diagonals && (apply_band<Diagonals>(band, q, u, y), true)) || ...);
  };
  for (const auto& band : bands_) apply(band, std::make_integer_sequence<int, kMostDiagonals + 1>{});
}

LinkOperator::Sums LinkOperator::sums() const {
  Sums sums;
  sums.chain = chain_, sums.below_first = chain_ && few(), sums.plain = scattered_;
  const auto list = [](const AlignedNumbers& numbers) { return std::vector(numbers.begin(), numbers.end()); };
  sums.constant = list(constant_);
  if (chain_) {
    sums.own_k = list(diagonals_[1].k), sums.own_b = list(diagonals_[1].b);
    sums.next_k = list(diagonals_[2].k), sums.next_b = list(diagonals_[2].b);
  }
  for (const auto& band : bands_) {
    const int vectorised = in_lanes(band.count), diagonals = static_cast<int>(std::ssize(band.offsets));
    for (int row = 0; row < band.count; ++row) {
      const int width = row < vectorised ? Lanes::kCount : 1, lane = row % width;
      const double* value = band.values.data() + 2 * diagonals * (row - lane) + lane;
      for (const int offset : band.offsets) {
        sums.fused.push_back({band.first + row, band.first + row + offset, value[0], value[width]});
        value += 2 * width;
      }
    }
  }
  std::ranges::stable_sort(sums.fused, {}, &Entry::row);
  return sums;
}

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

  /// From the thrust below mass i to the one above it; `next` is the mass above that of the lowest lane.
  template <bool Pushed, class Vector>
  Vector advance(int i, int next, const Constants<Vector>& c, const Vector& below) const noexcept {
    const Vector here = load<Vector>(q + i), moved = load<Vector>(u + i);
    const Vector above =
        fused_multiply_add(c.b, moved - load<Vector>(u + next), c.k * (here - load<Vector>(q + next)));
    Vector force = fused_multiply_add(c.own_k, here, moved_up(above, below) - above);
    force = fused_multiply_add(c.own_b, moved, force);
    if constexpr (Pushed) force = force + load<Vector>(push + i);
    const Vector moving = fused_multiply_add(c.scale, force, moved);
    store(moving, u_next + i);
    store(here + moving, q + i);
    return above;
  }
};

/// Goes upwards: masses above are at their old places; those below act by their thrust.
template <MassRow::Run::Kind kind>
Lanes MassRow::step_lanes(const Pass& where, const Run& run, Lanes below) noexcept {
  const Pass pass = where;  // a copy: no store can alias it
  const int last = run.last;
  auto constants = pass.constants<Lanes>(run.first);
  for (int i = run.first; i < last; i += Lanes::kCount) {
    if constexpr (kind != Run::Kind::Alike) constants = pass.constants<Lanes>(i);
    below = pass.advance<kind == Run::Kind::Pushed>(i, i + 1, constants, below);
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
    own_k_[row] -= e.k;
    own_b_[row] -= e.b;
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

MassRow::Masses MassRow::numbers() const {
  const auto list = [](const AlignedNumbers& numbers) { return std::vector(numbers.begin(), numbers.end()); };
  Masses all{list(k_), list(b_), list(own_k_), list(own_b_), list(scale_), std::vector<bool>(scale_.size())};
  for (int i = vectorised(); i < masses(); ++i) all.pushed[index(i)] = true;
  for (const auto& run : runs_)
    for (int i = run.first; i < run.last; ++i) all.pushed[index(i)] = run.kind == Run::Kind::Pushed;
  return all;
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
  double thrust = highest(below);
  for (int i = vectorised(); i < masses(); ++i)
    thrust = pass.advance<true>(i, std::min(i + 1, masses() - 1), pass.constants<double>(i), thrust);
}

}  // namespace tactus
