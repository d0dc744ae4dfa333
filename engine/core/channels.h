#pragma once

#include <cstddef>
#include <vector>

namespace tactus {

/// The samples of one block, channel by channel, with the pointers that BlockIo takes.
class ChannelBuffers {
 public:
  ChannelBuffers() = default;
  /// [control] Zeros.
  ChannelBuffers(int channels, int frames) { resize(channels, frames); }
  ChannelBuffers(ChannelBuffers&&) = default;
  ChannelBuffers& operator=(ChannelBuffers&&) = default;

  /// [control] Zeros, whatever was here before.
  void resize(int channels, int frames) {
    const auto length = static_cast<std::size_t>(frames);
    samples_.assign(static_cast<std::size_t>(channels) * length, 0.0);
    pointers_.clear();
    for (int c = 0; c < channels; ++c)
      pointers_.push_back(samples_.data() + static_cast<std::size_t>(c) * length);
  }

  /// [any]
  int size() const noexcept { return static_cast<int>(pointers_.size()); }
  double* operator[](int channel) const noexcept { return pointers_[static_cast<std::size_t>(channel)]; }
  double* const* data() const noexcept { return pointers_.data(); }
  auto begin() const noexcept { return pointers_.begin(); }
  auto end() const noexcept { return pointers_.end(); }

 private:
  std::vector<double> samples_;
  std::vector<double*> pointers_;
};

}  // namespace tactus
