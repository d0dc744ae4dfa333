#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "engine/dsp/curves/catmull_rom.h"

namespace tactus {

/// One period of a wave, read at any phase. Not band-limited: partials above half the sample rate fold back,
/// so a table for high notes must hold few partials.
class WaveTable {
 public:
  /// [control] `period` holds at least one value.
  explicit WaveTable(std::vector<double> period) : period_(std::move(period)) {}

  /// [any] 0 <= turns <= 1.
  double linear(double turns) const {
    const auto [index, at] = place(turns);
    const double here = value(index);
    return here + at * (value(index + 1) - here);
  }
  /// [any] 0 <= turns <= 1.
  double cubic(double turns) const {
    const auto [index, at] = place(turns);
    return catmull_rom(value(index + period_.size() - 1), value(index), value(index + 1), value(index + 2),
                       at);
  }

 private:
  struct Place {
    std::size_t index;
    double at;
  };
  Place place(double turns) const {
    const double position = turns * static_cast<double>(period_.size());
    const auto index = static_cast<std::size_t>(position);
    return {index, position - static_cast<double>(index)};
  }
  double value(std::size_t index) const { return period_[index % period_.size()]; }

  std::vector<double> period_;
};

}  // namespace tactus
