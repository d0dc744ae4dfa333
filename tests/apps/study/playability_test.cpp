#include <catch2/catch.hpp>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "apps/study/study.h"
#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace tactus::app;

namespace {

std::vector<double> si(const std::vector<ControlValue>& values) {
  std::vector<double> numbers;
  for (const auto& value : values) numbers.push_back(value.si);
  return numbers;
}

/// What ends the command.
Error error_of(auto parse, const std::string& text, const std::string& option) {
  try {
    parse(text, option);
  } catch (const CommandError& error) {
    return error.errors.front();
  }
  FAIL(text << " was accepted");
  return {};
}

/// A roll at delays from 0 ms on, with these scores; below a half it is irregular and not playable.
PlayabilityStudy rolls(const std::vector<double>& scores) {
  PlayabilityStudy study;
  study.scene = "roll";
  study.variants = {"as written"};
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const bool good = scores[i] >= 0.5;
    study.delays_s.push_back(1e-3 * static_cast<double>(i));
    auto& run = study.runs.emplace_back();
    run.delay_s = study.delays_s.back();
    run.variant = "as written";
    run.result = PlayabilityResult{good ? "regular" : "irregular", scores[i], good,
                                   std::vector<double>(measure_columns(study.kind).size(), 1.0)};
  }
  return study;
}

}  // namespace

TEST_CASE("sweep range: steps are even in the unit that was written", "[apps]") {
  const auto delays = parse_steps("0:40:1 ms", "--delays");
  REQUIRE(delays.size() == 41);
  CHECK(delays[3].si == 0.003);  // as "3 ms" is read, not three times 0.001
  const auto few = si(parse_steps("1 ms:2 ms:0.4 ms", "--delays"));  // 2 ms is not reached
  REQUIRE(few.size() == 3);
  CHECK(few[2] == Approx(0.0018));
  CHECK(si(parse_steps("20 ms", "--delays")) == std::vector{0.02});
  CHECK(si(parse_spread("0.2:1:5", "--over")) == std::vector{0.2, 0.4, 0.6, 0.8, 1.0});
  const auto gains = si(parse_spread("-20:20:3 dB", "--over"));
  REQUIRE(gains.size() == 3);
  CHECK(gains[0] == Approx(0.1));
  CHECK(gains[1] == Approx(1));
  CHECK(gains[2] == Approx(10));
  const auto factors = si(parse_spread("0.2:3.2:5:log", "--over"));
  CHECK(factors == std::vector{0.2, 0.4, 0.8, 1.6, 3.2});
  const auto octaves = parse_spread("55:880:5:log Hz", "--over");
  CHECK(si(octaves) == std::vector{55.0, 110.0, 220.0, 440.0, 880.0});
  CHECK(*octaves.front().dimension == Dimension{.second = -1});
}

TEST_CASE("sweep range: bad ranges are errors at the option", "[apps]") {
  for (const auto* text : {"0:40", "40:0:1 ms", "0:40:1 mx"}) {
    const auto error = error_of(parse_steps, text, "--delays");
    CHECK(error.code == Errc::Syntax);
    CHECK(error.where == "--delays");
  }
  CHECK(error_of(parse_steps, "0 ms:1 s:1 ms", "--delays").code == Errc::UnitMismatch);
  CHECK(error_of(parse_steps, "0:40:0.0001 ms", "--delays").code == Errc::OutOfRange);
  CHECK(error_of(parse_spread, "0:1:2.5", "--over").code == Errc::Syntax);
  CHECK(error_of(parse_spread, "0:1:5:log", "--over").code == Errc::OutOfRange);
  CHECK(error_of(parse_spread, "1:2:5:logs", "--over").remedy.find("FROM:TO:COUNT:log") != std::string::npos);
  CHECK(error_of(parse_spread, "3:log", "--over").code == Errc::Syntax);
}

TEST_CASE("playability report: the verdict names the delays and the weakest of them", "[apps]") {
  CHECK(describe_verdict(rolls({1, 1, 0.7, 1})) ==
        "playable from 0 to 3 ms; weakest at 2 ms: regular, score 0.70");
  CHECK(describe_verdict(rolls({1, 1, 0.3, 1, 0.2, 0.1})) ==
        "playable from 0 to 1 and at 3 ms; not at 2 and from 4 to 5 ms; weakest at 5 ms: irregular, score "
        "0.10");
  CHECK(describe_verdict(rolls({0.1, 0.2})) ==
        "playable at no delay; weakest at 0 ms: irregular, score 0.10");
}

TEST_CASE("playability report: a map of letters where something is swept", "[apps]") {
  auto study = rolls({1, 1, 0.3, 1});
  study.delays_s = {0.0, 1e-3};  // two delays, two strengths
  study.over = {{"strength", {0.5, 1.0}}};
  for (std::size_t i = 0; i < 4; ++i) {
    study.runs[i].delay_s = study.delays_s[i / 2];
    study.runs[i].at = {i % 2 == 0 ? 0.5 : 1.0};
  }
  const auto text = text_of(study);
  CHECK(text.find("strength  delay [ms] 0 to 1\n       1  RR\n     0.5  Ri\n") != std::string::npos);
  CHECK(
      text.ends_with("1 of 2 settings are playable at every delay, except strength 0.5; 3 of 4 runs; all 2 "
                     "at 0 ms; weakest at "
                     "1 ms: irregular, score 0.30 at strength 0.5\n"));
}

TEST_CASE("playability report: the verdict of a map counts settings that are playable at every delay",
          "[apps]") {
  auto study = rolls({1, 0.3, 0.2, 0.1, 0.4, 0.9, 1, 0.9, 0.8, 1, 1, 1});
  study.delays_s = {0.0, 1e-3};
  study.over = {{"weight", {0.5, 1.0, 2.0}, SweptValue::What::Scaled}, {"strength", {0.2, 0.4}}};
  for (std::size_t i = 0; i < 12; ++i) {
    study.runs[i].delay_s = study.delays_s[i / 6];
    study.runs[i].at = {study.over[0].values[i % 6 / 2].si, study.over[1].values[i % 2].si};
  }
  CHECK(
      describe_verdict(study) ==
      "2 of 6 settings are playable at every delay, except weight x 0.5, strength 0.4 / weight x 1, strength "
      "0.2 / "
      "weight x 1, strength 0.4 and 1 more; 8 of 12 runs; all 6 at 1 ms; weakest at 0 ms: irregular, score "
      "0.10 "
      "at weight x 1, strength 0.4");
  for (auto& run : study.runs) run.result->playable = true;
  CHECK(describe_verdict(study).starts_with("all 6 settings are playable from 0 to 1 ms; weakest"));
}

TEST_CASE("playability report: the JSON has every run with what was read of it", "[apps]") {
  const auto json = json_of(rolls({1, 0.3}));
  CHECK(json["kind"] == "roll");
  REQUIRE(json["delays"].size() == 2);
  CHECK(json["delays"][0]["playable"] == true);
  CHECK(json["delays"][1]["score"] == 0.3);
  REQUIRE(json["runs"].size() == 2);
  CHECK(json["runs"][1]["kind"] == "irregular");
  CHECK(json["runs"][1]["rate_hz"] == 1.0);
  CHECK(json["runs"][1]["variant"] == "as written");
}

namespace {

const std::string kDrum = std::string{TACTUS_SOURCE_DIR} + "/instruments/haptic_drum";

int exit_of(const std::string& arguments) {
  const auto command = std::string{TACTUS_PROGRAM} + " study playability " + arguments + " >/dev/null 2>&1";
  return std::system(command.c_str()) / 256;
}

}  // namespace

TEST_CASE("study playability: exit codes, and a picture of each form", "[apps]") {
  const test::TemporaryFolder folder;
  const auto svg = (folder.path() / "map.svg").string();
  const auto shown = [&] {
    std::ifstream stream{svg};
    const std::string text{std::istreambuf_iterator<char>{stream}, {}};
    return text.starts_with("<svg") && text.find("Playability of one-handed roll") != std::string::npos &&
           text.ends_with("</svg>\n");
  };
  CHECK(exit_of(kDrum + " --delays '10:20:10 ms' --duration '2 s' --svg " + svg) == 0);
  CHECK(shown());
  CHECK(exit_of(kDrum + " --delays '20 ms' --duration '2 s' --set strength=0") == 1);
  CHECK(exit_of(kDrum + " --delays '20 ms' --duration '2 s' --over strength=0:1:2 --svg " + svg) == 1);
  CHECK(shown());
  CHECK(exit_of(kDrum +
                " --delays '20 ms' --duration '2 s' --over strength=0.9:1:2 --over weight=1:1.1:2 --svg " +
                svg) == 0);
  CHECK(shown());
  CHECK(exit_of(kDrum + " --delay 20") == 2);
  CHECK(exit_of(kDrum + " --delays '20 ms' --gain 6") == 2);
  CHECK(exit_of(kDrum + " --delays '20 ms' --over strength=0.5:1:2 --set strength=0.9") == 2);
  CHECK(exit_of(kDrum + " --delays '20 ms' --over strength=0.5:1:2 --over strength=0.2:1:3") == 2);
  CHECK(exit_of(kDrum + " --part 1/2") == 2);
  CHECK(exit_of(kDrum + "/single_strike.toml") == 3);
}

TEST_CASE("study playability: Ctrl-C ends it with 5 and keeps what is done", "[apps]") {
  const test::TemporaryFolder folder;
  const auto kept = folder.path() / "runs.jsonl";
  test::ChildProcess study{{TACTUS_PROGRAM, "study", "playability", kDrum, "--delays", "0:1000:1 ms",
                            "--duration", "2 s", "--keep", folder.path().string()},
                           test::ChildProcess::Stdout::Logged};
  REQUIRE(
      test::wait_until([&] { return std::filesystem::exists(kept) && std::filesystem::file_size(kept) > 0; },
                       std::chrono::seconds{60}));
  study.send(SIGINT);
  CHECK(study.wait(std::chrono::seconds{60}) == 5);
  CHECK(study.log().find("the same command resumes it") != std::string::npos);
  std::ifstream lines{kept};
  std::string last;
  for (std::string line; std::getline(lines, line);) last = line;
  CHECK(last.ends_with("}"));
}
