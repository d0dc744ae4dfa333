#include "engine/plot/cell_map.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/plot/svg_canvas.h"
#include "engine/plot/svg_plan.h"

namespace tactus {
namespace {

using namespace svg;

constexpr double kHighest = 24, kWidest = 40;  // of a cell [px]
constexpr double kSwatch = 12, kCellMapGap = 22;
constexpr double kTickApart = 4;  // between labels of columns

double widest(const std::vector<std::string>& texts) {
  double most = 0;
  for (const auto& text : texts) most = std::max(most, text_width(text, kFont));
  return most;
}

double legend_width(const CellMap& map) {
  double most = 0;
  for (const auto& key : map.keys) most = std::max(most, text_width(key.label, kFont));
  return map.keys.empty() ? 0 : most + kSwatch + 6 + 14;
}

/// Where one map lies.
struct Frame {
  double left, top, cell_width, cell_height;  ///< of the cells [px]
  std::size_t columns, rows;

  double right() const { return left + cell_width * static_cast<double>(columns); }
  double bottom() const { return top + cell_height * static_cast<double>(rows); }
};

Frame frame_of(const CellMap& map, double x, double y, double width) {
  Frame frame{x + widest(map.y) + 8, y + 36, 0, kHighest, map.x.size(), map.y.size()};
  const double room = x + width - legend_width(map) - frame.left;
  frame.cell_width = std::min(kWidest, room / static_cast<double>(frame.columns));
  return frame;
}

void draw_cells(Canvas& canvas, const CellMap& map, const Frame& frame) {
  for (std::size_t i = 0; i < map.cells.size(); ++i) {
    const auto column = static_cast<double>(i % frame.columns), row = static_cast<double>(i / frame.columns);
    const double x = frame.left + column * frame.cell_width;
    const double y = frame.bottom() - (row + 1) * frame.cell_height;
    canvas.out(
        "<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\" stroke=\"#ffffff\" "
        "stroke-width=\"0.6\"/>\n",
        x, y, frame.cell_width, frame.cell_height, map.cells[i].fill);
    if (!map.cells[i].letter.empty() && frame.cell_width >= 9)
      canvas.text(x + 0.5 * frame.cell_width, y + 0.5 * frame.cell_height + 4, map.cells[i].letter, "middle",
                  "#ffffff", 10);
  }
}

void draw_axes(Canvas& canvas, const CellMap& map, const Frame& frame) {
  const auto every =
      static_cast<std::size_t>(std::max(1.0, std::ceil((widest(map.x) + kTickApart) / frame.cell_width)));
  for (std::size_t i = 0; i < map.x.size(); i += every)
    canvas.text(frame.left + (static_cast<double>(i) + 0.5) * frame.cell_width, frame.bottom() + 15, map.x[i],
                "middle", kSoft);
  for (std::size_t i = 0; i < map.y.size(); ++i)
    canvas.text(frame.left - 6, frame.bottom() - (static_cast<double>(i) + 0.5) * frame.cell_height + 4,
                map.y[i], "end", kSoft);
  canvas.text(0.5 * (frame.left + frame.right()), frame.bottom() + 31, map.x_label, "middle", kInk);
}

void draw_legend(Canvas& canvas, const CellMap& map, const Frame& frame) {
  double y = frame.top + 12;
  for (const auto& key : map.keys) {
    canvas.out("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>\n",
               frame.right() + 14, y - 10, kSwatch, kSwatch, key.fill);
    canvas.text(frame.right() + 14 + kSwatch + 6, y, key.label, "start", kInk);
    y += kLabelRow + 3;
  }
}

/// Returns how high it is.
double draw(Canvas& canvas, const CellMap& map, double x, double y, double width) {
  const auto frame = frame_of(map, x, y, width);
  canvas.text(x, y + 12, map.title, "start", kInk, 13, true);
  canvas.text(x, y + 28, map.y_label, "start", kInk);
  draw_cells(canvas, map, frame);
  draw_axes(canvas, map, frame);
  draw_legend(canvas, map, frame);
  const double legend = frame.top + (kLabelRow + 3) * static_cast<double>(map.keys.size());
  return std::max(frame.bottom() + 36, legend) - y;
}

}  // namespace

std::string ramp_color(double share) {
  struct Color {
    double red, green, blue;
  };
  static constexpr std::array<Color, 6> kCividis = {
      {{0, 32, 76}, {49, 68, 107}, {102, 105, 112}, {149, 143, 120}, {202, 185, 105}, {255, 234, 70}}};
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kCividis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kCividis.size() - 2);
  const double part = place - static_cast<double>(low);
  const auto mix = [&](double Color::*channel) {
    const double from = kCividis[low].*channel, to = kCividis[low + 1].*channel;
    return static_cast<int>(std::lround(from + part * (to - from)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(&Color::red), mix(&Color::green), mix(&Color::blue));
}

std::string to_svg(const CellPage& page) {
  Canvas canvas;
  double y = kPad;
  const auto write = [&](const std::string& text, double size, double row, const char* ink) {
    for (const auto& line : wrap(text, size, page.width - 2 * kPad)) {
      y += row;
      canvas.text(kPad, y - 5, line, "start", ink, size, size > kSubtitleFont);
    }
  };
  write(page.title, kTitleFont, kTitleRow, kInk);
  write(page.subtitle, kSubtitleFont, kSubtitleRow, kSoft);
  y += 8;
  const double width = (page.width - 2 * kPad - kCellMapGap * (page.columns - 1)) / page.columns;
  double highest = 0;
  for (std::size_t i = 0; i < page.maps.size(); ++i) {
    const auto column = static_cast<int>(i) % page.columns;
    if (column == 0) y += highest + (i == 0 ? 0 : kCellMapGap), highest = 0;
    highest = std::max(highest, draw(canvas, page.maps[i], kPad + column * (width + kCellMapGap), y, width));
  }
  return document(canvas.take(), page.title, page.width, y + highest + kPad);
}

Status write_svg(const std::filesystem::path& path, const CellPage& page) {
  return write_document(path, to_svg(page));
}

}  // namespace tactus
