#include "engine/nodes/networks/solver_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/nodes/declare.h"

namespace tactus {
namespace {

constexpr auto kPassiveSource = "Ducceschi, Bilbao, Willemsen & Serafin, JASA 149, 2021";

struct SolverEntry {
  Solver solver;
  const char *name, *source;
};
constexpr SolverEntry kEntries[] = {
    {Solver::Explicit, "explicit", "Cadoz, Luciani & Florens, Computer Music Journal 17(1), 1993"},
    {Solver::Passive, "passive", kPassiveSource},
    {Solver::Implicit, "implicit",
     "Newmark, J. Eng. Mech. 85, 1959; Bilbao, Torin & Chatziioannou, Acta Acustica 101, 2015"},
    {Solver::Exact, "exact", "Van Loan, IEEE Trans. Autom. Control 23, 1978"},
    {Solver::Reference, "reference",
     "Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, Springer, 1993"},
    {Solver::Auto, "auto", kPassiveSource}};

const SolverEntry& entry_of(Solver solver) {
  return *std::find_if(std::begin(kEntries), std::end(kEntries),
                       [&](const SolverEntry& entry) { return entry.solver == solver; });
}

std::string steps_text(int oversample) {
  return oversample == 1 ? "one step per frame" : fmt::format("{} steps per frame", oversample);
}

std::string described(const SolverBounds& b) {
  return b.oversample == 1 ? std::string(name_of(b.solver))
                           : fmt::format("{} with {}", name_of(b.solver), steps_text(b.oversample));
}

std::string percent(double error) {
  return error >= 0.095 ? fmt::format("{:.0f} %", 100.0 * std::min(error, 1.0))
                        : fmt::format("{:.2g} %", 100.0 * error);
}

/// What it has no bound on.
std::string unknown(const SolverBounds& b) {
  const auto opening = fmt::format(
      "a contact with loss is pressed at the start and open again within {:g} frames", kShortContact);
  if (!b.opens_unknown) return "friction or plectra";
  return b.slips_unknown ? "friction or plectra; " + opening : opening;
}

std::string error_text(const SolverBounds& b) {
  const bool partly = b.slip_frames > 0.0 || !b.bounded();
  std::string text = b.error == 0.0 ? std::string{partly ? "resonances exact" : "exact"}
                                    : "error at most " + percent(b.error);
  if (b.contact_frames > 0.0)
    text += fmt::format(", contacts shorter than {:g} frames right within {:g} frames", kShortContact,
                        b.contact_frames);
  if (b.slip_frames > 0.0)
    text += fmt::format(
        ", friction and plectra as if their forces were at most {} off, each stop and slip within {:g} "
        "frames",
        percent(b.slip_error), b.slip_frames);
  if (!b.bounded()) text += ", not bounded: " + unknown(b);
  return text;
}

std::string against(const SolverBounds& b) {
  switch (b.limit) {
    case SolverBounds::Limit::CannotBeMade:
      return "too many masses or contacts for this solver";
    case SolverBounds::Limit::TooStiff:
      return "unstable: springs or dampers too stiff";
    case SolverBounds::Limit::ShortContact:
      return fmt::format("a contact at {} m/s lasts {:.1f} steps, less than required", kHardestStrike,
                         b.contact_steps);
    case SolverBounds::Limit::DeepContact:
      return fmt::format("unstable: a contact is too stiff in the initial state or at an impact of {} m/s",
                         kHardestStrike);
    case SolverBounds::Limit::Inexact:
      return "error up to " + percent(b.error);
    case SolverBounds::Limit::None:
      break;
  }
  return "";
}

/// What was cheaper than the best and would not do: of each solver the one with the most steps a frame.
std::vector<const SolverBounds*> cheaper(const SolverChoice& choice, const SolverBounds& best) {
  using Limit = SolverBounds::Limit;
  std::vector<const SolverBounds*> list;
  for (const auto& other : choice.candidates) {
    if (!(other.multiplications < best.multiplications)) continue;
    if (other.limit == Limit::None || other.limit == Limit::CannotBeMade) continue;
    const auto known =
        std::find_if(list.begin(), list.end(), [&](const auto* b) { return b->solver == other.solver; });
    if (known == list.end())
      list.push_back(&other);
    else if (other.oversample > (*known)->oversample)
      *known = &other;
  }
  return list;
}

std::string warning(const SolverBounds& best) {
  return fmt::format("\n  warning: no solver has an error below {:g} % at {}: {}", 100.0 * kGoodEnough,
                     steps_text(best.oversample),
                     best.oversample < kMostOversample
                         ? "omit `oversample`, or use a higher sample rate"
                         : "use a higher sample rate, heavier masses or softer springs and contacts");
}

}  // namespace

const char* name_of(Solver solver) { return entry_of(solver).name; }
const char* source_of(Solver solver) { return entry_of(solver).source; }

const SectionType& network_options() {
  static const SectionType section = [] {
    std::vector<std::string> solvers;
    for (const auto solver : kSolvers) solvers.emplace_back(name_of(solver));
    return SectionType{
        "A network",
        {choice_field("solver", std::move(solvers), "solver of the network", name_of(Solver::Passive)),
         whole_field("oversample", 1, kMostOversample, "solver steps per frame", "1"), motion_setting()}};
  }();
  return section;
}

std::string describe_bound(const SolverBounds& bounds) {
  if (!bounds.stable) return "error not bounded: " + against(bounds);
  if (!bounds.bounded()) return "error not bounded: " + unknown(bounds);
  if (bounds.error >= 1.0)
    return "error not bounded: a step is too long for the stiffest spring, damper or contact";
  return bounds.error == 0.0 && bounds.contact_frames == 0.0 && bounds.slip_frames == 0.0
             ? "no error beyond rounding"
             : error_text(bounds);
}

std::string explain_choice(const SolverChoice& choice) {
  const auto is_best = [&](const SolverBounds& b) {
    return b.solver == choice.solver && b.oversample == choice.oversample;
  };
  const auto best = std::find_if(choice.candidates.begin(), choice.candidates.end(), is_best);
  if (best == choice.candidates.end()) return "";
  auto text = fmt::format("{}, {:.0f} multiplications per frame, ", described(*best), best->multiplications);
  if (best->limit != SolverBounds::Limit::None)
    text += against(*best) + warning(*best);
  else
    text += error_text(*best);
  for (const auto* other : cheaper(choice, *best))
    text += fmt::format("\n  not {}: {:.0f} multiplications per frame, {}", described(*other),
                        other->multiplications, against(*other));
  return text;
}

}  // namespace tactus
