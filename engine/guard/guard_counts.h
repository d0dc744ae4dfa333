#pragma once
// Thread: [any]

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus {

/// How often a stage of the guard intervened: frames, and the largest reduction, in full scale.
struct StageCount {
  std::int64_t frames = 0;
  double most = 0.0;

  bool operator==(const StageCount&) const = default;
};

enum class GuardStage { NonFinite, Heat, Dc, Excursion, Ceiling, Slew };
inline constexpr std::size_t kGuardStages = 6;

/// All stages of the guard of one channel.
struct GuardCounts {
  std::array<StageCount, kGuardStages> stages{};

  StageCount& operator[](GuardStage stage) noexcept { return stages[static_cast<std::size_t>(stage)]; }
  const StageCount& operator[](GuardStage stage) const noexcept {
    return stages[static_cast<std::size_t>(stage)];
  }
  bool operator==(const GuardCounts&) const = default;
};

}  // namespace tactus
