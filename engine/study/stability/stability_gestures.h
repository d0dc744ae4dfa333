#pragma once

// Thread: [control].

#include <functional>
#include <vector>

#include "engine/study/stability/stability.h"

namespace tactus {

/// Of a scene whose gestures move controls of the instrument: where each control is highest and lowest, and
/// where what decays least along the way between grows. Empty without a scene. Errors: those of the scene.
Checked<std::vector<GestureVerdict>> judge_gestures(const StabilitySubject& subject,
                                                    const StabilityOptions& options, Hertz rate,
                                                    const std::function<void()>& progress);

}  // namespace tactus
