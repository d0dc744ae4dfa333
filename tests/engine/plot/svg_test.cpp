#include "engine/plot/svg.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/plot/svg_layout.h"
#include "engine/plot/svg_scale.h"
#include "tests/support/well_formed.h"

using namespace tactus;
using tactus::test::well_formed;

namespace {

std::vector<std::string> texts(const std::vector<svg::Tick>& ticks) {
  std::vector<std::string> all;
  for (const auto& tick : ticks) all.push_back(tick.text);
  return all;
}

std::vector<std::string> linear_ticks(double low, double high, const std::string& unit, int most) {
  const auto prefixed = svg::prefixed_unit(unit, std::max(std::abs(low), std::abs(high)));
  return texts(svg::ticks_of({low, high, 0, 100}, unit, prefixed, most));
}

std::vector<std::string> log_ticks(double low, double high, const std::string& unit) {
  return texts(svg::ticks_of({low, high, 0, 100, true}, unit, svg::prefixed_unit(unit, high), 5));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Figure small_figure() {
  Figure figure;
  figure.title = "Stick & cone <drum>";
  figure.x = {"time", "s"};
  PlotPanel panel;
  panel.y = {"height", "m"};
  panel.series = {plot_trace("stick", 0.0, 0.01, {0.0, 0.002, 0.001})};
  figure.panels = {panel};
  return figure;
}

}  // namespace

TEST_CASE("svg: ticks lie at 1, 2 or 5 times a power of ten and carry the prefix", "[analysis]") {
  CHECK(linear_ticks(0.0, 1.0, "", 5) == std::vector<std::string>{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"});
  CHECK(linear_ticks(-0.003, 0.004, "m", 4) == std::vector<std::string>{"−2", "0", "2", "4"});
  CHECK(linear_ticks(0.0, 2500.0, "Hz", 5) ==
        std::vector<std::string>{"0.0", "0.5", "1.0", "1.5", "2.0", "2.5"});
  CHECK(linear_ticks(0.1, 0.35, "", 5) ==
        std::vector<std::string>{"0.10", "0.15", "0.20", "0.25", "0.30", "0.35"});
}

TEST_CASE("svg: log ticks are powers of ten, or 1-2-5 where few of those are in sight", "[analysis]") {
  CHECK(log_ticks(10.0, 1e5, "Hz") ==
        std::vector<std::string>{"10 Hz", "100 Hz", "1 kHz", "10 kHz", "100 kHz"});
  CHECK(log_ticks(1.0, 12.0, "") == std::vector<std::string>{"1", "2", "5", "10"});
  CHECK(log_ticks(1e-9, 1e-4, "") ==
        std::vector<std::string>{"10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴"});
}

TEST_CASE("svg: a log scale of less than a decade has even ticks where 1-2-5 would leave it bare",
          "[analysis]") {
  CHECK(log_ticks(105, 190, "Hz") == std::vector<std::string>{"120 Hz", "140 Hz", "160 Hz", "180 Hz"});
  CHECK(log_ticks(105, 450, "Hz") == std::vector<std::string>{"200 Hz", "300 Hz", "400 Hz"});
}

TEST_CASE("svg: what ends far from its label has no leader", "[analysis]") {
  const auto leaders = [](double ends) {
    Figure figure;
    figure.x = {.low = 0, .high = 1};
    figure.panels = {{.series = {{.label = "one", .x = {0, ends}, .y = {0, 1}}}}};
    const auto svg = to_svg(figure);
    CHECK(contains(svg, ">one<"));
    return contains(svg, "opacity=\"0.6\"");
  };
  CHECK(leaders(1.0));
  CHECK_FALSE(leaders(0.1));
}

TEST_CASE("svg: the prefix is that of the largest value, and only where the unit takes one", "[analysis]") {
  const auto text = [](const std::string& unit, double largest) {
    return svg::prefixed_unit(unit, largest).text;
  };
  CHECK(text("m", 0.02) == "mm");
  CHECK(text("m", 1e-3) == "mm");
  CHECK(text("m", 9.99e-4) == "µm");
  CHECK(text("m/s", 0.3) == "mm/s");
  CHECK(text("N/m", 2e6) == "MN/m");
  CHECK(text("m/s^2", 2e3) == "km/s²");
  CHECK(text("m^2", 1e-4) == "m²");
  CHECK(text("dB", 1e-4) == "dB");
  CHECK(text("full scale", 1e-4) == "full scale");
  CHECK(svg::prefixed_unit("Hz", 48e3).factor == 1e3);
}

TEST_CASE("svg: a range gets a margin, an asked-for end stays", "[analysis]") {
  const auto whole = svg::range_of({}, 0.0, 100.0, true);
  CHECK(whole.low == Approx(-6.0));
  CHECK(whole.high == Approx(106.0));
  PlotAxis asked;
  asked.low = 10.0;
  CHECK(svg::range_of(asked, 0.0, 100.0, false).low == 10.0);
  CHECK(svg::range_of(asked, 0.0, 100.0, false).high == 100.0);
  // All data below the asked-for end, data of one value, no data: still a range.
  for (const auto& range : {svg::range_of(asked, 0.0, 5.0, true), svg::range_of({}, 3.0, 3.0, true),
                            svg::range_of({}, 1.0, -1.0, true)})
    CHECK(range.low < range.high);
}

TEST_CASE("svg: a spike of one sample in a million stays in the picture", "[analysis]") {
  std::vector<double> values(1'000'000, 0.0);
  values[777'777] = 1.0;
  values[777'778] = -1.0;
  const auto series = plot_trace("", 0.0, 1e-6, std::move(values));
  const auto lines = svg::polylines(series, {0.0, 1.0, 0.0, 800.0}, {-1.0, 1.0, 100.0, 0.0});
  REQUIRE(lines.size() == 1);
  const auto& line = lines.front();
  CHECK(line.size() <= 4 * 801);
  const auto [top, bottom] =
      std::minmax_element(line.begin(), line.end(), [](const auto& a, const auto& b) { return a.y < b.y; });
  CHECK(top->y == Approx(0.0).margin(1e-9));
  CHECK(bottom->y == Approx(100.0));
  CHECK(top->x == Approx(0.777777 * 800.0).epsilon(1e-9));
  CHECK(top->x < bottom->x);
  CHECK(std::is_sorted(line.begin(), line.end(), [](const auto& a, const auto& b) { return a.x < b.x; }));
}

TEST_CASE("svg: a NaN leaves a gap, and a log scale skips what is not positive", "[analysis]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto series = plot_trace("", 0.0, 1.0, {1.0, 2.0, nan, 3.0, -1.0, 4.0});
  CHECK(svg::polylines(series, {0, 5, 0, 50}, {0, 5, 0, 50}).size() == 2);
  CHECK(svg::polylines(series, {0, 5, 0, 50}, {0.1, 5, 0, 50, true}).size() == 3);
}

TEST_CASE("svg: labels at the right end keep their distance and stay inside", "[analysis]") {
  const auto placed = svg::spread({50.0, 50.0, 51.0, 99.0, 3.0}, 14.0, 0.0, 100.0);
  auto sorted = placed;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) CHECK(sorted[i] - sorted[i - 1] >= 14.0 - 1e-9);
  CHECK(sorted.front() >= 0.0);
  CHECK(sorted.back() <= 100.0);
  CHECK(placed[4] == 3.0);
  CHECK(placed[0] < placed[1]);
}

TEST_CASE("svg: labels over a panel never overlap, those without room are left out", "[analysis]") {
  std::vector<svg::RowLabel> labels;
  for (int i = 0; i < 40; ++i) labels.push_back({static_cast<double>((i * 37) % 400), 50.0});
  svg::place_in_rows(labels, 3, 0.0, 400.0);
  int placed = 0;
  for (const auto& a : labels) {
    placed += a.row >= 0 ? 1 : 0;
    CHECK(a.x - 25.0 >= 0.0);
    CHECK(a.x + 25.0 <= 400.0);
    for (const auto& b : labels)
      if (&a != &b && a.row >= 0 && a.row == b.row) CHECK(std::abs(a.x - b.x) >= 50.0);
  }
  // 400 px hold seven labels of 50 px with 6 px between them.
  CHECK(placed <= 21);
  CHECK(placed >= 15);
}

TEST_CASE("svg: long titles break into lines that fit", "[analysis]") {
  const std::string text = "The stick bounces by itself as long as the woofer answers each of its landings";
  const auto lines = svg::wrap(text, 12.0, 200.0);
  CHECK(lines.size() > 1);
  std::string joined;
  for (const auto& line : lines) {
    CHECK(svg::text_width(line, 12.0) <= 200.0);
    joined += (joined.empty() ? "" : " ") + line;
  }
  CHECK(joined == text);
}

TEST_CASE("svg: a figure is well-formed XML and says what it shows", "[analysis]") {
  auto figure = small_figure();
  figure.events = {{0.01, "hit"}};
  figure.spans = {{0.0, 0.005, "fall"}};
  figure.panels[0].levels = {{0.0015, "limit"}};
  for (const auto mark : {PlotMark::Line, PlotMark::Points, PlotMark::LineAndPoints, PlotMark::Stems}) {
    figure.panels[0].series[0].mark = mark;
    const auto text = to_svg(figure);
    CHECK(well_formed(text));
    for (const auto* part : {"Stick &amp; cone &lt;drum&gt;", "height [mm]", "time [ms]", ">hit<", ">fall<",
                             ">limit<", ">stick<"})
      CHECK(contains(text, part));
    CHECK_FALSE(contains(text, "nan"));
    CHECK_FALSE(contains(text, "inf"));
  }
  CHECK_FALSE(well_formed("<svg><g></svg>"));
  CHECK_FALSE(well_formed("<svg>a & b</svg>"));
}

TEST_CASE("svg: empty figures and panels are drawn, too", "[analysis]") {
  CHECK(well_formed(to_svg({})));
  Figure figure;
  figure.panels.resize(2);
  figure.panels[1].series.resize(1);
  figure.x.log = true;
  const auto text = to_svg(figure);
  CHECK(well_formed(text));
  CHECK_FALSE(contains(text, "nan"));
}

TEST_CASE("svg: the same figure gives the same bytes, and a lost folder an error", "[analysis]") {
  CHECK(to_svg(small_figure()) == to_svg(small_figure()));
  const auto status = write_svg("/no/such/folder/a.svg", small_figure());
  REQUIRE_FALSE(status);
  CHECK(to_string(status.error()) ==
        "/no/such/folder/a.svg: the plot cannot be written; check that the folder exists and may be written "
        "to");
}

TEST_CASE("svg: the figures of a page stand below one another, each with clips of its own", "[analysis]") {
  const auto one = to_svg(small_figure());
  const auto page = to_svg_page({small_figure(), small_figure()});
  CHECK(well_formed(page));
  const auto height = [](const std::string& text) {
    return std::stoi(text.substr(text.find("height=\"") + 8));
  };
  CHECK(height(page) == Approx(2 * height(one)).margin(1));
  CHECK(contains(page, "translate(0 " + std::to_string(height(one)) + ")"));
  CHECK(contains(page, "clipPath id=\"panel0\""));
  CHECK(contains(page, "clipPath id=\"panel1_0\""));
  CHECK(contains(page, "url(#panel1_0)"));
}
