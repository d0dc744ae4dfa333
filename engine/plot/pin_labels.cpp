#include "engine/plot/pin_labels.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::svg {
namespace {

constexpr double kPinLabelsGap = 7;  // from a point to its label [px]
constexpr double kHalfLine = 6.0;    // half the height of a line of text
constexpr double kStep = 4;          // between the boxes along a line

struct Side {
  double right, down;
};
constexpr std::array<Side, 8> kSides = {
    {{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {1, -1}, {1, 1}, {-1, -1}, {-1, 1}}};

Box box_at(const Point& pin, const Side& side, double width) {
  const double middle = pin.x + side.right * (kPinLabelsGap + 0.5 * width);
  const double line = pin.y + side.down * (kPinLabelsGap + kHalfLine);
  return {middle - 0.5 * width, line - kHalfLine, middle + 0.5 * width, line + kHalfLine};
}

}  // namespace

void PinLabels::take(const std::vector<Point>& line) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double dx = line[i].x - line[i - 1].x, dy = line[i].y - line[i - 1].y;
    const int steps = 1 + static_cast<int>(std::min(1e4, std::hypot(dx, dy) / kStep));
    for (int n = 0; n <= steps; ++n) {
      const double x = line[i - 1].x + dx * n / steps, y = line[i - 1].y + dy * n / steps;
      taken_.push_back({x - 1, y - 1, x + 1, y + 1});
    }
  }
}

PinLabels::Place PinLabels::beside(const Point& pin, double width) {
  const auto free = [&](const Side& side) {
    const auto box = box_at(pin, side, width);
    return box.within(plot_) &&
           std::none_of(taken_.begin(), taken_.end(), [&](const Box& other) { return other.meets(box); });
  };
  const auto found = std::find_if(kSides.begin(), kSides.end(), free);
  const auto side = found == kSides.end() ? kSides.front() : *found;
  const auto box = box_at(pin, side, width);
  taken_.push_back(box);
  const char* anchor = side.right > 0 ? "start" : side.right < 0 ? "end" : "middle";
  return {pin.x + side.right * kPinLabelsGap, box.bottom - 2, anchor};
}

}  // namespace tactus::svg
