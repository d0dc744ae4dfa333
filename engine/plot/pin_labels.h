#pragma once

#include <vector>

#include "engine/plot/svg_layout.h"

namespace tactus::svg {

/// A place on the picture [px].
struct Box {
  double left, top, right, bottom;

  bool meets(const Box& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
  bool within(const Box& other) const {
    return left >= other.left && right <= other.right && top >= other.top && bottom <= other.bottom;
  }
};

/// Finds room for the labels of points within a plot, where nothing stands yet.
class PinLabels {
 public:
  explicit PinLabels(const Box& plot) : plot_(plot) {}

  void take(const Box& box) { taken_.push_back(box); }
  /// All along a line.
  void take(const std::vector<Point>& line);

  /// A line of text beside a point: where its anchor and its foot lie.
  struct Place {
    double x, y;
    const char* anchor;
  };
  /// Right of the point if there is room, else left, above, below, or on a corner; right if nowhere. The
  /// place is taken from then on. The width is an estimate, so the end that is near the point is the one that
  /// holds.
  Place beside(const Point& pin, double width);

 private:
  Box plot_;
  std::vector<Box> taken_;
};

}  // namespace tactus::svg
