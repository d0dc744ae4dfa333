#include "engine/study/stability/models/nonlinearities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tactus {
namespace {

const char* const kAllSteepest = "nonlinearities at their largest slope";

bool is_linear(const Operator& type, const Operands& operands) {
  switch (type.small_signal) {
    case SmallSignal::Linear:
      return true;
    case SmallSignal::Product:
      return operands.moving() < 2;
    case SmallSignal::Quotient:
      return !operands.moves[1];
    default:
      return false;
  }
}

/// The nonlinearities of one signal, and the operating points to analyse.
struct Group {
  PlanSignal source;
  std::vector<const Nonlinearity*> laws = {};
  struct Choice {
    std::string path;
    double to = 0;
    const char* where = "at its largest slope";
  };
  std::vector<Choice> choices = {};

  /// Whether every law is as steep at the displacement `there` as at `here`.
  bool serves(double there, double here) const {
    return std::ranges::all_of(
        laws, [&](const Nonlinearity* law) { return law->answer(there) >= law->answer(here) * (1 - 1e-9); });
  }

  void offer(Choice choice) {
    const auto replaces = [&](const Choice& other) { return serves(other.to, choice.to); };
    if (std::ranges::any_of(choices, replaces)) return;
    std::erase_if(choices, [&](const Choice& other) { return serves(choice.to, other.to); });
    choices.push_back(std::move(choice));
  }

  /// The steepest point of each, that of their sum, and where slopes are others.
  void choose() {
    offer_steepest();
    for (const auto* law : laws)
      for (const double to : law->elsewhere)
        if (std::ranges::none_of(choices, [&](const Choice& other) { return alike(other.to, to); }))
          choices.push_back({law->path, to, "at another slope"});
  }

  /// Whether every law has the same slope at both.
  bool alike(double one, double other) const {
    return std::ranges::all_of(laws, [&](const Nonlinearity* law) {
      const auto& slope = law->slope ? law->slope : law->answer;
      const double a = slope(one), b = slope(other);
      return std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b));
    });
  }

  void offer_steepest() {
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

std::vector<Group> groups_of(const std::vector<Nonlinearity>& laws) {
  std::vector<Group> groups;
  for (const auto& law : laws) {
    auto group = std::ranges::find_if(groups, [&](const auto& g) { return g.source == law.source; });
    if (group == groups.end()) group = groups.insert(group, Group{.source = law.source});
    group->laws.push_back(&law);
  }
  for (auto& group : groups) group.choose();
  return groups;
}

/// Every point so far with each of the group's; it is named only if there are several.
std::vector<OperatingPoint> with(const std::vector<OperatingPoint>& places, const Group& group) {
  std::vector<OperatingPoint> further;
  for (const auto& place : places)
    for (const auto& choice : group.choices) {
      auto& made = further.emplace_back(place);
      made.moved[group.source] = choice.to;
      if (group.choices.size() > 1)
        made.name += fmt::format("{}'{}' {}", made.name.empty() ? "" : ", ", choice.path, choice.where);
    }
  return further;
}

/// Each group's points alone, the others at rest; then all at their steepest.
std::vector<OperatingPoint> one_by_one(const std::vector<Group>& groups) {
  std::vector<OperatingPoint> places;
  for (const auto& group : groups)
    for (const auto& choice : group.choices) {
      if (places.size() == kMostPlaces) break;
      auto& made = places.emplace_back(OperatingPoint{fmt::format("'{}' {}", choice.path, choice.where), {}});
      for (const auto& other : groups) made.moved[other.source] = 0.0;
      made.moved[group.source] = choice.to;
    }
  places.push_back({kAllSteepest, {}, false});
  return places;
}

}  // namespace

std::optional<double> slope_of(const Operator& type, const Operands& operands, int which, bool touched) {
  if (type.slope == nullptr || (type.small_signal == SmallSignal::Choice && which == 0)) return std::nullopt;
  if (type.small_signal == SmallSignal::Corner && touched) {
    // Of something that moves and something that does not, the moving one limits when touched; of two that
    // move, the one that does so now.
    const bool one_moves = type.operands == 2 && operands.moving() == 1;
    if (one_moves) return operands.moves[index(which)] ? 1 : 0;
    if (type.operands == 1 && operands.at[0] == 0) return 1;
  }
  const double slope = type.slope(operands.at, which);
  return std::isfinite(slope) ? std::optional{slope} : std::nullopt;
}

bool is_spring(const NodeType& type, std::size_t input, std::size_t output) {
  return type.stateless && type.inputs[input].unit == "m" && type.outputs[output].unit == "N";
}

double answer_at(const Node& node, const NodeType& type, const std::vector<double>& at,
                 const std::vector<bool>& moves) {
  double sum = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!moves[i]) continue;
    const double slope = node.response(static_cast<int>(i), 0, 1.0, at).value_or(0.0).real();
    sum += is_spring(type, i, 0) ? std::max(0.0, -slope) : std::abs(slope);
  }
  return std::isfinite(sum) ? sum : 0;
}

PlanSignal choice_at(PlanSignal out) {
  constexpr int kNoPort = 1000;
  out.port = kNoPort;
  return out;
}

std::vector<double> places_of_slopes(const std::function<double(double)>& slope, double but,
                                     const std::vector<double>& middles) {
  constexpr int kPerDecade = 4;
  constexpr std::size_t kMostLines = 5;
  std::vector<std::pair<double, double>> found;  // slope, place
  const auto note = [&](double at) {
    const double value = slope(at);
    if (!std::isfinite(value)) return;
    const auto close = [&](const auto& other) {
      return std::abs(other.first - value) <= 1e-6 * std::max(std::abs(other.first), std::abs(value));
    };
    if (std::ranges::none_of(found, close)) found.emplace_back(value, at);
  };
  note(0.0);
  note(but);
  const auto known = found.size();
  for (const double middle : middles)
    for (int step = -6 * kPerDecade; step <= 3 * kPerDecade; ++step)
      for (const double side : {-1.0, 1.0})
        note(middle + side * std::pow(10.0, step / static_cast<double>(kPerDecade)));
  std::vector<std::pair<double, double>> others(found.begin() + static_cast<std::ptrdiff_t>(known),
                                                found.end());
  if (found.size() > kMostLines) others = {std::ranges::min(others), std::ranges::max(others)};
  std::vector<double> places{0.0};
  for (const auto& [value, at] : others) places.push_back(at);
  return places;
}

Summit summit(const std::function<double(double)>& height, double start, const std::vector<double>& middles) {
  Summit best{start, height(start)};
  const auto rises = [&](double at) {
    const double found = height(at);
    if (found <= best.height * (1 + 1e-9)) return false;
    best = {at, found};
    return true;
  };
  constexpr int kPerDecade = 12;
  double stride = 0;
  for (const double middle : middles)
    for (int step = -6 * kPerDecade; step <= 3 * kPerDecade; ++step)
      for (const double side : {-1.0, 1.0}) {
        const double away = std::pow(10.0, step / static_cast<double>(kPerDecade));
        if (rises(middle + side * away)) stride = 0.1 * away;
      }
  // Between the neighbours of the highest of these places, 0.2 of its distance away; what rises for ever (a
  // product) is not followed beyond.
  const double low = best.at - 2 * stride, high = best.at + 2 * stride;
  for (int halved = 0; stride > 0 && halved < 40;) {
    const double up = best.at + stride, down = best.at - stride;
    if (!(up <= high && rises(up)) && !(down >= low && rises(down))) stride *= 0.5, ++halved;
  }
  return best;
}

SteepPlace steepest(const Node& node, const NodeType& type, const std::vector<double>& at,
                    const std::vector<bool>& moves) {
  const double rest = answer_at(node, type, at, moves);
  SteepPlace best{at, rest};
  for (std::size_t i = 0; i < at.size(); ++i) {
    if (!moves[i]) continue;
    if (best.input < 0) best.input = static_cast<int>(i);
    auto there = at;
    const auto height = [&](double value) {
      there[i] = value;
      const double found = answer_at(node, type, there, moves);
      best.nonlinear |= std::abs(found - rest) > 1e-6 * rest;
      return found;
    };
    std::vector<double> middles{at[i], 0.0};
    for (std::size_t other = 0; other < at.size(); ++other)
      if (!moves[other]) middles.push_back(at[other]);
    const auto found = summit(height, at[i], middles);
    if (found.height <= best.answer * (1 + 1e-9)) continue;
    best.at = at;
    best.at[i] = found.at;
    best.answer = found.height;
    best.input = static_cast<int>(i);
  }
  return best;
}

Derived AffineMaps::of(const PlanSignal& signal) const {
  const auto found = known_.find(signal);
  return found == known_.end() ? Derived{signal, 1} : found->second;
}

void AffineMaps::note(const PlanSignal& out, const Operator& type,
                      const std::array<PlanSignal, kMostOperands>& in, const Operands& operands) {
  if (!is_linear(type, operands)) return;
  Derived derived{{}, 0};
  for (int k = 0; k < type.operands; ++k) {
    if (!operands.moves[index(k)]) continue;
    const auto from = of(in[index(k)]);
    if (derived.source.plan != nullptr && derived.source != from.source) return;
    derived.source = from.source;
    derived.slope += from.slope * slope_of(type, operands, k, false).value_or(0);
  }
  if (derived.source.plan != nullptr) known_[out] = derived;
}

std::optional<double> AffineMaps::moved(const PlanSignal& signal, const Displaced& moved) const {
  const auto from = of(signal);
  const auto found = moved.find(from.source);
  return found == moved.end() ? std::nullopt : std::optional{from.slope * found->second};
}

std::optional<Nonlinearity> corner(const std::string& path, const Operator& type, const Operands& operands,
                                   int which, const Derived& from) {
  if (type.small_signal != SmallSignal::Corner || operands.moving() > 1) return std::nullopt;
  const auto slope = [=, &type](double moved) {
    auto there = operands;
    there.at[index(which)] += from.slope * moved;
    return slope_of(type, there, which, false).value_or(0);
  };
  const auto answer = [slope](double moved) { return std::abs(slope(moved)); };
  const double here = operands.at[index(which)];
  const double edge = type.operands == 1 ? 0 : operands.at[index(1 - which)];
  const double to_edge = (edge - here) / from.slope;
  const double little = std::max(1e-6 * std::abs(to_edge), 1e-9);
  double to = 0;
  for (const double beyond : {to_edge + little, to_edge - little})
    if (answer(beyond) > answer(to)) to = beyond;
  Nonlinearity law{path, from.source, to, answer, slope};
  law.elsewhere = {0.0, to_edge - little, to_edge + little};
  return law;
}

Nonlinearity curve(const std::string& path, const Operator& type, const Operands& operands,
                   const Derived& from) {
  const auto slope = [=, &type](double moved) {
    auto there = operands;
    there.at[0] += from.slope * moved;
    return slope_of(type, there, 0, false).value_or(0);
  };
  const auto answer = [slope](double moved) { return std::abs(slope(moved)); };
  const std::vector<double> middles{0.0, -operands.at[0] / from.slope};
  Nonlinearity law{path, from.source, summit(answer, 0, middles).at, answer, slope};
  law.elsewhere = places_of_slopes(slope, law.to, middles);
  return law;
}

Nonlinearity choice(const std::string& path, const PlanSignal& out, const Operands& operands) {
  const auto always = [](double) { return 1.0; };
  Nonlinearity law{path, choice_at(out), operands.at[0] != 0 ? 1.0 : 2.0, always,
                   [](double operand) { return operand; }};
  law.elsewhere = {1.0, 2.0};
  return law;
}

Nonlinearity corner_of_two(const std::string& path, const PlanSignal& out, const Operator& type,
                           const Operands& operands, const std::array<Derived, 2>& from) {
  if (from[0].source != from[1].source) {
    const auto always = [](double) { return 1.0; };
    Nonlinearity law{path, choice_at(out), 0.0, always, [](double choice) { return choice; }};
    law.elsewhere = {1.0};
    return law;
  }
  const auto slope = [=, &type](double moved) {
    auto there = operands;
    for (std::size_t k = 0; k < from.size(); ++k) there.at[k] += from[k].slope * moved;
    return slope_of(type, there, 0, false) != 0.0 ? from[0].slope : from[1].slope;
  };
  const double apart = from[0].slope - from[1].slope;
  const double edge = apart == 0.0 ? 0.0 : (operands.at[1] - operands.at[0]) / apart;
  const double little = std::max(1e-6 * std::abs(edge), 1e-9);
  Nonlinearity law{path, from[0].source, edge + little,
                   [slope](double moved) { return std::abs(slope(moved)); }, slope};
  law.elsewhere = {0.0, edge - little, edge + little};
  return law;
}

std::vector<OperatingPoint> operating_points(const std::vector<Nonlinearity>& laws) {
  const auto groups = groups_of(laws);
  std::size_t count = 1;
  for (const auto& group : groups) count = std::min(count * group.choices.size(), kMostPlaces + 1);
  if (count > kMostPlaces) return one_by_one(groups);
  std::vector<OperatingPoint> places(1);
  for (const auto& group : groups) places = with(places, group);
  if (places.size() == 1) places.front().name = kAllSteepest;
  return places;
}

}  // namespace tactus
