#pragma once

// Thread: [control]; frequencies and decays [realtime].

#include <vector>

#include "engine/graph/node_type.h"

namespace tactus {

/// Frequencies and decays of the modes of a node, as its file lists or generates them. Ports and settings are
/// the same for all nodes that have modes.
class ModeTable {
 public:
  /// [control] Errors: OutOfRange where lists do not fit each other, or a list and a series are there.
  static Result<ModeTable> make(const NodeSetup& setup);

  std::size_t size() const noexcept { return frequencies_.size(); }
  /// Of a mode, the ports `frequency` and `decay` being at these values. Any value gives a valid mode.
  double frequency_hz(std::size_t mode, double first_hz) const noexcept;
  double decay_s(std::size_t mode, double first_s) const noexcept;
  /// (f_1 / f_k)^slope
  double falling(std::size_t mode, double slope) const;

 private:
  std::vector<double> frequencies_, decays_;
  bool frequency_moves_ = true, decay_moves_ = true;  ///< else as listed
};

/// Of the first mode; the others follow it.
InputPort mode_frequency_input();
InputPort mode_decay_input();
/// `further` are the node's own; they come last.
std::vector<Setting> mode_settings(std::vector<Setting> further);

/// One number a mode from a list of none (then `otherwise`), one or all. Errors: OutOfRange.
Result<std::vector<double>> one_each(const SettingValue& list, std::string_view name, std::size_t modes,
                                     double otherwise);

}  // namespace tactus
