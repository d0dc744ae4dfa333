#include "engine/plot/log_plot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/well_formed.h"

using namespace tactus;
using tactus::test::well_formed;

namespace {

LogPlot borders() {
  LogPlot plot;
  plot.title = "Stiffest <stable> wall & its border";
  plot.x = {.label = "delay", .unit = "s", .log = true};
  plot.y = {.label = "stiffness", .unit = "N/m", .log = true};
  plot.series = {{.label = "bare", .x = {1e-4, 1e-3, 1e-2}, .y = {1e3, 1e2, 1e1}},
                 {.label = "held", .x = {1e-4, 1e-3, 1e-2}, .y = {1e4, 1e3, 1e2}, .dashed = true}};
  return plot;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The first two points of the first curve, in pixels.
std::vector<double> first_pixels(const std::string& svg, std::size_t pairs) {
  const auto path = svg.find("<path fill=\"none\"");
  auto at = svg.find(" d=\"M", path) + 5;
  std::vector<double> numbers;
  while (numbers.size() < 2 * pairs) {
    char* end = nullptr;
    numbers.push_back(std::strtod(svg.c_str() + at, &end));
    at = static_cast<std::size_t>(end - svg.c_str()) + 1;
  }
  return numbers;
}

/// Where the text of a label begins.
double left_of(const std::string& svg, const std::string& label) {
  const auto tag = svg.rfind("<text x=\"", svg.find(">" + label + "<"));
  return std::strtod(svg.c_str() + tag + 9, nullptr);
}
double base_of(const std::string& svg, const std::string& label) {
  const auto tag = svg.rfind(" y=\"", svg.find(">" + label + "<"));
  return std::strtod(svg.c_str() + tag + 4, nullptr);
}

}  // namespace

TEST_CASE("log_plot: each decade is as wide as the next, and a power law is a straight line", "[analysis]") {
  const auto pixels = first_pixels(log_plots_svg({borders()}), 3);
  CHECK(pixels[2] - pixels[0] == Approx(pixels[4] - pixels[2]).epsilon(0).margin(0.11));
  CHECK(pixels[3] - pixels[1] == Approx(pixels[5] - pixels[3]).epsilon(0).margin(0.11));
  CHECK(pixels[2] > pixels[0] + 100);
  CHECK(pixels[3] > pixels[1] + 50);  // downwards: pixels count from the top
}

TEST_CASE("log_plot: an axis may be straight while the other one is not", "[analysis]") {
  auto plot = borders();
  plot.x.log = false;
  const auto pixels = first_pixels(log_plots_svg({plot}), 3);
  // From 0.1 to 1 ms and from 1 to 10 ms: as 0.9 to 9. Pixels are written with one decimal.
  CHECK((pixels[4] - pixels[2]) / (pixels[2] - pixels[0]) == Approx(10).epsilon(0).margin(0.05));
}

TEST_CASE("log_plot: every named curve and region is in the legend once, and texts are safe", "[analysis]") {
  auto plot = borders();
  plot.regions = {{.label = "unstable", .x = {1e-4, 1e-2}, .low = {1e3, 1e1}},
                  {.x = {1e-4, 1e-2}, .high = {1e3, 1e1}}};
  const auto svg = log_plots_svg({plot, plot});
  CHECK(well_formed(svg));
  for (const auto* label : {">bare<", ">held<", ">unstable<"}) CHECK(count(svg, label) == 2);
  CHECK(count(svg, "Stiffest &lt;stable&gt; wall &amp; its border") == 3);  // and the title of the page
  CHECK(count(svg, "opacity=\"0.13\"") == 4);
  CHECK(count(svg, "id=\"plot0\"") == 1);
  CHECK(count(svg, "id=\"plot1\"") == 1);
}

TEST_CASE("log_plot: what an axis cannot show leaves a gap, and an empty plot is still a document",
          "[analysis]") {
  auto plot = borders();
  plot.series[0].y[1] = std::numeric_limits<double>::quiet_NaN();
  plot.series[1].y[1] = -1;
  plot.regions = {{.x = {1e-4, 1e-2}, .low = {0, std::nan("")}}};
  plot.pins = {{0, 1, "nowhere"}};
  const auto svg = log_plots_svg({plot});
  CHECK(well_formed(svg));
  CHECK(count(svg, "nan") == 0);
  CHECK(count(svg, "inf") == 0);
  CHECK(count(svg, "nowhere") == 0);
  CHECK(well_formed(log_plots_svg({LogPlot{}})));
}

TEST_CASE("log_plot: pins at one place get labels apart, and none lies outside the plot", "[analysis]") {
  auto plot = borders();
  plot.pins = {{1e-3, 1e2, "first"}, {1e-3, 1e2, "second"}, {1e-2, 1e4, "corner"}};
  const auto svg = log_plots_svg({plot});
  CHECK(well_formed(svg));
  // Two labels of 12 px height beside one pin: they differ by more in one direction or the other.
  const double apart = std::max(std::abs(left_of(svg, "first") - left_of(svg, "second")),
                                std::abs(base_of(svg, "first") - base_of(svg, "second")));
  CHECK(apart > 12);
  const double right = first_pixels(svg, 3)[4];
  CHECK(left_of(svg, "corner") < right);
}
