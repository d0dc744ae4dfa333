#include "engine/nodes/solver_words.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactus {
namespace {

std::string described(const SolverBounds& b) {
  return b.oversample == 1 ? std::string(name_of(b.solver))
                           : fmt::format("{} with {} steps a frame", name_of(b.solver), b.oversample);
}

double percent(double error) { return 100.0 * std::min(error, 1.0); }

std::string against(const SolverBounds& b) {
  switch (b.limit) {
    case SolverBounds::Limit::CannotBeMade:
      return "too many masses or contacts for it";
    case SolverBounds::Limit::TooStiff:
      return "springs or dampers make it unstable";
    case SolverBounds::Limit::ShortContact:
      return fmt::format("a strike at {} m/s lasts {:.1f} steps, fewer than {}", kHardestStrike,
                         b.contact_steps, kFewestContactSteps);
    case SolverBounds::Limit::DeepContact:
      return fmt::format("what it starts with, or a strike at {} m/s, presses a contact too stiff for it",
                         kHardestStrike);
    case SolverBounds::Limit::Inexact:
      return fmt::format("wrong by up to {:.2g} %", percent(b.error));
    case SolverBounds::Limit::None:
      break;
  }
  return "";
}

}  // namespace

const char* name_of(Solver solver) {
  switch (solver) {
    case Solver::Explicit:
      return "explicit";
    case Solver::Passive:
      return "passive";
    case Solver::Implicit:
      return "implicit";
    case Solver::Exact:
      return "exact";
    case Solver::Reference:
      return "reference";
    case Solver::Auto:
      break;
  }
  return "auto";
}

std::string reason_for(const SolverChoice& choice) {
  const auto is_best = [&](const SolverBounds& b) {
    return b.solver == choice.solver && b.oversample == choice.oversample;
  };
  const auto best = std::find_if(choice.candidates.begin(), choice.candidates.end(), is_best);
  if (best == choice.candidates.end()) return "";
  auto text = fmt::format("{}, {:.0f} multiplications a frame, ", described(*best), best->multiplications);
  if (best->limit == SolverBounds::Limit::None)
    text += best->error == 0.0 ? std::string("exact")
                               : fmt::format("wrong by at most {:.2g} %", percent(best->error));
  else
    text += "the most accurate of the stable ones, " + against(*best);
  for (const auto& other : choice.candidates)
    if (other.multiplications < best->multiplications && other.limit != SolverBounds::Limit::None &&
        other.limit != SolverBounds::Limit::CannotBeMade)
      text += fmt::format("; not {}: {}", described(other), against(other));
  return text;
}

}  // namespace tactus
