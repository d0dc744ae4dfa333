#include "engine/rig/preset.h"

#include <catch2/catch.hpp>
#include <random>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

FlatControl control_of(const std::string& name, const char* unit, double low, double high) {
  FlatControl control;
  control.name = name;
  control.unit = unit[0] == '\0' ? Unit{} : *parse_unit(unit);
  control.range = {low, high};
  return control;
}

const std::vector<FlatControl> kControls = {
    control_of("strength", "N", 0, 1), control_of("hold", "ms", 0.002, 0.1),
    control_of("level", "dB", 0.001, 1), control_of("share", "", -1, 1)};

std::string errors_of(const Preset& preset) {
  std::string text;
  for (const auto& error : preset.errors) text += error.where + " " + error.what + "; " + error.remedy + "\n";
  return text;
}

}  // namespace

TEST_CASE("preset: values are read in any unit of their control") {
  const auto preset = parse_preset(
      "format = 1\nabout = \"soft\"\n[controls]\nstrength = \"250 mN\"\nhold = \"20 ms\"\nlevel = \"-6 "
      "dB\"\nshare = 0.5\n",
      "soft.toml", kControls);
  REQUIRE(preset);
  CHECK(errors_of(*preset).empty());
  REQUIRE(preset->values.size() == 4);
  CHECK(preset->values[0] == PresetValue{"strength", 0.25});
  CHECK(preset->values[1].value == Approx(0.02));
  CHECK(preset->values[2].value == Approx(0.501187233627));
  CHECK(preset->values[3].value == 0.5);
}

TEST_CASE("preset: what does not fit is reported with its place, and the rest is kept") {
  const auto preset =
      parse_preset("format = 1\n[controls]\nstrenght = 0.5\nhold = \"2 s\"\nlevel = \"3 mm\"\nshare = 0.25\n",
                   "a.toml", kControls);
  REQUIRE(preset);
  CHECK(preset->values == std::vector<PresetValue>{{"share", 0.25}});
  const auto errors = errors_of(*preset);
  CHECK(errors.find("a.toml:3:1 there is no control 'strenght'; did you mean 'strength'?") !=
        std::string::npos);
  CHECK(errors.find("a.toml:4:") != std::string::npos);
  CHECK(errors.find("'hold' is 2 s, out of its range; it runs from 2 ms to 100 ms") != std::string::npos);
  CHECK(errors.find("a.toml:5:") != std::string::npos);
  CHECK(preset->errors.size() == 3);
  CHECK_FALSE(parse_preset("[controls\n", "a.toml", kControls));
  const auto odd = parse_preset("format = 2\ncontrols = 3\nother = 1\n", "a.toml", kControls);
  REQUIRE(odd);
  CHECK(odd->errors.size() == 3);
}

TEST_CASE("preset: what is written reads back bit for bit") {
  std::mt19937 random{3};
  for (int run = 0; run < 200; ++run) {
    std::vector<PresetValue> values;
    for (const auto& control : kControls) {
      const double share = run == 0 ? 0.0 : run == 1 ? 1.0 : std::uniform_real_distribution<>{}(random);
      values.push_back({control.name, control.range.low + share * (control.range.high - control.range.low)});
    }
    const auto text = to_text(values, kControls);
    INFO(text);
    const auto preset = parse_preset(text, "a.toml", kControls);
    REQUIRE(preset);
    CHECK(errors_of(*preset).empty());
    CHECK(preset->values == values);
  }
}

TEST_CASE("preset: their names are those of files") {
  const test::TemporaryFolder folder;
  CHECK(preset_names(folder.path() / "presets").empty());
  folder.write("presets/soft.toml", "");
  folder.write("presets/loud 2.toml", "");
  folder.write("presets/notes.txt", "");
  CHECK(preset_folder(folder.path() / "instrument.toml") == folder.path() / "presets");
  CHECK(preset_names(folder.path() / "presets") == std::vector<std::string>{"loud 2", "soft"});
  for (const auto* name : {"soft", "a-b_c 7", "\xc3\xa4"}) CHECK(check_preset_name(name));
  for (const auto* name : {"", "../x", "a/b", ".", " a", "a ", "a\n"}) CHECK_FALSE(check_preset_name(name));
  CHECK_FALSE(check_preset_name(std::string(65, 'a')));
}
