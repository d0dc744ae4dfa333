#include "latency/measured.h"

#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>

#include "tests/support/temporary_folder.h"

using namespace tactus;

namespace {

MeasuredDelay delay(const std::string& device, int block, double seconds, const std::string& when) {
  return {{device, device, 48_kHz, block, 2}, Seconds{seconds}, std::nullopt, when};
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in{file};
  return {std::istreambuf_iterator<char>{in}, {}};
}

}  // namespace

TEST_CASE("measured: what is kept is found again, for its own setting only", "[latency]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "state" / "delays.json";
  auto store = MeasuredDelays::load(file);
  CHECK(store.all().empty());
  CHECK_FALSE(store.load_error());
  REQUIRE(store.save(delay("jack:system", 64, 0.1 + 0.2, "2026-01-02T00:00:00Z")));
  auto spread = delay("jack:system", 256, 0.02, "2026-01-01T00:00:00Z");
  spread.spread = Seconds{1e-5};
  REQUIRE(store.save(spread));
  const auto again = MeasuredDelays::load(file);
  REQUIRE(again.all().size() == 2);
  const auto* found = again.find(delay("jack:system", 64, 0, "").key);
  REQUIRE(found != nullptr);
  CHECK(found->delay.value == 0.1 + 0.2);
  CHECK(again.find(spread.key)->spread == Seconds{1e-5});
  CHECK(again.find(delay("jack:system", 128, 0, "").key) == nullptr);
  CHECK(again.find(delay("alsa:usb", 64, 0, "").key) == nullptr);
  const auto newest = [&](const std::string& device) {
    return again.newest([&](const DelayKey& key) { return key.input == device; });
  };
  CHECK(newest("jack:system")->key.block_frames == 64);
  CHECK(newest("alsa:usb") == nullptr);
}

TEST_CASE("measured: the newest takes the place of the last, and what others wrote meanwhile stays",
          "[latency]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "delays.json";
  auto one = MeasuredDelays::load(file), two = MeasuredDelays::load(file);
  REQUIRE(one.save(delay("a", 64, 0.001, "1")));
  REQUIRE(two.save(delay("b", 64, 0.002, "2")));
  REQUIRE(one.save(delay("a", 64, 0.003, "3")));
  const auto store = MeasuredDelays::load(file);
  CHECK(store.all().size() == 2);
  CHECK(store.find(delay("a", 64, 0, "").key)->delay == Seconds{0.003});
  CHECK(std::distance(std::filesystem::directory_iterator{folder.path()}, {}) == 1);  // nothing lies about
}

TEST_CASE("measured: a broken file is reported and kept aside, each one", "[latency]") {
  const test::TemporaryFolder folder;
  const auto* text = GENERATE("{", "[]", R"({"format": 2, "delays": []})", R"({"format": 1, "delays": [{}]})",
                              R"({"format": 1, "delays": 7})", "");
  const auto file = folder.write("delays.json", text);
  auto store = MeasuredDelays::load(file);
  REQUIRE(store.load_error());
  CHECK(store.load_error()->code == Errc::BadFile);
  CHECK(text_of(folder.path() / "delays.json.broken") == text);
  REQUIRE(store.save(delay("a", 64, 0.001, "1")));
  folder.write("delays.json", "again");
  CHECK(MeasuredDelays::load(file).load_error()->remedy.find("delays.json.broken2'") != std::string::npos);
  CHECK(text_of(folder.path() / "delays.json.broken") == text);
}

TEST_CASE("measured: a folder that cannot be written is an error in words", "[latency]") {
  const test::TemporaryFolder folder;
  const auto file = folder.write("no_folder", "") / "delays.json";
  auto store = MeasuredDelays::load(file);
  const auto status = store.save(delay("a", 64, 0.001, "1"));
  REQUIRE_FALSE(status);
  CHECK(status.error().code == Errc::BadFile);
  CHECK(status.error().remedy.find("XDG_STATE_HOME") != std::string::npos);
}
