#include "backends/health.h"

namespace tactus {

const char* name_of(Gap gap) {
  constexpr std::array<const char*, kGaps> kNames{"input", "output", "server", "unsaid"};
  return kNames[static_cast<std::size_t>(gap)];
}

}  // namespace tactus
