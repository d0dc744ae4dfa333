#include "engine/study/stability/models/thrown_network.h"

#include <algorithm>
#include <cmath>

#include "engine/core/index.h"
#include "engine/physics/solvers/solver_choice.h"

namespace tactus {
namespace {

constexpr int kFrames = 200'000;
constexpr double kGrown = 100.0;

bool grows(const NetworkRecipe& recipe, const NetworkElements& elements) {
  const auto network = Network::make(elements, recipe.signals, recipe.rate, recipe.solver, recipe.oversample);
  if (!network) return false;
  auto state = network->initial_state();
  const std::vector<double> inputs(index(recipe.signals), 0.0);
  double first = kHardestStrike;
  for (int frame = 0; frame < kFrames; ++frame) {
    network->step(state, inputs.data());
    double most = 0.0;
    for (std::size_t p = 0; p < elements.points.size(); ++p) {
      if (elements.points[p].kind != Point::Kind::Mass) continue;
      const double speed = std::abs(network->velocity(state, static_cast<int>(p)));
      if (!(speed <= kGrown * first)) return true;
      most = std::max(most, speed);
    }
    if (frame < kFrames / 10) first = std::max(first, most);
  }
  return false;
}

}  // namespace

bool grows_when_thrown(const NetworkRecipe& recipe, const NetworkElements& elements, double factor) {
  auto start = elements;
  for (auto& point : start.points) {
    if (point.kind != Point::Kind::Mass) continue;
    point.velocity *= factor;
    point.position *= factor;
  }
  if (grows(recipe, start)) return true;
  for (std::size_t p = 0; p < start.points.size(); ++p) {
    if (start.points[p].kind != Point::Kind::Mass) continue;
    auto thrown = start;
    thrown.points[p].velocity = factor * kHardestStrike;
    if (grows(recipe, thrown)) return true;
  }
  return false;
}

}  // namespace tactus
