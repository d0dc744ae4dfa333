#pragma once

#include <cstddef>
#include <vector>

namespace tactus {

/// The samples of one block, channel by channel, and the pointers that go with them.
struct Planes {
  /// [control]
  Planes(std::size_t channels, int frames)
      : samples(channels, std::vector<double>(static_cast<std::size_t>(frames))) {
    for (auto& channel : samples) pointers.push_back(channel.data());
  }
  Planes(Planes&&) = default;
  Planes(const Planes&) = delete;

  std::vector<std::vector<double>> samples;
  std::vector<double*> pointers;
};

}  // namespace tactus
