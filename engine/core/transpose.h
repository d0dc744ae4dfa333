#pragma once

#include <array>
#include <cstring>

namespace tactus {

/// Rows of samples to frames of lanes and back, eight by eight in the vector registers. Bits stay as they
/// are.
class Transpose {
 public:
  static constexpr int kCount = 8;
  using Row = double __attribute__((vector_size(kCount * sizeof(double))));

  /// [realtime] out[n * kCount + k] = in[k][n]
  static void pack(const std::array<const double*, kCount>& in, double* out, int frames) noexcept {
    pack(in, out, frames, [](auto samples) { return samples; });
  }
  /// [realtime] out[n * kCount + k] = change(in[k][n]). `change` takes and returns a double, or a Row of
  /// them.
  template <class Change>
  static void pack(const std::array<const double*, kCount>& in, double* out, int frames,
                   const Change& change) noexcept {
    int n = 0;
    for (; n + kCount <= frames; n += kCount, out += kCount * kCount) {
      Square square;
      for (std::size_t k = 0; k < kCount; ++k) {
        std::memcpy(&square[k], in[k] + n, sizeof(Row));
        square[k] = change(square[k]);
      }
      turn(square);
      std::memcpy(out, square.data(), sizeof square);
    }
    for (; n < frames; ++n)
      for (const double* lane : in) *out++ = change(lane[n]);
  }

  /// [realtime] out[k][n] = in[n * kCount + k]
  static void unpack(const double* in, const std::array<double*, kCount>& out, int frames) noexcept {
    int n = 0;
    for (; n + kCount <= frames; n += kCount, in += kCount * kCount) {
      Square square;
      std::memcpy(square.data(), in, sizeof square);
      turn(square);
      for (std::size_t k = 0; k < kCount; ++k) std::memcpy(out[k] + n, &square[k], sizeof(Row));
    }
    for (; n < frames; ++n)
      for (double* lane : out) lane[n] = *in++;
  }

 private:
  using Square = std::array<Row, kCount>;

  /// In three rounds, each of which exchanges quarters of squares of 2, 4 and 8.
  static void turn(Square& s) noexcept {
    Square t;
    for (std::size_t k = 0; k < 8; k += 2) {
      t[k] = __builtin_shufflevector(s[k], s[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
      t[k + 1] = __builtin_shufflevector(s[k], s[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
    }
    for (std::size_t k = 0; k < 8; k += 4)
      for (std::size_t i = k; i < k + 2; ++i) {
        s[i] = __builtin_shufflevector(t[i], t[i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
        s[i + 2] = __builtin_shufflevector(t[i], t[i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
      }
    for (std::size_t i = 0; i < 4; ++i) {
      t[i] = __builtin_shufflevector(s[i], s[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
      t[i + 4] = __builtin_shufflevector(s[i], s[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
    s = t;
  }
};

}  // namespace tactus
