#pragma once

// Thread: [realtime]; constructors [control].

#include <algorithm>
#include <array>
#include <complex>
#include <vector>

#include "engine/dsp/resonators/modal_kernel.h"
#include "engine/dsp/simd/lanes.h"

namespace tactus {

/// [any] From x to out, at any z^-1.
inline std::complex<double> mode_response(const tactus_mode& mode, std::complex<double> delay) {
  return mode.gain * delay / ((1.0 - delay) * (1.0 - mode.turn * delay) + mode.pull * delay * delay);
}

/// `tactus_modal_step` vectorised: four registers of eight modes step together through the frames, so that
/// the latency of one is hidden by the others. The output is the same for any cutting into blocks. Error
/// against exact arithmetic: a rounding of y a frame while the mode lasts.
class ModalBank {
 public:
  /// [control] All modes are silent.
  explicit ModalBank(int modes)
      : groups_(static_cast<std::size_t>((modes + Lanes::kCount - 1) / Lanes::kCount)) {
    for (auto& group : groups_)
      for (int lane = 0; lane < Lanes::kCount; ++lane)
        tactus_modes_set(&group, lane, tactus_mode_design(0, 1, 0, 1));
  }

  /// [realtime] From the next frame on; ringing continues.
  void set(int mode, const tactus_mode& design) noexcept {
    tactus_modes_set(&groups_[static_cast<std::size_t>(mode / Lanes::kCount)], mode % Lanes::kCount, design);
  }

  /// [realtime] `in_before[n]` is the input one frame before `out[n]`; the two may be the same memory.
  void run(const double* in_before, double* out, int frames) noexcept {
    for (int done = 0; done < frames; done += kMaxFrames)
      run_block(in_before + done, out + done, std::min(kMaxFrames, frames - done));
  }

  void reset() noexcept {
    for (auto& group : groups_)
      for (auto* row : {&group.last, &group.before, &group.change}) std::fill_n(*row, Lanes::kCount, 0.0);
  }

  /// [realtime] A mode continues from the state of one of `other`, until `set`.
  void adopt(int mode, const ModalBank& other, int from) noexcept {
    using Modes = tactus_modes;
    auto& group = groups_[static_cast<std::size_t>(mode / Lanes::kCount)];
    const auto& old = other.groups_[static_cast<std::size_t>(from / Lanes::kCount)];
    for (const auto row : {&Modes::turn, &Modes::minus_pull, &Modes::cosine, &Modes::sine, &Modes::last,
                           &Modes::before, &Modes::change})
      (group.*row)[mode % Lanes::kCount] = (old.*row)[from % Lanes::kCount];
  }

 private:
  static constexpr int kMaxFrames = 64;  ///< frames worked on at once
  struct alignas(64) Group : tactus_modes {};
  struct alignas(64) Sums {
    std::array<std::array<double, Lanes::kCount>, kMaxFrames> rows;
  };

  /// Count groups in registers. Written out one by one: in arrays or loops they would go through memory.
  template <int Count, class = void>
  class InRegisters {
   public:
    explicit InRegisters(const Group* group) noexcept
        : turn_(Lanes::load(group->turn)),
          minus_pull_(Lanes::load(group->minus_pull)),
          gain_(Lanes::load(group->gain)),
          last_(Lanes::load(group->last)),
          before_(Lanes::load(group->before)),
          change_(Lanes::load(group->change)),
          others_(group + 1) {}

    /// One frame; returns `sum` with these modes added.
    Lanes step(Lanes in, Lanes sum) noexcept {
      change_ = fused_multiply_add(turn_, change_, fused_multiply_add(minus_pull_, before_, in));
      before_ = last_;
      last_ = last_ + change_;
      return others_.step(in, fused_multiply_add(gain_, last_, sum));
    }

    void store(Group* group) const noexcept {
      last_.store(group->last);
      before_.store(group->before);
      change_.store(group->change);
      others_.store(group + 1);
    }

   private:
    Lanes turn_, minus_pull_, gain_, last_, before_, change_;
    InRegisters<Count - 1> others_;
  };

  template <class None>
  class InRegisters<0, None> {
   public:
    explicit InRegisters(const Group*) noexcept {}
    Lanes step(Lanes, Lanes sum) noexcept { return sum; }
    void store(Group*) const noexcept {}
  };

  template <int Count>
  static void advance(Group* groups, const double* x, Sums& sums, int frames) noexcept {
    InRegisters<Count> modes(groups);
    for (int n = 0; n < frames; ++n) {
      double* sum = sums.rows[static_cast<std::size_t>(n)].data();
      modes.step(Lanes::broadcast(x[n]), Lanes::load(sum)).store(sum);
    }
    modes.store(groups);
  }

  void run_block(const double* x, double* y, int frames) noexcept {
    Sums sums;
    std::fill_n(sums.rows.begin(), frames, std::array<double, Lanes::kCount>{});
    std::size_t done = 0;
    for (; done + 4 <= groups_.size(); done += 4) advance<4>(&groups_[done], x, sums, frames);
    const auto left = groups_.size() - done;
    if (left >= 2) advance<2>(&groups_[done], x, sums, frames);
    if (left % 2 == 1) advance<1>(&groups_.back(), x, sums, frames);
    for (int n = 0; n < frames; ++n) y[n] = Lanes::load(sums.rows[static_cast<std::size_t>(n)].data()).sum();
  }

  std::vector<Group> groups_;
};

}  // namespace tactus
