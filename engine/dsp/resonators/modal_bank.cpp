#include "engine/dsp/resonators/modal_bank.h"

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
  cosine = r * std::cos(w);
  sine = r * std::sin(w);
  turn = 2 * cosine - 1;
  pull = (1 - r) * (1 - r) + 4 * r * std::sin(w / 2) * std::sin(w / 2);
  gain = mode.gain * sine;
}

ModalBank::ModalBank(int modes)
    : modes_(modes), bundles_(static_cast<std::size_t>((modes + Lanes::kCount - 1) / Lanes::kCount)) {
  const ModeDesign silent{{.frequency_hz = 0}, Hertz{1}};
  for (auto& bundle : bundles_)
    for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) retune(bundle, lane, silent);
}

void ModalBank::set(int mode, const ModeDesign& design) noexcept {
  auto& bundle = bundles_[static_cast<std::size_t>(mode / Lanes::kCount)];
  const auto lane = static_cast<std::size_t>(mode % Lanes::kCount);
  bundle.gain[lane] = design.gain;
  if (bundle.turn[lane] != design.turn || bundle.minus_pull[lane] != -design.pull)
    retune(bundle, lane, design);
}

/// From y to P by the old design, and back by the new one: Im P = r sin(w) y[n], Re P = r cos(w) y[n] - r^2
/// y[n-1].
void ModalBank::retune(Bundle& bundle, std::size_t lane, const ModeDesign& design) noexcept {
  const double square = bundle.turn[lane] - bundle.minus_pull[lane];
  const double imaginary = bundle.sine[lane] * bundle.last[lane];
  const double real = bundle.cosine[lane] * bundle.last[lane] - square * bundle.before[lane];
  const bool sounds = design.sine > 0;
  bundle.last[lane] = sounds ? imaginary / design.sine : 0;
  bundle.before[lane] = sounds ? (design.cosine * bundle.last[lane] - real) / (design.turn + design.pull) : 0;
  bundle.change[lane] = bundle.last[lane] - bundle.before[lane];
  bundle.turn[lane] = design.turn;
  bundle.minus_pull[lane] = -design.pull;
  bundle.cosine[lane] = design.cosine;
  bundle.sine[lane] = design.sine;
}

/// Consecutive bundles, one nested in the other: an array would stay in memory, with the latency of a store
/// and a load in each frame.
template <int Count>
class ModalBank::InRegisters {
 public:
  explicit InRegisters(const Bundle* bundle) noexcept
      : turn_(Lanes::load(bundle->turn.data())),
        minus_pull_(Lanes::load(bundle->minus_pull.data())),
        gain_(Lanes::load(bundle->gain.data())),
        last_(Lanes::load(bundle->last.data())),
        before_(Lanes::load(bundle->before.data())),
        change_(Lanes::load(bundle->change.data())),
        others_(bundle + 1) {}

  /// One frame; returns `sum` with these modes added.
  Lanes step(Lanes in, Lanes sum) noexcept {
    change_ = fused_multiply_add(turn_, change_, fused_multiply_add(minus_pull_, before_, in));
    before_ = last_;
    last_ = last_ + change_;
    return others_.step(in, fused_multiply_add(gain_, last_, sum));
  }

  void store(Bundle* bundle) const noexcept {
    last_.store(bundle->last.data());
    before_.store(bundle->before.data());
    change_.store(bundle->change.data());
    others_.store(bundle + 1);
  }

 private:
  Lanes turn_, minus_pull_, gain_, last_, before_, change_;
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
    modes.step(Lanes::broadcast(x[n]), Lanes::load(sum)).store(sum);
  }
  modes.store(bundles);
}

void ModalBank::run_block(const double* x, double* y, int frames) noexcept {
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
  for (int done = 0; done < frames; done += kMaxFrames)
    run_block(in_before + done, out + done, std::min(kMaxFrames, frames - done));
}

void ModalBank::reset() noexcept {
  for (auto& bundle : bundles_) bundle.last = bundle.before = bundle.change = {};
}

void ModalBank::adopt(const ModalBank& other) noexcept {
  const int count = std::min(modes_, other.modes_);
  for (int k = 0; k < count; ++k) {
    auto& to = bundles_[static_cast<std::size_t>(k / Lanes::kCount)];
    const auto& from = other.bundles_[static_cast<std::size_t>(k / Lanes::kCount)];
    const auto lane = static_cast<std::size_t>(k % Lanes::kCount);
    for (const auto row : {&Bundle::turn, &Bundle::minus_pull, &Bundle::cosine, &Bundle::sine, &Bundle::last,
                           &Bundle::before, &Bundle::change})
      (to.*row)[lane] = (from.*row)[lane];
  }
}

}  // namespace tactus
