#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

const std::string kDrum = std::string{TACTUS_SOURCE_DIR} + "/instruments/haptic_drum --duration '0.5 s'";
const std::string kGrid = kDrum +
                          " --over strength=0.2:1:3 --over 'delay=10:20:2 ms' --measure rate:instrument.hit "
                          "--measure peak:plant.cone";

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{stream}, {}};
}

struct Output {
  int exit;
  std::string text, errors;
};

Output sweep(const test::TemporaryFolder& folder, const std::string& arguments) {
  const auto out = folder.path() / "out.txt", errors = folder.path() / "errors.txt";
  const auto command =
      std::string{TACTUS_PROGRAM} + " sweep " + arguments + " >" + out.string() + " 2>" + errors.string();
  const int exit = std::system(command.c_str()) / 256;
  return {exit, text_of(out), text_of(errors)};
}

}  // namespace

TEST_CASE("sweep command: an interrupted sweep resumes, and parts make the whole, byte for byte",
          "[apps][sweep]") {
  const test::TemporaryFolder folder;
  const auto whole = sweep(folder, kGrid + " --json");
  REQUIRE(whole.exit == 0);
  const auto json = nlohmann::json::parse(whole.text);
  REQUIRE(json["runs"].size() == 6);
  CHECK(json["runs"][5]["at"]["strength"] == 1.0);
  CHECK(json["runs"][5]["at"]["delay"] == 0.02);

  const auto cache = folder.path() / "cache", parts = folder.path() / "parts";
  REQUIRE(sweep(folder, kGrid + " --json --keep " + cache.string()).text == whole.text);
  // Killed in the middle of the third line.
  const auto file = cache / "runs.jsonl";
  const auto lines = text_of(file);
  auto third = lines.find('\n', lines.find('\n') + 1) + 20;
  std::ofstream{file, std::ios::binary} << lines.substr(0, third);
  CHECK(sweep(folder, kGrid + " --json --keep " + cache.string()).text == whole.text);

  for (const auto* part : {"1/2", "2/2"}) {
    const auto share = sweep(folder, kGrid + " --keep " + parts.string() + " --part " + part);
    CHECK(share.exit == 0);
    CHECK(share.text.empty());
  }
  CHECK(sweep(folder, kGrid + " --json --keep " + parts.string()).text == whole.text);
  CHECK((!std::filesystem::exists(parts / "runs.jsonl") ||
         std::filesystem::file_size(parts / "runs.jsonl") == 0));
}

TEST_CASE("sweep command: wrong names and ranges are usage errors", "[apps][sweep]") {
  const test::TemporaryFolder folder;
  const auto unknown = sweep(folder, kDrum + " --over strenght=0:1:2 --measure rate:instrument.hit");
  CHECK(unknown.exit == 2);
  CHECK(unknown.errors.find("'strength'") != std::string::npos);
  CHECK(sweep(folder, kDrum + " --over strength=0:1 --measure rate:instrument.hit").exit == 2);
  CHECK(sweep(folder, kDrum + " --over strength=0:1:2 --measure loudness").exit == 2);
  CHECK(sweep(folder, kDrum + " --over strength=0:1:2").exit == 2);
  CHECK(sweep(folder, kDrum + " --part 1/2 --measure rate:instrument.hit").exit == 2);
}

TEST_CASE("sweep command: a table for people, and a plot", "[apps][sweep]") {
  const test::TemporaryFolder folder;
  const auto svg = folder.path() / "map.svg";
  const auto out = sweep(folder, kGrid + " --svg " + svg.string());
  CHECK(out.exit == 0);
  for (const auto* column : {"strength", "delay", "rate:instrument.hit", "20 ms"})
    CHECK(out.text.find(column) != std::string::npos);
  CHECK(text_of(svg).starts_with("<svg"));
}
