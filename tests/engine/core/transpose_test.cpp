#include "engine/core/transpose.h"

#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

using namespace tactus;

TEST_CASE("transpose: every sample lands in its place, both ways, for any number of frames", "[core]") {
  constexpr std::size_t kLanes = Transpose::kCount;
  for (int frames = 1; frames <= 35; ++frames) {
    const auto count = static_cast<std::size_t>(frames);
    std::vector<double> rows(kLanes * count), wide(kLanes * count), back(kLanes * count);
    std::iota(rows.begin(), rows.end(), 1.0);  // lane k, frame n: 1 + k frames + n
    std::array<const double*, kLanes> in;
    std::array<double*, kLanes> out;
    for (std::size_t k = 0; k < kLanes; ++k) {
      in[k] = rows.data() + k * count;
      out[k] = back.data() + k * count;
    }
    Transpose::pack(in, wide.data(), frames);
    for (std::size_t n = 0; n < count; ++n)
      for (std::size_t k = 0; k < kLanes; ++k)
        CHECK(wide[n * kLanes + k] == 1.0 + static_cast<double>(k * count + n));
    Transpose::unpack(wide.data(), out, frames);
    CHECK(back == rows);
  }
}
