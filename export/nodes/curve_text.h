#pragma once

// Thread: [control].

#include <string>

#include "engine/dsp/curves/curve_kernel.h"
#include "export/nodes/node_writer.h"

namespace tactus {

/// As kernels call it.
inline std::string curve_shape_name(tactus_curve_shape shape) {
  switch (shape) {
    case TACTUS_CURVE_STEP:
      return "TACTUS_CURVE_STEP";
    case TACTUS_CURVE_EXPONENTIAL:
      return "TACTUS_CURVE_EXPONENTIAL";
    case TACTUS_CURVE_CUBIC:
      return "TACTUS_CURVE_CUBIC";
    default:
      return "TACTUS_CURVE_LINEAR";
  }
}

/// A curve as a constant; returns its name. Only cubics have slopes.
inline std::string write_curve_table(NodeWriter& node, const tactus_curve& curve, bool cubic) {
  const auto count = index(curve.count);
  const auto x = node.table("x", {curve.x, curve.x + count}), y = node.table("y", {curve.y, curve.y + count});
  const auto slope = cubic ? node.table("slope", {curve.slope, curve.slope + count}) : std::string{"0"};
  return node.table("tactus_curve", "points",
                    "{" + std::to_string(curve.count) + ", " + x + ", " + y + ", " + slope + "}",
                    sizeof(tactus_curve));
}

}  // namespace tactus
