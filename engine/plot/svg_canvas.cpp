#include "engine/plot/svg_canvas.h"

#include <array>
#include <cstddef>
#include <fstream>

namespace tactus::svg {
namespace {

constexpr std::array<Shade, 9> kShades = {{{"", ""},
                                           {"#0072b2", "#00609a"},
                                           {"#d55e00", "#b34700"},
                                           {"#009e73", "#007a58"},
                                           {"#b0609a", "#974a82"},
                                           {"#e69f00", "#8f6200"},
                                           {"#56b4e9", "#1f7db5"},
                                           {"#8a8a8a", "#5f5f5f"},
                                           {"#222222", "#222222"}}};

}  // namespace

const Shade& shade(PlotColor color) { return kShades[static_cast<std::size_t>(color)]; }

std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '"')
      safe += "&quot;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      safe += c;
  }
  return safe;
}

void Canvas::line(double x1, double y1, double x2, double y2, const char* stroke, double width,
                  const char* more) {
  out("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
      x1, y1, x2, y2, stroke, width, more);
}

void Canvas::text(double x, double y, const std::string& text, const char* anchor, const char* fill,
                  double size, bool bold) {
  out("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\" fill=\"{}\" font-size=\"{}\"{}>{}</text>\n", x, y,
      anchor, fill, size, bold ? " font-weight=\"bold\"" : "", escape(text));
}

void Canvas::path(const std::vector<Point>& line, const char* stroke, bool dashed) {
  out("<path fill=\"none\" stroke=\"{}\" stroke-width=\"1.6\" stroke-linejoin=\"round\"{} d=\"", stroke,
      dashed ? " stroke-dasharray=\"5 3\"" : "");
  for (std::size_t i = 0; i < line.size(); ++i)
    out("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", line[i].x, line[i].y);
  out("\"/>\n");
}

void Canvas::dot(const Point& at, const char* fill) {
  out("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3.2\" fill=\"{}\" stroke=\"#ffffff\" "
      "stroke-width=\"0.8\"/>\n",
      at.x, at.y, fill);
}

std::string document(const std::string& drawn, const std::string& title, int width, double height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1:.0f}\" viewBox=\"0 0 {0} "
      "{1:.0f}\" "
      "role=\"img\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<title>{2}</title>\n"
      "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n{3}</svg>\n",
      width, height, escape(title), drawn);
}

Status write_document(const std::filesystem::path& path, const std::string& document) {
  std::ofstream file{path, std::ios::binary};
  file << document;
  file.close();
  if (file) return {};
  return fail(Errc::BadFile, path.string(), "the plot cannot be written",
              "check that the folder exists and may be written to");
}

}  // namespace tactus::svg
