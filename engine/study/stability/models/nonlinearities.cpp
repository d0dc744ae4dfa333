#include "engine/study/stability/models/nonlinearities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

const char* const kAllSteepest = "laws where they are steepest";

bool is_linear(Expression::Op op, const Operands& operands) {
  switch (op) {
    case Expression::Op::Negate:
    case Expression::Op::Add:
    case Expression::Op::Subtract:
      return true;
    case Expression::Op::Multiply:
      return !operands.moves[0] || !operands.moves[1];
    case Expression::Op::Divide:
      return !operands.moves[1];
    default:
      return false;
  }
}

/// The laws that one signal moves, and the places that are worth a look.
struct Group {
  PlanSignal source;
  std::vector<const Nonlinearity*> laws = {};
  struct Choice {
    std::string path;
    double to = 0;
  };
  std::vector<Choice> choices = {};

  /// Whether every law answers as much where the source has moved by `there` as where it has moved by `here`.
  bool serves(double there, double here) const {
    return std::all_of(laws.begin(), laws.end(), [&](const Nonlinearity* law) {
      return law->answer(there) >= law->answer(here) * (1 - 1e-9);
    });
  }

  void offer(Choice choice) {
    const auto replaces = [&](const Choice& other) { return serves(other.to, choice.to); };
    if (std::any_of(choices.begin(), choices.end(), replaces)) return;
    std::erase_if(choices, [&](const Choice& other) { return serves(choice.to, other.to); });
    choices.push_back(std::move(choice));
  }

  /// Where each answers most, and where all of them together do.
  void choose() {
    for (const auto* law : laws) offer({law->path, law->to});
    if (choices.size() < 2) return;
    const auto together = [&](double to) {
      double sum = 0;
      for (const auto* law : laws) sum += law->answer(to);
      return sum;
    };
    std::vector<double> middles;
    std::string path;
    for (const auto& choice : choices) {
      middles.push_back(choice.to);
      path += (path.empty() ? "" : "' with '") + choice.path;
    }
    offer({path, summit(together, middles.front(), middles).at});
  }
};

std::vector<Group> groups_of(const std::vector<Nonlinearity>& bends) {
  std::vector<Group> groups;
  for (const auto& bend : bends) {
    auto group =
        std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.source == bend.source; });
    if (group == groups.end()) group = groups.insert(group, Group{.source = bend.source});
    group->laws.push_back(&bend);
  }
  for (auto& group : groups) group.choose();
  return groups;
}

/// Every place so far with each of the group's; it is named only where there is a choice.
std::vector<OperatingPoint> with(const std::vector<OperatingPoint>& places, const Group& group) {
  std::vector<OperatingPoint> further;
  for (const auto& place : places)
    for (const auto& choice : group.choices) {
      auto& made = further.emplace_back(place);
      made.moved[group.source] = choice.to;
      if (group.choices.size() > 1)
        made.name += fmt::format("{}where '{}' is steepest", made.name.empty() ? "" : ", ", choice.path);
    }
  return further;
}

}  // namespace

Derived AffineMaps::of(const PlanSignal& signal) const {
  const auto found = known_.find(signal);
  return found == known_.end() ? Derived{signal, 1} : found->second;
}

void AffineMaps::note(const PlanSignal& out, Expression::Op op, const std::array<PlanSignal, 2>& in,
                      const Operands& operands) {
  if (!is_linear(op, operands)) return;
  Derived derived{{}, 0};
  for (int k = 0; k < operands_of(op); ++k) {
    if (!operands.moves[static_cast<std::size_t>(k)]) continue;
    const auto from = of(in[static_cast<std::size_t>(k)]);
    if (derived.source.plan != nullptr && derived.source != from.source) return;
    derived.source = from.source;
    derived.slope += from.slope * slope_of(op, operands, k, false);
  }
  if (derived.source.plan != nullptr) known_[out] = derived;
}

std::optional<double> AffineMaps::moved(const PlanSignal& signal, const Displaced& moved) const {
  const auto from = of(signal);
  const auto found = moved.find(from.source);
  return found == moved.end() ? std::nullopt : std::optional{from.slope * found->second};
}

std::optional<Nonlinearity> corner(const std::string& path, Expression::Op op, const Operands& operands,
                                   int which, const Derived& from) {
  const bool bends = op == Expression::Op::Min || op == Expression::Op::Max || op == Expression::Op::Abs;
  if (!bends || (operands.moves[0] && operands.moves[1])) return std::nullopt;
  const auto answer = [=](double moved) {
    auto there = operands;
    (which == 0 ? there.a : there.b) += from.slope * moved;
    return std::abs(slope_of(op, there, which, false));
  };
  const double here = which == 0 ? operands.a : operands.b;
  const double edge = op == Expression::Op::Abs ? 0 : which == 0 ? operands.b : operands.a;
  const double to_edge = (edge - here) / from.slope;
  const double little = std::max(1e-6 * std::abs(to_edge), 1e-9);
  double to = 0;
  for (const double beyond : {to_edge + little, to_edge - little})
    if (answer(beyond) > answer(to)) to = beyond;
  return Nonlinearity{path, from.source, to, answer};
}

std::vector<OperatingPoint> operating_points(const std::vector<Nonlinearity>& bends) {
  const auto groups = groups_of(bends);
  std::size_t count = 1;
  for (const auto& group : groups) count = std::min(count * group.choices.size(), kMostPlaces + 1);
  if (count > kMostPlaces) return {{kAllSteepest, {}}};
  std::vector<OperatingPoint> places(1);
  for (const auto& group : groups) places = with(places, group);
  if (places.size() == 1) places.front().name = kAllSteepest;
  return places;
}

}  // namespace tactus
