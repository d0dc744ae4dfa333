#include "remote/serial/serial_line.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;

namespace {

std::string text_of(const std::optional<SerialLine>& line) {
  if (!line) return "refused";
  std::string text = line->micros ? "@" + std::to_string(*line->micros) + " " : "";
  for (const auto& [control, value] : line->values) text += control + "=" + std::to_string(value) + " ";
  return text;
}

std::vector<std::string> lines_of(SerialLines& lines, std::string_view bytes) {
  std::vector<std::string> found;
  lines.add(bytes, [&](std::string_view line) { found.emplace_back(line); });
  return found;
}

}  // namespace

TEST_CASE("serial line: names and values, a time and a checksum", "[remote][serial]") {
  CHECK(text_of(parse_serial_line("ribbon 0.5")) == "ribbon=0.500000 ");
  CHECK(text_of(parse_serial_line(" ribbon\t-2e-1, force 12 ")) == "ribbon=-0.200000 force=12.000000 ");
  CHECK(text_of(parse_serial_line("@4294967295 a 1")) == "@4294967295 a=1.000000 ");
  // 'a' ^ ' ' ^ '1' = 0x61 ^ 0x20 ^ 0x31 = 0x70
  CHECK(text_of(parse_serial_line("a 1*70")) == "a=1.000000 ");
  for (const auto* wrong :
       {"", "ribbon", "ribbon 0.5 force", "0.5 ribbon", "a nan", "a inf", "a 1e999", "a 0x10", "@ a 1",
        "@4294967296 a 1", "@-1 a 1", "@1", "a 1*71", "a 1*", "a 1 *7g", "a! 1"}) {
    CAPTURE(wrong);
    CHECK(text_of(parse_serial_line(wrong)) == "refused");
  }
  std::string many;
  for (int i = 0; i < 17; ++i) many += "a 1 ";
  CHECK_FALSE(parse_serial_line(many));
}

TEST_CASE("serial line: a changed byte is found by the checksum", "[remote][serial]") {
  const std::string line = "@1234567 ribbon 0.512 force 0.031 ";
  unsigned sum = 0;
  for (const unsigned char c : line) sum ^= c;
  char end[8];
  std::snprintf(end, sizeof end, "*%X", sum);
  const auto whole = line + end;
  REQUIRE(parse_serial_line(whole));
  for (std::size_t at = 0; at < line.size(); ++at)
    for (int bit = 0; bit < 8; ++bit) {
      auto changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
      if (changed[at] == '*') continue;  // the rest is then no number
      CHECK_FALSE(parse_serial_line(changed));
    }
}

TEST_CASE("serial lines: merged, split and endless ones", "[remote][serial]") {
  SerialLines lines;
  CHECK(lines_of(lines, "a 1\r\nb 2\nc").size() == 2);
  CHECK(lines_of(lines, " 3\n") == std::vector<std::string>{"c 3"});
  CHECK(lines_of(lines, std::string(100'000, 'x')).empty());
  CHECK(lines_of(lines, "x\nd 4\n") == std::vector<std::string>{"d 4"});
  CHECK(lines.refused() == 1);
}

TEST_CASE("serial lines: random bytes", "[remote][serial]") {
  std::mt19937 random{5};
  SerialLines lines;
  const std::string good = "@1234 ribbon 0.5 *00\n";
  int seen = 0;
  for (int run = 0; run < 20'000; ++run) {
    auto bytes = good;
    for (int change = 0; change < 3; ++change) bytes[random() % bytes.size()] = static_cast<char>(random());
    lines.add(bytes, [&](std::string_view line) {
      ++seen;
      if (const auto parsed = parse_serial_line(line))
        for (const auto& [control, value] : parsed->values) CHECK(std::isfinite(value));
    });
  }
  CHECK(seen > 10'000);
}

TEST_CASE("serial line: a clock of 32 bits counts on", "[remote][serial]") {
  WideMicros clock;
  std::int64_t before = clock.widen(4'294'000'000U);
  for (const std::uint32_t next : {4'294'900'000U, 500'000U, 2'000'000'000U, 4'000'000'000U, 100U}) {
    const auto now = clock.widen(next);
    CHECK(now > before);
    CHECK(static_cast<std::uint32_t>(now) == next);
    before = now;
  }
}

TEST_CASE("serial clock: lines that come in lumps keep the distances of their sensor", "[remote][serial]") {
  // Made every 4 ms, delivered five at a time, each lump 1 to 3 ms late. The sensor is 200 ppm fast.
  SerialClock clock{0.05};
  std::mt19937 random{7};
  std::vector<double> errors, distances;
  double before = 0.0, late = 0.0;
  for (int line = 0; line < 5000; ++line) {
    const double made = 100.0 + 0.004 * line;
    const double lump = 100.0 + 0.020 * (line / 5 + 1) - 0.004;  // made when its last line is
    if (line % 5 == 0) late = 0.001 + 0.002 * static_cast<double>(random() % 1000) / 1000.0;
    const double arrival = lump + late;
    const auto micros = static_cast<std::uint32_t>(
        static_cast<std::int64_t>(4'294'000'000.0 + 1e6 * 1.0002 * (made - 100.0)));
    const double time = clock.time_of(micros, arrival);
    if (line >= 2500) {
      errors.push_back(time - made);
      distances.push_back(time - before);
    }
    before = time;
  }
  // The first line of a lump was made 16 ms before the last, which comes 2 ms late on average; the lines
  // behind it come no time later, and count for nothing.
  const auto [least, most] = std::minmax_element(errors.begin(), errors.end());
  CHECK(*least > 0.018 - 0.0005);
  CHECK(*most < 0.018 + 0.0005);
  const auto [nearest, farthest] = std::minmax_element(distances.begin(), distances.end());
  CHECK(*nearest > 0.0039);
  CHECK(*farthest < 0.0041);
  CHECK(clock.time_of(std::nullopt, 5.0) == 5.0);
}
