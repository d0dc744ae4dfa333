#include "engine/study/playability/playability.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "engine/graph/file/read_graph.h"
#include "engine/nodes/table.h"
#include "tests/support/error_summary.h"
#include "tests/support/reading.h"
#include "tests/support/temporary_folder.h"

using namespace tactus;
using tactus::test::reading;

namespace {

const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

SceneSpec scene_of(const std::string& file) {
  auto scene = load_scene(kInstruments / file, kInstruments);
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  return *scene;
}

SceneSpec short_drum() {
  auto scene = scene_of("haptic_drum/scene.toml");
  scene.duration = Seconds{2};
  return scene;
}

SweepPlan over_delays(const std::vector<ControlValue>& delays) {
  SweepPlan plan;
  plan.over = {{"delay", delays, SweptValue::What::Delay}};
  return plan;
}

/// Two delays, two strengths, three actuators, one other plant.
SweepPlan small() {
  auto options = over_delays({0.01, 0.02});
  options.over.push_back({"strength", {0.4, 1.0}});
  options.gains = {0.5, 2};
  options.draws = 1;
  return options;
}

PlayabilityStudy studied(const SweepPlan& options) {
  auto study = study_playability(short_drum(), standard_nodes(), options);
  if (!study) throw std::runtime_error(to_string(study.error()));
  return std::move(*study);
}

bool same(const PlayabilityStudy& a, const PlayabilityStudy& b) {
  if (a.runs.size() != b.runs.size()) return false;
  for (std::size_t i = 0; i < a.runs.size(); ++i)
    if (a.runs[i].delay_s != b.runs[i].delay_s || a.runs[i].at != b.runs[i].at ||
        a.runs[i].variant != b.runs[i].variant || a.runs[i].result != b.runs[i].result)
      return false;
  return true;
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream{file, std::ios::binary};
  return {std::istreambuf_iterator<char>{stream}, {}};
}

std::string error_of(const SceneSpec& scene, const SweepPlan& options) {
  const auto study = study_playability(scene, standard_nodes(), options);
  return test::summary(study);
}

}  // namespace

TEST_CASE("playability: the number of workers changes nothing", "[analysis][slow]") {
  auto options = small();
  options.workers = 1;
  const auto alone = studied(options);
  REQUIRE(alone.runs.size() == 2 * 2 * 4);
  CHECK(finished(alone.runs) == 16);
  CHECK(alone.runs[0].as_written());
  CHECK(alone.runs[1].variant == "actuator x 0.5");
  CHECK(alone.runs[3].variant == "draw 1");
  options.workers = 5;
  CHECK(same(studied(options), alone));
}

TEST_CASE("playability: cached runs are not played again, runs of an incomplete line are",
          "[analysis][slow]") {
  const test::TemporaryFolder folder;
  auto options = small();
  const auto fresh = studied(options);
  options.cache = folder.path();
  CHECK(same(studied(options), fresh));
  const auto file = folder.path() / "runs.jsonl";
  const auto whole = text_of(file);
  CHECK(std::count(whole.begin(), whole.end(), '\n') == 16);
  CHECK(same(studied(options), fresh));
  CHECK(text_of(file) == whole);  // nothing was added
  // A kill in the middle of a line: that run is played again, on a line of its own.
  std::ofstream{file, std::ios::binary} << whole.substr(0, whole.size() - 20);
  CHECK(same(studied(options), fresh));
  const auto repaired = text_of(file);
  CHECK(std::count(repaired.begin(), repaired.end(), '\n') == 17);
  CHECK(same(studied(options), fresh));
  CHECK(text_of(file) == repaired);
}

TEST_CASE("playability: the shares of a study make the whole of it", "[analysis][slow]") {
  const test::TemporaryFolder folder;
  auto options = small();
  const auto fresh = studied(options);
  options.cache = folder.path();
  options.parts = 3;
  for (options.part = 0; options.part < 3; ++options.part) {
    const auto share = studied(options);
    CHECK((finished(share.runs) == 16) == (options.part == 2));
  }
  options.parts = 1;
  options.part = 0;
  options.stop = [] { return true; };  // all is there: nothing is begun
  CHECK(same(studied(options), fresh));
}

TEST_CASE("playability: stopped, it stores finished runs and resumes", "[analysis][slow]") {
  const test::TemporaryFolder folder;
  auto options = small();
  const auto fresh = studied(options);
  options.cache = folder.path();
  options.workers = 1;
  int calls = 0;
  options.stop = [&] { return ++calls > 5; };
  const auto stopped = studied(options);
  CHECK(finished(stopped.runs) == 5);
  options.stop = {};
  CHECK(same(studied(options), fresh));
}

TEST_CASE("playability: another scene, seed or control is another run", "[analysis]") {
  const test::TemporaryFolder folder;
  auto options = small();
  options.over.pop_back();
  options.cache = folder.path();
  studied(options);
  options.stop = [] { return true; };
  CHECK(finished(studied(options).runs) == 8);
  auto other = options;
  other.seed = 2;
  CHECK(finished(studied(other).runs) == 6);  // all but the draws
  other = options;
  other.set["strength"] = 0.9;
  CHECK(finished(studied(other).runs) == 0);
}

TEST_CASE("playability: a delay is playable when all as written are, and nine of ten of the others",
          "[analysis]") {
  PlayabilityStudy study;
  study.delays_s = {0.0};
  study.variants.resize(11);
  for (int i = 0; i < 11; ++i)
    study.runs.push_back(
        {{{}, i == 0 ? "as written" : "draw", PlayabilityResult{"regular", 1, i != 3, {}}}, 0});
  CHECK(study.verdicts().front().playable);
  CHECK(study.verdicts().front().robust() == Approx(0.9));
  study.runs[4].result->playable = false;
  CHECK_FALSE(study.verdicts().front().playable);
  study.runs[3].result->playable = study.runs[4].result->playable = true;
  study.runs[0].result->playable = false;
  CHECK_FALSE(study.verdicts().front().playable);
}

TEST_CASE("playability: errors are reported before anything is played", "[analysis]") {
  auto options = over_delays({0.02});
  auto scene = short_drum();
  scene.playability.reset();
  CHECK(error_of(scene, options).find("[playability]") != std::string::npos);
  options.over.push_back({"strenght", {0.5}});
  CHECK(error_of(short_drum(), options).find("strenght") != std::string::npos);
  options.over.back() = {"strength", {0.5, 7.0}};
  CHECK(error_of(short_drum(), options).find("7") != std::string::npos);
}

TEST_CASE("playability: a control that a gesture moves is swept by the gesture", "[analysis]") {
  auto options = over_delays({0.02});
  options.over.push_back({"strength", {0.5}});
  auto scene = short_drum();
  for (auto& part : scene.parts)
    if (part.name == "instrument")
      part.wires.push_back({"strength", part.at, {std::string{"weight"}, part.at}});
  CHECK(error_of(scene, options) == "--over BadArgument 'strength' 'weight' --over 0.5 2 4");
}

TEST_CASE("playability: a gesture can be held at values of its own unit", "[analysis]") {
  auto options = over_delays({0.02});
  const auto unit = short_drum().gesture("weight")->unit.dimension;
  options.over.push_back({"weight", {{0.3, unit}, {0.35, unit}}, SweptValue::What::Held});
  const auto study = study_playability(short_drum(), standard_nodes(), options);
  REQUIRE(study);
  CHECK(study->runs[0].result != study->runs[1].result);
  options.over[1].values = {{0.001, Dimension{.second = 1}}};
  CHECK(error_of(short_drum(), options) == "--over UnitMismatch 'weight'");
}

TEST_CASE("playability: the folder of the Cellomobo means its phrase, of which each note is result",
          "[analysis][instruments][slow]") {
  auto options = over_delays({0.02});
  const auto study = study_playability(scene_of("cellomobo/scene.toml"), standard_nodes(), options);
  REQUIRE(study);
  const auto& run = *study->runs[0].result;
  CHECK(reading(run, Playability::Kind::Tone, "notes") == 10);
  CHECK(reading(run, Playability::Kind::Tone, "good") == 10);
  CHECK(run.playable);
}

// What [delay] tested of the shipped instruments says, on a short run.
TEST_CASE("playability: the shipped instruments are playable over all the delays that they call tested",
          "[analysis][instruments]") {
  const std::string file = GENERATE("haptic_drum/scene.toml", "cellomobo/open_string.toml");
  auto scene = scene_of(file);
  scene.duration = Seconds{std::min(scene.duration.value, 4.0)};
  const auto tested = scene.part("instrument")->graph->tested;
  REQUIRE(tested);
  REQUIRE(tested->low <= 0.02);
  REQUIRE(tested->high >= 0.02);
  auto options = over_delays({});
  for (int i = 0; i <= 8; ++i)
    options.over[0].values.emplace_back(tested->low + i * (tested->high - tested->low) / 8);
  const auto study = study_playability(scene, standard_nodes(), options);
  REQUIRE(study);
  for (const auto& verdict : study->verdicts()) {
    INFO(file << " at " << 1e3 * verdict.delay_s << " ms: score " << verdict.score);
    CHECK(verdict.playable);
  }
}

TEST_CASE("playability: the drum keeps to its tested delays with other woofers and plants",
          "[analysis][instruments][slow]") {
  auto scene = scene_of("haptic_drum/scene.toml");
  scene.duration = Seconds{4};
  const auto tested = scene.part("instrument")->graph->tested;
  REQUIRE(tested);
  // Both ends, and both sides of the delay from which it waits for the third bounce.
  auto options = over_delays({tested->low, 0.022, 0.023, tested->high});
  options.gains = {0.5, 2};
  options.draws = 18;
  const auto study = study_playability(scene, standard_nodes(), options);
  REQUIRE(study);
  for (const auto& verdict : study->verdicts()) {
    INFO("at " << 1e3 * verdict.delay_s << " ms: " << verdict.robust() << " of the others");
    CHECK(verdict.playable);
  }
}

TEST_CASE("playability: without the throw the drum is dead at every delay", "[analysis][instruments]") {
  auto options = over_delays({0, 0.02, 0.04});
  options.set["strength"] = 0.0;
  for (const auto& run : studied(options).runs) {
    CHECK(run.result->kind == "dead");
    CHECK(run.result->score == 0);
  }
}
