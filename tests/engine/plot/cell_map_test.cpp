#include "engine/plot/cell_map.h"

#include <catch2/catch.hpp>

#include "tests/support/well_formed.h"

using namespace tactus;

namespace {

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
  return found;
}

}  // namespace

TEST_CASE("cell map: the ramp goes from dark to light", "[analysis]") {
  CHECK(ramp_color(-1) == "#00204c");
  CHECK(ramp_color(0) == "#00204c");
  CHECK(ramp_color(1) == "#ffea46");
  CHECK(ramp_color(0.2) == "#31446b");
}

TEST_CASE("cell map: one box a cell, named rows and columns, safe text", "[analysis]") {
  CellPage page{"Kind < of \"roll\"", "how", {}};
  page.maps.push_back(
      {"kind", "delay [ms]", "strength", {"0", "1", "2"}, {"0.5", "1"}, {}, {{"#111111", "dead"}}});
  for (int i = 0; i < 6; ++i) page.maps.back().cells.push_back({"#123456", "R"});
  const auto svg = to_svg(page);
  CHECK(test::well_formed(svg));
  CHECK(count(svg, "fill=\"#123456\"") == 6);
  CHECK(count(svg, ">R</text>") == 6);
  CHECK(svg.find("Kind &lt; of &quot;roll&quot;") != std::string::npos);
  for (const auto* text : {">0</text>", ">2</text>", ">0.5</text>", ">dead</text>", ">delay [ms]</text>"})
    CHECK(svg.find(text) != std::string::npos);
}
