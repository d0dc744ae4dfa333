#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "engine/plot/svg.h"
#include "engine/plot/svg_layout.h"

namespace tactus::svg {

inline constexpr double kFont = 11.5;  // [px]
inline constexpr const char* kInk = "#222222";
inline constexpr const char* kSoft = "#5f5f5f";

/// A colour as it is drawn, and darker as it is written.
struct Shade {
  const char *line, *text;
};
const Shade& shade(PlotColor color);

/// The text of an SVG document, element after element.
class Canvas {
 public:
  void line(double x1, double y1, double x2, double y2, const char* stroke, double width,
            const char* more = "");
  void text(double x, double y, const std::string& text, const char* anchor, const char* fill,
            double size = kFont, bool bold = false);
  void path(const std::vector<Point>& line, const char* stroke, bool dashed);
  void dot(const Point& at, const char* fill);
  template <class... Args>
  void out(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

/// Safe between tags and in attributes.
std::string escape(const std::string& text);

/// What was drawn, as a document on white ground that readers without eyes know by `title`.
std::string document(const std::string& drawn, const std::string& title, int width, double height);

/// Errors: BadFile.
[[nodiscard]] Status write_document(const std::filesystem::path& path, const std::string& document);

}  // namespace tactus::svg
