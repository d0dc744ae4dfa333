#include "engine/dsp/modal_bank.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus {

ModeDesign::ModeDesign(const Mode& mode, Hertz sample_rate) {
  const double turns = mode.frequency_hz / sample_rate.value;
  if (!(turns > 0 && turns < 0.5)) return;
  const double w = 2 * std::numbers::pi * turns;
  const double decay = std::clamp(mode.decay_s, 1e-4, 1e4);
  const double r = std::exp(-3 * std::numbers::ln10 / (decay * sample_rate.value));
  a1 = 2 * r * std::cos(w);
  a2 = -r * r;
  gain = mode.gain * r * std::sin(w);
}

ModalBank::ModalBank(int modes)
    : bundles_(static_cast<std::size_t>((modes + Lanes::kCount - 1) / Lanes::kCount)) {}

void ModalBank::set(int mode, const ModeDesign& design) noexcept {
  auto& bundle = bundles_[static_cast<std::size_t>(mode / Lanes::kCount)];
  const auto lane = static_cast<std::size_t>(mode % Lanes::kCount);
  bundle.a1[lane] = design.a1;
  bundle.a2[lane] = design.a2;
  bundle.gain[lane] = design.gain;
}

/// Bundles in a row, one inside the other: what stands in an array stays in memory, and each frame would wait
/// for the round trip.
template <int Count>
class ModalBank::InRegisters {
 public:
  explicit InRegisters(const Bundle* bundle) noexcept
      : a1_(Lanes::load(bundle->a1.data())),
        a2_(Lanes::load(bundle->a2.data())),
        gain_(Lanes::load(bundle->gain.data())),
        last_(Lanes::load(bundle->last.data())),
        before_(Lanes::load(bundle->before.data())),
        others_(bundle + 1) {}

  /// One frame; returns `sum` with these modes added.
  Lanes step(Lanes in, Lanes sum) noexcept {
    const auto now = fused_multiply_add(a1_, last_, fused_multiply_add(a2_, before_, in));
    before_ = last_;
    last_ = now;
    return others_.step(in, fused_multiply_add(gain_, now, sum));
  }

  void store(Bundle* bundle) const noexcept {
    last_.store(bundle->last.data());
    before_.store(bundle->before.data());
    others_.store(bundle + 1);
  }

 private:
  Lanes a1_, a2_, gain_, last_, before_;
  InRegisters<Count - 1> others_;
};

template <>
class ModalBank::InRegisters<0> {
 public:
  explicit InRegisters(const Bundle*) noexcept {}
  Lanes step(Lanes, Lanes sum) noexcept { return sum; }
  void store(Bundle*) const noexcept {}
};

template <int Count>
void ModalBank::advance(Bundle* bundles, const double* x, Sums& sums, int frames) noexcept {
  InRegisters<Count> modes(bundles);
  for (int n = 0; n < frames; ++n) {
    double* sum = sums.rows[static_cast<std::size_t>(n)].data();
    modes.step(Lanes::same(x[n]), Lanes::load(sum)).store(sum);
  }
  modes.store(bundles);
}

void ModalBank::run_piece(const double* x, double* y, int frames) noexcept {
  Sums sums;
  std::fill_n(sums.rows.begin(), frames, Row{});
  std::size_t done = 0;
  for (; done + 4 <= bundles_.size(); done += 4) advance<4>(&bundles_[done], x, sums, frames);
  const auto left = bundles_.size() - done;
  if (left >= 2) advance<2>(&bundles_[done], x, sums, frames);
  if (left % 2 == 1) advance<1>(&bundles_.back(), x, sums, frames);
  for (int n = 0; n < frames; ++n) y[n] = Lanes::load(sums.rows[static_cast<std::size_t>(n)].data()).sum();
}

void ModalBank::run(const double* in_before, double* out, int frames) noexcept {
  for (int done = 0; done < frames; done += kLongest)
    run_piece(in_before + done, out + done, std::min(kLongest, frames - done));
}

void ModalBank::reset() noexcept {
  for (auto& bundle : bundles_) bundle.last = bundle.before = {};
}

void ModalBank::adopt(const ModalBank& other) noexcept {
  const auto count = std::min(bundles_.size(), other.bundles_.size());
  for (std::size_t i = 0; i < count; ++i) {
    bundles_[i].last = other.bundles_[i].last;
    bundles_[i].before = other.bundles_[i].before;
  }
}

}  // namespace tactus
