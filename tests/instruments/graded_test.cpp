#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "engine/scene/measures/playability_result.h"
#include "tests/support/shipped_scene.h"

using namespace tactus;

namespace {

/// The scenes of a kind are numbered from the best to the worst, in an order that was written down before
/// they were scored.
std::array<double, 6> scores_of(const std::string& kind) {
  const std::filesystem::path root{TACTUS_SOURCE_DIR};
  std::array<double, 6> scores{};
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const auto file = root / "tests/instruments/graded" / (kind + "_" + std::to_string(i + 1) + ".toml");
    const auto scene = load_scene(file, root);
    if (!scene) throw std::runtime_error(to_string(scene.error()));
    REQUIRE(scene->playability);
    scores[i] = evaluate(test::play(*scene), *scene->playability).score;
  }
  return scores;
}

/// 1 - 6 sum d^2 / (n (n^2 - 1)); equal scores share their mean rank.
double spearman(const std::array<double, 6>& best_first) {
  const auto n = static_cast<double>(best_first.size());
  double squares = 0, place = 1;
  for (const double score : best_first) {
    const auto above = std::ranges::count_if(best_first, [&](double other) { return other > score; });
    const auto equal = std::ranges::count(best_first, score);
    const double rank = static_cast<double>(above) + (static_cast<double>(equal) + 1) / 2;
    squares += (rank - place) * (rank - place);
    place += 1;
  }
  return 1 - 6 * squares / (n * (n * n - 1));
}

}  // namespace

TEST_CASE("playability: the score ranks scenes of graded quality, and tells them apart",
          "[instruments][slow]") {
  const std::string kind = GENERATE("drum", "string");
  const auto scores = scores_of(kind);
  INFO(kind << ": " << scores[0] << " " << scores[1] << " " << scores[2] << " " << scores[3] << " "
            << scores[4] << " " << scores[5]);
  CHECK(spearman(scores) >= 0.9);
  CHECK(*std::ranges::max_element(scores) > 0.9);
  CHECK(*std::ranges::min_element(scores) < 0.2);
}
