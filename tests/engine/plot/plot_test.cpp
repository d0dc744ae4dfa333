#include "engine/plot/plot.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/plot/layout.h"
#include "tests/support/well_formed.h"

using namespace tactus;
using tactus::test::well_formed;

namespace {

std::vector<std::string> texts(const std::vector<plot::Tick>& ticks) {
  std::vector<std::string> all;
  for (const auto& tick : ticks) all.push_back(tick.text);
  return all;
}

std::vector<std::string> linear_ticks(double low, double high, const std::string& unit, int most) {
  const auto prefixed = plot::prefixed_unit(unit, std::max(std::abs(low), std::abs(high)));
  return texts(plot::ticks_of({low, high, 0, 100}, {.unit = unit}, prefixed, most));
}

std::vector<std::string> log_ticks(double low, double high, const std::string& unit) {
  return texts(plot::ticks_of({low, high, 0, 100, true}, {.unit = unit}, plot::prefixed_unit(unit, high), 5));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

Plot small_plot() {
  Plot plot;
  plot.title = "Stick & cone <drum>";
  plot.x = {"time", "s"};
  Subplot panel;
  panel.y = {"height", "m"};
  panel.series = {plot_trace("stick", 0.0, 0.01, {0.0, 0.002, 0.001})};
  plot.subplots = {panel};
  return plot;
}

}  // namespace

TEST_CASE("plot: ticks lie at 1, 2 or 5 times a power of ten and carry the prefix", "[plot]") {
  CHECK(linear_ticks(0.0, 1.0, "", 5) == std::vector<std::string>{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"});
  CHECK(linear_ticks(-0.003, 0.004, "m", 4) == std::vector<std::string>{"−2", "0", "2", "4"});
  CHECK(linear_ticks(0.0, 2500.0, "Hz", 5) ==
        std::vector<std::string>{"0.0", "0.5", "1.0", "1.5", "2.0", "2.5"});
  CHECK(linear_ticks(0.1, 0.35, "", 5) ==
        std::vector<std::string>{"0.10", "0.15", "0.20", "0.25", "0.30", "0.35"});
}

TEST_CASE("plot: one tick gives no scale, so that a finer step is taken", "[plot]") {
  // At most 2 ticks of 0.96: a step of 0.5, of which only 0 lies within.
  CHECK(linear_ticks(-0.48, 0.48, "V", 2) == std::vector<std::string>{"−400", "−200", "0", "200", "400"});
}

TEST_CASE("plot: log ticks are powers of ten, or 1-2-5 where few of those are in sight", "[plot]") {
  CHECK(log_ticks(10.0, 1e5, "Hz") ==
        std::vector<std::string>{"10 Hz", "100 Hz", "1 kHz", "10 kHz", "100 kHz"});
  CHECK(log_ticks(1.0, 12.0, "") == std::vector<std::string>{"1", "2", "5", "10"});
  CHECK(log_ticks(1e-9, 1e-4, "") ==
        std::vector<std::string>{"10⁻⁹", "10⁻⁸", "10⁻⁷", "10⁻⁶", "10⁻⁵", "10⁻⁴"});
}

TEST_CASE("plot: a log scale of less than a decade has even ticks where 1-2-5 would leave it bare",
          "[plot]") {
  CHECK(log_ticks(105, 190, "Hz") == std::vector<std::string>{"120 Hz", "140 Hz", "160 Hz", "180 Hz"});
  CHECK(log_ticks(105, 450, "Hz") == std::vector<std::string>{"200 Hz", "300 Hz", "400 Hz"});
}

TEST_CASE("plot: a series that ends near the edge is named there, else in the legend", "[plot]") {
  const auto has_leader = [](double ends) {
    Plot plot;
    plot.x = {.low = 0, .high = 1};
    plot.subplots = {{.series = {{.label = "one", .x = {0, ends}, .y = {0, 1}}}}};
    const auto svg = to_svg({plot});
    CHECK(contains(svg, ">one<"));
    return contains(svg, "opacity=\"0.6\"");
  };
  CHECK(has_leader(1.0));
  CHECK_FALSE(has_leader(0.1));
}

TEST_CASE("plot: the prefix is that of the largest value, and only where the unit takes one", "[plot]") {
  const auto text = [](const std::string& unit, double largest) {
    return plot::prefixed_unit(unit, largest).text;
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
  CHECK(plot::prefixed_unit("Hz", 48e3).factor == 1e3);
}

TEST_CASE("plot: a range gets a margin, an asked-for end stays", "[plot]") {
  const auto whole = plot::range_of({}, 0.0, 100.0, true);
  CHECK(whole.low == Approx(-6.0));
  CHECK(whole.high == Approx(106.0));
  PlotAxis asked;
  asked.low = 10.0;
  CHECK(plot::range_of(asked, 0.0, 100.0, false).low == 10.0);
  CHECK(plot::range_of(asked, 0.0, 100.0, false).high == 100.0);
  // All data below the asked-for end, data of one value, no data: still a range.
  for (const auto& range : {plot::range_of(asked, 0.0, 5.0, true), plot::range_of({}, 3.0, 3.0, true),
                            plot::range_of({}, 1.0, -1.0, true)})
    CHECK(range.low < range.high);
}

TEST_CASE("plot: a spike of one sample in a million stays in the picture", "[plot]") {
  std::vector<double> values(1'000'000, 0.0);
  values[777'777] = 1.0;
  values[777'778] = -1.0;
  const auto series = plot_trace("", 0.0, 1e-6, std::move(values));
  const auto lines = plot::polylines(series, {0.0, 1.0, 0.0, 800.0}, {-1.0, 1.0, 100.0, 0.0});
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

TEST_CASE("plot: a NaN leaves a gap, and a log scale skips what is not positive", "[plot]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto series = plot_trace("", 0.0, 1.0, {1.0, 2.0, nan, 3.0, -1.0, 4.0});
  CHECK(plot::polylines(series, {0, 5, 0, 50}, {0, 5, 0, 50}).size() == 2);
  CHECK(plot::polylines(series, {0, 5, 0, 50}, {0.1, 5, 0, 50, true}).size() == 3);
}

TEST_CASE("plot: labels at the right end keep their distance and stay inside", "[plot]") {
  const auto placed = plot::spread({50.0, 50.0, 51.0, 99.0, 3.0}, 14.0, 0.0, 100.0);
  auto sorted = placed;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 1; i < sorted.size(); ++i) CHECK(sorted[i] - sorted[i - 1] >= 14.0 - 1e-9);
  CHECK(sorted.front() >= 0.0);
  CHECK(sorted.back() <= 100.0);
  CHECK(placed[4] == 3.0);
  CHECK(placed[0] < placed[1]);
}

TEST_CASE("plot: labels over a panel never overlap, those without room are left out", "[plot]") {
  std::vector<plot::RowLabel> labels;
  for (int i = 0; i < 40; ++i) labels.push_back({static_cast<double>((i * 37) % 400), 50.0});
  plot::place_in_rows(labels, 3, 0.0, 400.0);
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

TEST_CASE("plot: long titles break into lines that fit", "[plot]") {
  const std::string text = "The stick bounces by itself as long as the woofer answers each of its landings";
  const auto lines = plot::wrap(text, 12.0, 200.0);
  CHECK(lines.size() > 1);
  std::string joined;
  for (const auto& line : lines) {
    CHECK(plot::text_width(line, 12.0) <= 200.0);
    joined += (joined.empty() ? "" : " ") + line;
  }
  CHECK(joined == text);
}

TEST_CASE("plot: the label at the end of a curve begins right of the axes", "[plot]") {
  Plot plot;
  plot.x = {.low = 0, .high = 1};
  plot.subplots = {{.series = {{.label = "one", .x = {0, 1}, .y = {0, 1}}}}};
  const auto svg = to_svg({plot});
  const auto number_after = [&](const std::string& key, std::size_t from) {
    return std::stod(svg.substr(svg.find(key, from) + key.size()));
  };
  const double label = number_after("x=\"", svg.rfind("<text", svg.find(">one<")));
  const double axis = number_after("x2=\"", svg.rfind("<line", svg.find("class=\"axis\"")));
  CHECK(label > axis);
  CHECK(label < axis + 20);
}

TEST_CASE("plot: a plot is well-formed XML and says what it shows", "[plot]") {
  auto plot = small_plot();
  plot.events = {{0.01, "hit"}};
  plot.subplots[0].bands = {{0.0, 0.005, "fall"}};
  plot.subplots[0].levels = {{0.0015, "limit"}};
  for (const auto mark : {PlotMark::Line, PlotMark::Points, PlotMark::LineAndPoints}) {
    plot.subplots[0].series[0].mark = mark;
    const auto text = to_svg({plot});
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

TEST_CASE("plot: empty plots and panels are drawn, too", "[plot]") {
  CHECK(well_formed(to_svg({Plot{}})));
  Plot plot;
  plot.subplots.resize(2);
  plot.subplots[1].series.resize(1);
  plot.x.log = true;
  const auto text = to_svg({plot});
  CHECK(well_formed(text));
  CHECK_FALSE(contains(text, "nan"));
}

TEST_CASE("plot: the same plot gives the same bytes, and a lost folder an error", "[plot]") {
  CHECK(to_svg({small_plot()}) == to_svg({small_plot()}));
  const auto status = write_svg("/no/such/folder/a.svg", {small_plot()});
  REQUIRE_FALSE(status);
  CHECK(status.error().code == Errc::BadFile);
  CHECK(status.error().where == "/no/such/folder/a.svg");
}

TEST_CASE("plot: the plots of a page stand below one another, each with clips of its own", "[plot]") {
  const auto one = to_svg({small_plot()});
  const auto page = to_svg({small_plot(), small_plot()});
  CHECK(well_formed(page));
  const auto height = [](const std::string& text) {
    return std::stoi(text.substr(text.find("height=\"") + 8));
  };
  CHECK(height(page) == Approx(2 * height(one)).margin(1));
  CHECK(contains(page, "translate(0 " + std::to_string(height(one)) + ")"));
  for (const auto* clip : {"clipPath id=\"p0s0\"", "clipPath id=\"p1s0\"", "url(#p1s0)"})
    CHECK(contains(page, clip));
  const auto wide = to_svg({small_plot(), small_plot()}, 2);
  CHECK(height(wide) == height(one));
  CHECK(contains(wide, "translate(900 0)"));
}

// ---- logarithmic axes, regions, pins

namespace {

Plot borders() {
  Plot plot;
  plot.title = "Stiffest <stable> wall & its border";
  plot.x = {.label = "delay", .unit = "s", .log = true};
  plot.subplots = {
      {.y = {.label = "stiffness", .unit = "N/m", .log = true},
       .series = {{.label = "bare", .x = {1e-4, 1e-3, 1e-2}, .y = {1e3, 1e2, 1e1}},
                  {.label = "held", .x = {1e-4, 1e-3, 1e-2}, .y = {1e4, 1e3, 1e2}, .dashed = true}},
       .height = 3}};
  return plot;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The first points of the first curve, in pixels.
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

/// An attribute of the text element of a label: " x=\"" or " y=\"".
double place_of(const std::string& svg, const std::string& label, const std::string& attribute) {
  const auto tag = svg.rfind(attribute, svg.find(">" + label + "<"));
  return std::strtod(svg.c_str() + tag + attribute.size(), nullptr);
}

}  // namespace

TEST_CASE("plot: on logarithmic axes a power law is a straight line", "[plot]") {
  const auto pixels = first_pixels(to_svg({borders()}), 3);
  CHECK(pixels[2] - pixels[0] == Approx(pixels[4] - pixels[2]).epsilon(0).margin(0.11));
  CHECK(pixels[3] - pixels[1] == Approx(pixels[5] - pixels[3]).epsilon(0).margin(0.11));
  CHECK(pixels[2] > pixels[0] + 100);
  CHECK(pixels[3] > pixels[1] + 50);  // pixels count from the top
}

TEST_CASE("plot: one axis may be linear and the other logarithmic", "[plot]") {
  auto plot = borders();
  plot.x.log = false;
  const auto pixels = first_pixels(to_svg({plot}), 3);
  // From 0.1 to 1 ms and from 1 to 10 ms: as 0.9 to 9. Pixels are written with one decimal.
  CHECK((pixels[4] - pixels[2]) / (pixels[2] - pixels[0]) == Approx(10).epsilon(0).margin(0.05));
}

TEST_CASE("plot: every named curve and region is labelled once, and texts are escaped", "[plot]") {
  auto plot = borders();
  plot.subplots[0].regions = {{.label = "unstable", .x = {1e-4, 1e-2}, .low = {1e3, 1e1}},
                              {.x = {1e-4, 1e-2}, .high = {1e3, 1e1}}};
  const auto svg = to_svg({plot, plot});
  CHECK(well_formed(svg));
  for (const auto* label : {">bare<", ">held<", ">unstable<"}) CHECK(count(svg, label) == 2);
  CHECK(count(svg, "Stiffest &lt;stable&gt; wall &amp; its border") == 3);  // and the title of the page
  CHECK(count(svg, "opacity=\"0.13\"") == 4);
}

TEST_CASE("plot: values that an axis cannot show leave a gap", "[plot]") {
  auto plot = borders();
  auto& subplot = plot.subplots[0];
  subplot.series[0].y[1] = std::numeric_limits<double>::quiet_NaN();
  subplot.series[1].y[1] = -1;
  subplot.regions = {{.x = {1e-4, 1e-2}, .low = {0, std::nan("")}}};
  subplot.pins = {{0, 1, "nowhere"}};
  const auto svg = to_svg({plot});
  CHECK(well_formed(svg));
  for (const auto* bad : {"nan", "inf", "nowhere"}) CHECK(count(svg, bad) == 0);
}

TEST_CASE("plot: labels of pins at one place do not overlap and lie within the plot", "[plot]") {
  auto plot = borders();
  plot.subplots[0].pins = {{1e-3, 1e2, "first"}, {1e-3, 1e2, "second"}, {1e-2, 1e4, "corner"}};
  const auto svg = to_svg({plot});
  CHECK(well_formed(svg));
  const double apart = std::max(std::abs(place_of(svg, "first", " x=\"") - place_of(svg, "second", " x=\"")),
                                std::abs(place_of(svg, "first", " y=\"") - place_of(svg, "second", " y=\"")));
  CHECK(apart > 12);  // the height of a label
  CHECK(place_of(svg, "corner", " x=\"") < first_pixels(svg, 3)[4]);
}

// ---- maps

TEST_CASE("plot: a map has one box per cell, named rows and columns, escaped text", "[plot]") {
  Plot plot{.title = "Kind < of \"roll\"",
            .x = {.label = "delay [ms]"},
            .subplots = {{.y = {.label = "strength"}}}};
  PlotMap map{{"0", "1", "2"}, {"0.5", "1"}, {}, {{{.color = PlotColor::Orange}, "dead"}}};
  for (int i = 0; i < 6; ++i) map.cells.push_back({.color = PlotColor::Green, .letter = "R"});
  plot.subplots[0].map = map;
  const auto svg = to_svg({plot});
  CHECK(well_formed(svg));
  CHECK(count(svg, "class=\"f3 gap\"") == 6);
  CHECK(count(svg, ">R</text>") == 6);
  for (const auto* text : {"Kind &lt; of &quot;roll&quot;", ">0</text>", ">2</text>", ">0.5</text>",
                           ">dead</text>", ">delay [ms]</text>", ">strength</text>"})
    CHECK(contains(svg, text));
}

TEST_CASE("plot: a map of values goes from dark to light, and its legend names the values", "[plot]") {
  const auto map = value_map({"a", "b"}, {"c", "d"}, {0, 10, 5, std::nan("")});
  CHECK(map.cells[0].share == 0);
  CHECK(map.cells[1].share == 1);
  CHECK(map.cells[2].share == 0.5);
  CHECK(map.keys.front().label == "10");
  CHECK(map.keys.back().label == "0");
  Plot plot;
  plot.subplots = {{.map = map}};
  const auto svg = to_svg({plot});
  CHECK(well_formed(svg));
  // cividis
  CHECK(contains(svg, "fill:#00204c"));
  CHECK(contains(svg, "fill:#ffea46"));
  CHECK_FALSE(contains(svg, "nan"));
}

// ---- notes

TEST_CASE("plot: the nearest note of the scale", "[plot]") {
  CHECK(note_name(440) == "A4");
  CHECK(note_name(261.63) == "C4");
  CHECK(note_name(277.2) == "C#4");
  CHECK(note_name(27.5) == "A0");
  CHECK(note_name(15.4) == "B-1");
  CHECK(pitch_of_note(nearest_note(262)) == Approx(261.6256));
}

TEST_CASE("plot: as many notes of the scale are ticked as there is room for", "[plot]") {
  const auto ticks = [](double low, double high, int most) {
    std::string all;
    for (const auto& tick : plot::ticks_of({low, high, 100, 0, true}, {.log = true, .notes = true}, {}, most))
      all += (all.empty() ? "" : ", ") + tick.text;
    return all;
  };
  CHECK(ticks(219, 247, 8) == "A3 220 Hz, A#3 233 Hz, B3 247 Hz");
  CHECK(ticks(110, 220, 8) ==
        "A2 110 Hz, B2 123 Hz, C3 131 Hz, D3 147 Hz, E3 165 Hz, F3 175 Hz, G3 196 Hz, A3 220 Hz");
  CHECK(ticks(103, 470, 8) == "A2 110 Hz, C3 131 Hz, E3 165 Hz, A3 220 Hz, C4 262 Hz, E4 330 Hz, A4 440 Hz");
  CHECK(ticks(103, 470, 4) == "A2 110 Hz, A3 220 Hz, A4 440 Hz");
  CHECK(ticks(50, 2000, 3) == "A2 110 Hz, A4 440 Hz, A6 1760 Hz");
}
