#pragma once
// Thread: [control]

#include <fmt/format.h>

#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "engine/plot/layout.h"

namespace tactus::plot {

inline constexpr double kFont = 11.5, kTitleFont = 17, kSubtitleFont = 12.5;  // [px]

/// Text that is safe between tags.
std::string escape(const std::string& text);
/// A colour of the ramp, "#00204c" for 0 to "#ffea46" for 1.
std::string ramp_color(double share);
/// The class of an element, "s" for strokes, "f" for areas, "t" for text.
inline std::string css(char kind, PlotColor color) {
  return fmt::format("{}{}", kind, static_cast<int>(color));
}

/// The text of an SVG document, element after element.
class Canvas {
 public:
  template <class... Args>
  void out(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  void line(const Point& a, const Point& b, const std::string& css, double width = 1, const char* more = "") {
    out("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" class=\"{}\" "
        "stroke-width=\"{}\"{}/>\n",
        a.x, a.y, b.x, b.y, css, width, more);
  }
  void text(double x, double y, const std::string& text, const char* anchor, const std::string& css,
            double size = kFont, bool bold = false) {
    out("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" class=\"{}\"", x, y, anchor, css);
    if (size != kFont) out(" font-size=\"{}\"", size);
    out("{}>{}</text>\n", bold ? " font-weight=\"bold\"" : "", escape(text));
  }
  void rect(double x, double y, double width, double height, const std::string& attributes) {
    out("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" {}/>\n", x, y, width, height,
        attributes);
  }
  void path(const std::vector<Point>& line, PlotColor color, bool dashed) {
    out("<path fill=\"none\" class=\"{}\" stroke-width=\"1.6\" stroke-linejoin=\"round\"{} d=\"",
        css('s', color), dashed ? " stroke-dasharray=\"5 3\"" : "");
    for (std::size_t i = 0; i < line.size(); ++i)
      out("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", line[i].x, line[i].y);
    out("\"/>\n");
  }
  void dot(const Point& at, PlotColor color) {
    out("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" class=\"{} dot\" stroke-width=\"0.8\"/>\n", at.x, at.y,
        css('f', color));
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

/// An SVG document that follows the light or dark theme of the reader.
std::string svg_document(double width, double height, const std::string& title, const std::string& elements);

}  // namespace tactus::plot
