// The program itself on a real card, which is pulled out while it plays.
#include <cstdint>
#include <cstdlib>
#include <filesystem>

#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/jack/playing.h"

using namespace tactus;
using test::alsa_ways;
using test::CableCard;
using test::kSlowMachine;
using test::Playing;
using test::wait_until;

namespace {

int times(const char* variable, int usual) {
  const char* text = std::getenv(variable);
  return text == nullptr ? usual : std::atoi(text);
}

/// Until it has printed this `many` times.
bool says(Playing& play, const std::string& words, int many) {
  const bool said =
      wait_until([&] { return play.count(words) >= many || !play.process().running(); }, kSlowMachine);
  if (const auto code = play.process().wait(std::chrono::milliseconds{0})) WARN("it ended with " << *code);
  return said && play.count(words) == many;
}

/// Until this has become longer than a soft start.
bool is_recorded(const std::filesystem::path& take) {
  constexpr std::uintmax_t kBytes = 2 * 48'000 * sizeof(float);  // a second of one input and one output
  return wait_until([&] { return exists(take) && file_size(take) >= kBytes; }, kSlowMachine);
}

/// [s] How long the card was away the last time.
double last_absence(const Playing& play) {
  const auto log = play.log();
  const std::string words = "reconnected after ";
  return std::stod(log.substr(log.rfind(words) + words.size()));
}

}  // namespace

TEST_CASE(
    "alsa: a card pulled out while armed and playing is reported, and plays again armed when it is back",
    "[.alsa]") {
  const CableCard card;
  for (const auto& way : alsa_ways()) DYNAMIC_SECTION(way.name) {
      const test::TemporaryFolder folder;
      const auto tone = folder.write("tone.toml", test::constant("0.2")).string();
      const auto backend = way.backend();
      const auto request = card.request(*backend, 48000, 2048);
      Playing play{{tone, "--device", request.device, "--input-device", request.input_device, "--block",
                    "2048", "--arm", "--json", "--record", (folder.path() / "take.wav").string()}};
      REQUIRE(says(play, "delay ", 1));
      int disarmed = 0;
      const int pulls = times("TACTUS_PULLS", 3);
      for (int turn = 1; turn <= pulls; ++turn) {
        CAPTURE(way.name, turn, play.log());
        card.pull();
        REQUIRE(says(play, "disconnected; outputs", turn));
        card.plug();
        REQUIRE(says(play, "reconnected after", turn));
        if (last_absence(play) > 10.0) {  // on a slow machine: then it comes back disarmed
          REQUIRE(says(play, "drives disarmed:", ++disarmed));
          play.arm();
        }
        if (turn % 10 == 0 || turn == pulls)
          WARN(way.name << ": " << turn << " pulls, " << play.count("drives disarmed:")
                        << " of them for more than 10 s");
      }
      CHECK(is_recorded(folder.path() / ("take-" + std::to_string(pulls + 1) + ".wav")));  // one each return
      play.press("q");
      CHECK(play.ends() == 0);
      const auto report = play.report();
      INFO(play.log());
      REQUIRE(report.is_object());
      CHECK(report["highest_input"]["heard"].get<double>() > 0.19);
    }
}
