#include "engine/plot/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace tactus::plot {
namespace {

/// A colour of lines and areas, and of text, in the light and in the dark theme.
struct Shade {
  const char *line, *text, *dark_line, *dark_text;
};
constexpr std::array<Shade, 9> kShades = {{{"none", "none", "none", "none"},
                                           {"#0072b2", "#00609a", "#3a9fe0", "#6bb8ea"},
                                           {"#d55e00", "#b34700", "#ef7d2b", "#f59a58"},
                                           {"#009e73", "#007a58", "#1fbf92", "#45d0a8"},
                                           {"#b0609a", "#974a82", "#cc84b9", "#dba2cb"},
                                           {"#e69f00", "#8f6200", "#e9ad2b", "#f0c361"},
                                           {"#56b4e9", "#1f7db5", "#56b4e9", "#83c8ef"},
                                           {"#8a8a8a", "#5f5f5f", "#8f8f8f", "#b0b0b0"},
                                           {"#222222", "#222222", "#e6e6e6", "#e6e6e6"}}};
/// Everything that is not data.
struct Theme {
  const char *page, *ink, *soft, *grid, *zero, *axis;
};
constexpr Theme kLight = {"#ffffff", "#222222", "#5f5f5f", "#e6e6e6", "#bdbdbd", "#8a8a8a"};
constexpr Theme kDark = {"#1b1b1b", "#e6e6e6", "#b0b0b0", "#353535", "#5a5a5a", "#8f8f8f"};

std::string rules(const Theme& theme, bool dark) {
  auto text = fmt::format(
      ".page,.gap{{fill:{0}}}.gap,.dot{{stroke:{0}}}.ink{{fill:{1}}}.soft{{fill:{2}}}.grid{{stroke:{3}}}"
      ".zero{{stroke:{4}}}.axis{{stroke:{5}}}\n",
      theme.page, theme.ink, theme.soft, theme.grid, theme.zero, theme.axis);
  for (std::size_t i = 1; i < kShades.size(); ++i)
    text += fmt::format(".s{0}{{stroke:{1}}}.f{0}{{fill:{1}}}.t{0}{{fill:{2}}}\n", i,
                        dark ? kShades[i].dark_line : kShades[i].line,
                        dark ? kShades[i].dark_text : kShades[i].text);
  return text;
}

}  // namespace

std::string escape(const std::string& text) {
  static const std::map<char, const char*> kEntities = {
      {'&', "&amp;"}, {'<', "&lt;"}, {'>', "&gt;"}, {'"', "&quot;"}};
  std::string safe;
  for (const char c : text)
    if (const auto entity = kEntities.find(c); entity != kEntities.end())
      safe += entity->second;
    else if (static_cast<unsigned char>(c) >= 0x20)
      safe += c;
  return safe;
}

std::string ramp_color(double share) {
  using Color = std::array<double, 3>;
  static constexpr std::array<Color, 6> kCividis = {
      {{0, 32, 76}, {49, 68, 107}, {102, 105, 112}, {149, 143, 120}, {202, 185, 105}, {255, 234, 70}}};
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(kCividis.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kCividis.size() - 2);
  const double part = place - static_cast<double>(low);
  const auto mix = [&](std::size_t channel) {
    const double from = kCividis[low][channel], to = kCividis[low + 1][channel];
    return static_cast<int>(std::lround(from + part * (to - from)));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2));
}

std::string svg_document(double width, double height, const std::string& title, const std::string& elements) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.0f}\" height=\"{1:.0f}\" viewBox=\"0 0 {0:.0f} "
      "{1:.0f}\" role=\"img\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\" "
      "font-size=\"{2}\">\n"
      "<title>{3}</title>\n<style>{4}@media (prefers-color-scheme: dark){{\n{5}}}</style>\n"
      "<rect width=\"100%\" height=\"100%\" class=\"page\"/>\n{6}</svg>\n",
      width, height, kFont, escape(title), rules(kLight, false), rules(kDark, true), elements);
}

}  // namespace tactus::plot
