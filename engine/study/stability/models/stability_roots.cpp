#include "engine/study/stability/models/stability_roots.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/core/find_root.h"
#include "engine/core/units.h"

namespace tactus {
namespace {

using Complex = std::complex<double>;

// No more than so many points, whatever the graph does: what turns faster than that is rounding.
constexpr std::size_t kMostPoints = 400'000;
constexpr int kPointsOfDelay = 4;  // of each frame, on half a circle
// Factors outside these are no margins any more.
constexpr double kLeastFactor = 1e-6, kMostFactor = 1e6;
// An L below this is rounding: it is the difference of numbers near 1.
constexpr double kLeastGain = 1e-9;

/// f with what goes through one cut times `factor`:  f_k = f (1 - k L) / (1 - L).
Complex scaled(Complex f, Complex alone, double factor) {
  return factor == 1.0 ? f : f * (1.0 - factor * alone) / (1.0 - alone);
}

/// Hands on samples in the order of their `radians`, with further ones from `sample` halfway between two that
/// are `apart`. `ahead`: the first ones, the last of them first; `take` returns where it keeps what it is
/// given.
template <class Sample>
void take_refined(std::vector<Sample> ahead, const auto& sample, const auto& apart, const auto& take) {
  constexpr double kClosest = 1e-13;
  const Sample* before = nullptr;
  while (!ahead.empty()) {
    const auto& next = ahead.back();
    if (before != nullptr && next.radians - before->radians > kClosest &&
        apart(*before, next, ahead.size())) {
      ahead.push_back(sample(0.5 * (before->radians + next.radians)));
      continue;
    }
    before = &take(std::move(ahead.back()));
    ahead.pop_back();
  }
}

/// What comes back to `drive` alone, with what goes through `cut` times `factor`.
Complex returned_to(Eigen::MatrixXcd returned, int drive, int cut, double factor) {
  returned.col(cut) *= factor;
  return LoopGroup::loops(returned).alone[static_cast<std::size_t>(drive)];
}

}  // namespace

void sort_by_growth(std::vector<LoopRoot>& roots, std::size_t most) {
  std::ranges::sort(roots, std::greater{}, &LoopRoot::growth_per_s);
  if (roots.size() > most) roots.resize(most);
}

LoopScan::LoopScan(const LoopGroup& group, Hertz rate, For what)
    : group_(group),
      rate_(rate / group.frames()),
      what_(what),
      radius_(std::exp(kSlowestGrowth / rate_.value)) {
  constexpr double kQuick = 0.5;  // what is gone within a few frames is no mode
  const auto& graph = group.graph();
  for (std::size_t n = 0; n < graph.networks.size(); ++n)
    if (group.contains(static_cast<int>(n)))
      for (const auto& mode : graph.networks[n]->modes)
        if (std::abs(mode.pole) > kQuick) poles_.push_back(std::pow(mode.pole, group.frames()));
  refine(first_points());
}

double LoopScan::hertz(double radians) const {
  constexpr double kNone = 1e-9;  // the first point above 0
  return std::abs(radians) < kNone ? 0 : radians * rate_.value / (2 * kPi);
}

LoopScan::Sample LoopScan::sample(double radians) const {
  const auto returned = group_.returned(std::polar(radius_, radians));
  if (what_ == For::Counting) return {radians, LoopGroup::characteristic(returned), {}};
  auto loops = LoopGroup::loops(returned);
  return {radians, loops.f, std::move(loops.alone)};
}

/// Points where a node rings, as a string does, so close that none of its resonances lies between two of
/// them: by bisection on 1 / H, which has no peaks. What turns without becoming small is a delay.
void LoopScan::add_ringing(const LinearEdge& edge, int base, std::vector<double>& points) const {
  constexpr std::size_t kMostOfNode = 20'000;
  constexpr double kLow = 0.7;
  struct Place {
    double radians;
    Complex inverse;
  };
  const double radius = std::pow(radius_, edge.divisor);
  const auto place = [&](double radians) {
    const auto gain =
        edge.node->response(edge.input, edge.output, std::polar(radius, edge.divisor * radians), edge.at);
    return Place{radians, gain && *gain != 0.0 ? 1.0 / *gain : Complex{}};
  };
  std::vector<Place> ahead;
  double highest = 0;
  for (int i = base; i >= 0; --i) {
    ahead.push_back(place(kPi * i / base));
    highest = std::max(highest, std::abs(ahead.back().inverse));
  }
  const auto add = [&](double radians) {
    points.push_back(radians);
    return place(radians);
  };
  const auto apart = [&](const Place& a, const Place& b, std::size_t left) {
    const double low = std::min(std::abs(a.inverse), std::abs(b.inverse));
    return low < kLow * highest && std::abs(b.inverse - a.inverse) > 0.5 * low && left < kMostOfNode &&
           points.size() < kMostPoints;
  };
  Place before{};
  take_refined(std::move(ahead), add, apart,
               [&](const Place& taken) -> const Place& { return before = taken; });
}

/// Eight for each turn of the delays, more towards 0 Hz and around what rings in networks and nodes.
std::vector<double> LoopScan::first_points() const {
  const int even =
      std::clamp(kPointsOfDelay * group_.delay_frames(), 1024, kPointsOfDelay * LoopGroup::kLongestDelay);
  std::vector<double> points;
  for (int i = 0; i <= even; ++i) points.push_back(kPi * i / even);
  for (int i = 0; i < 160; ++i) points.push_back(std::pow(10.0, -9.0 + i / 20.0));
  for (const auto& pole : poles_) {
    const double at = std::arg(pole);
    if (at <= 0) continue;
    for (int i = -90; i <= -20; ++i)
      for (const double side : {-1.0, 1.0}) points.push_back(at + side * std::pow(10.0, i / 10.0));
  }
  if (group_.frames() == 1) {
    // The lowest string, 20 Hz at 48 kHz, has its partials 3.5 points apart.
    constexpr int kOfOne = 4096, kOfAll = 32 * kOfOne;
    const auto& edges = group_.graph().edges;
    const auto rings = [&](std::size_t e) {
      return edges[e].kind == LinearEdge::Kind::Node && edges[e].node != nullptr && !edges[e].constant;
    };
    const auto nodes = std::ranges::count_if(group_.edges(), rings);
    for (const auto e : group_.edges())
      if (rings(e)) add_ringing(edges[e], std::min<int>(kOfOne, kOfAll / static_cast<int>(nodes)), points);
  }
  std::erase_if(points, [](double p) { return p < 0 || p > kPi; });
  std::ranges::sort(points);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

bool LoopScan::smooth(const Sample& a, const Sample& b) const {
  const double step = std::abs(a.f - b.f);
  if (step > 0.5 * std::min(std::abs(a.f), std::abs(b.f))) return false;
  for (std::size_t c = 0; c < a.alone.size(); ++c)
    if (std::abs(a.alone[c] - b.alone[c]) >
        0.5 * (0.2 * heights_[c] + std::min(std::abs(a.alone[c]), std::abs(b.alone[c]))))
      return false;
  return true;
}

void LoopScan::refine(std::vector<double> points) {
  std::vector<Sample> ahead;
  for (auto p = points.rbegin(); p != points.rend(); ++p) ahead.push_back(sample(*p));
  heights_.assign(group_.cuts().size(), kLeastGain);
  for (const auto& s : ahead)
    for (std::size_t c = 0; c < s.alone.size(); ++c)
      heights_[c] = std::max(heights_[c], std::min(1.0, std::abs(s.alone[c])));
  const auto apart = [&](const Sample& a, const Sample& b, std::size_t left) {
    if (smooth(a, b)) return false;
    complete_ = complete_ && samples_.size() + left < kMostPoints;
    return complete_;
  };
  take_refined(
      std::move(ahead), [&](double radians) { return sample(radians); }, apart,
      [&](Sample&& taken) -> const Sample& { return samples_.emplace_back(std::move(taken)); });
}

template <class Value>
int LoopScan::turns(const Value& value) const {
  double turned = 0;
  Complex before = 0;
  for (const auto& s : samples_) {
    const Complex f = value(s);
    if (before != 0.0 && f != 0.0) turned += std::arg(f / before);
    before = f;
  }
  return static_cast<int>(std::lround(-turned / kPi));
}

int LoopScan::growing() const {
  return turns([](const Sample& s) { return s.f; });
}

int LoopScan::growing_with(int cut, double factor) const {
  return turns([&](const Sample& s) { return scaled(s.f, s.alone[static_cast<std::size_t>(cut)], factor); });
}

// ---- margins

std::optional<LoopScan::Crossing> LoopScan::crossing_between(double a, double b, int cut) const {
  const auto alone = [&](double radians) { return sample(radians).alone[static_cast<std::size_t>(cut)]; };
  const auto found = find_zero([&](double radians) { return alone(radians).imag(); }, a, b, 1e-15);
  const auto near = alone(found.near), far = found.f_near == 0 ? near : alone(found.far);
  const auto at = 0.5 * (near + far);
  // Through a pole the sign changes as well, at infinity.
  if (!(at.real() > 0) || std::abs(near - far) > 0.1 * std::abs(at)) return std::nullopt;
  return Crossing{1.0 / at.real(), found.near};
}

/// Where L is real and positive: with a factor of 1 / L a root lies there.
std::vector<LoopScan::Crossing> LoopScan::crossings(int cut) const {
  const auto c = static_cast<std::size_t>(cut);
  std::vector<Crossing> found;
  for (const auto* end : {&samples_.front(), &samples_.back()})
    if (end->alone[c].real() > 0) found.push_back({1.0 / end->alone[c].real(), end->radians});
  for (std::size_t i = 1; i < samples_.size(); ++i) {
    const auto a = samples_[i - 1].alone[c], b = samples_[i].alone[c];
    if ((a.imag() > 0) == (b.imag() > 0) || (a.real() <= 0 && b.real() <= 0)) continue;
    if (std::abs(a) < kLeastGain && std::abs(b) < kLeastGain) continue;
    if (const auto at = crossing_between(samples_[i - 1].radians, samples_[i].radians, cut))
      found.push_back(*at);
  }
  std::erase_if(found, [](const auto& x) { return x.factor < kLeastFactor || x.factor > kMostFactor; });
  std::ranges::sort(found, {}, &Crossing::factor);
  return found;
}

/// The largest factor below which no root grows.
void LoopScan::find_border(int cut, const std::vector<Crossing>& crossings, CutMargin& margin) const {
  if (growing() == 0) {
    margin.border = margin.up;
    margin.border_hz = margin.up_hz;
    return;
  }
  margin.border = 0;
  constexpr double kJustBelow = 0.999;
  double grows_at = 1;  // thousands of turns of a long delay cross at nearly the same factor
  for (auto x = crossings.rbegin(); x != crossings.rend(); ++x) {
    if (x->factor >= grows_at) continue;
    grows_at = kJustBelow * x->factor;
    if (growing_with(cut, grows_at) > 0) continue;
    margin.border = x->factor;
    margin.border_hz = hertz(x->radians);
    return;
  }
}

/// arg L / w where |L| passes 1: so much more delay turns L to 1.
double LoopScan::delay_margin(int cut) const {
  const auto c = static_cast<std::size_t>(cut);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < samples_.size(); ++i) {
    const auto a = samples_[i - 1].alone[c], b = samples_[i].alone[c];
    const double la = std::abs(a), lb = std::abs(b);
    if ((la > 1) == (lb > 1) || samples_[i - 1].radians <= 0) continue;
    const double share = (1 - la) / (lb - la);
    const auto at = a + share * (b - a);
    const double w = samples_[i - 1].radians + share * (samples_[i].radians - samples_[i - 1].radians);
    double turn = std::arg(at);
    if (turn < 0) turn += 2 * kPi;
    least = std::min(least, turn / w / rate_.value);
  }
  return least;
}

CutMargin LoopScan::margin(int cut) const {
  const auto c = static_cast<std::size_t>(cut);
  CutMargin margin;
  for (const auto& s : samples_)
    if (std::abs(s.alone[c]) > margin.peak)
      margin.peak = std::abs(s.alone[c]), margin.peak_hz = hertz(s.radians);
  const auto found = crossings(cut);
  for (const auto& x : found) {
    if (x.factor > 1 && x.factor < margin.up) margin.up = x.factor, margin.up_hz = hertz(x.radians);
    if (x.factor <= 1) margin.down = x.factor;
  }
  find_border(cut, found, margin);
  margin.more_delay_s = growing() == 0 ? delay_margin(cut) : 0;
  return margin;
}

// ---- roots

/// Newton's method on f(z) times (z - p) for every pole p of the networks in the loop, as a function of s =
/// ln z: without its poles f is no obstacle, even where root and pole nearly meet.
std::optional<LoopRoot> LoopScan::newton(Complex s, int cut, double factor) const {
  const auto f = [&](Complex at) {
    const auto returned = group_.returned(std::exp(at));
    if (factor == 1.0) return LoopGroup::characteristic(returned);
    const auto loops = LoopGroup::loops(returned);
    return scaled(loops.f, loops.alone[static_cast<std::size_t>(cut)], factor);
  };
  constexpr double kZero = 1e-4;  // what is no root, but a pole that the loop does not see, leaves more
  for (int i = 0; i < 60; ++i) {
    const double h = 1e-7 * std::max(std::abs(s), 1e-7);
    const auto value = f(s), z = std::exp(s);
    auto turn = (f(s + h) - f(s - h)) / (2 * h * value);
    for (const auto& pole : poles_) turn += z / (z - pole);
    if (turn == 0.0 || !std::isfinite(std::abs(turn))) return std::nullopt;
    auto step = 1.0 / turn;
    const double most = 0.2 * std::abs(s) + 1e-6;
    if (std::abs(step) > most) step *= most / std::abs(step);
    s -= step;
    if (!(std::abs(s.real()) < 1)) return std::nullopt;
    if (std::abs(step) > 1e-11 * std::abs(s) + 1e-15) continue;
    if (!(std::abs(f(s)) < kZero)) return std::nullopt;
    return LoopRoot{std::abs(hertz(s.imag())), s.real() * rate_.value};
  }
  return std::nullopt;
}

/// Valleys of |f| on the circle, the deepest first, and the poles that the roots came from, beside each of
/// them.
std::vector<Complex> LoopScan::first_guesses(std::size_t most) const {
  const auto depth = [&](std::size_t i) { return std::abs(samples_[i].f); };
  std::vector<std::size_t> valleys;
  for (std::size_t i = 1; i + 1 < samples_.size(); ++i)
    if (depth(i) <= depth(i - 1) && depth(i) <= depth(i + 1)) valleys.push_back(i);
  std::ranges::sort(valleys, {}, depth);
  if (valleys.size() > most) valleys.resize(most);
  valleys.insert(valleys.end(), {0, samples_.size() - 1});
  std::vector<Complex> guesses;
  for (const auto i : valleys) guesses.emplace_back(std::log(radius_), samples_[i].radians);
  for (const auto& pole : poles_) {
    if (pole.imag() < 0) continue;
    const auto s = std::log(pole);
    guesses.push_back(s + Complex{0.5, 0.5} * std::max(std::abs(s.real()), 1e-6));
  }
  return guesses;
}

std::vector<LoopRoot> LoopScan::roots(std::size_t most) const {
  std::vector<LoopRoot> roots;
  for (const auto& guess : first_guesses(8 * most)) {
    const auto root = newton(guess, 0, 1.0);
    if (!root) continue;
    const bool known = std::ranges::any_of(roots, [&](const auto& r) {
      return std::abs(r.frequency_hz - root->frequency_hz) < 1e-6 * (1 + r.frequency_hz) &&
             std::abs(r.growth_per_s - root->growth_per_s) < 1e-4 * (1 + std::abs(r.growth_per_s));
    });
    if (!known) roots.push_back(*root);
  }
  sort_by_growth(roots, most);
  return roots;
}

std::optional<LoopRoot> LoopScan::root_near(double hertz, int cut, double factor) const {
  return newton({0.0, 2 * kPi * hertz / rate_.value}, cut, factor);
}

// ---- passivity

namespace {

double damping_of(const std::function<Complex(Complex)>& mobility, double step) {
  double least = std::numeric_limits<double>::infinity();
  for (const double hertz : {1.0, 2.0, 5.0, 10.0}) {
    const double radians = 2 * kPi * hertz * step;
    // The held force comes half a step late.
    const auto g = mobility(std::polar(1.0, radians)) * std::polar(1.0, radians / 2);
    least = std::min(least, (1.0 / (Complex{0, 2 * kPi * hertz} * g)).real());
  }
  return least;
}

struct PassivityPoint {
  double radians;
  Eigen::MatrixXcd returned;
  Complex mobility;
};

}  // namespace

PassiveLimit passive_limit(const LoopGroup& group, int drive, int cut,
                           const std::function<Complex(Complex)>& mobility, Hertz rate) {
  constexpr int kPoints = 400;
  const double step = 1 / rate.value, damping = damping_of(mobility, step), lowest = 2 * kPi * step;  // 1 Hz
  std::vector<PassivityPoint> points;
  for (int i = 0; i <= kPoints; ++i) {
    const double radians = lowest * std::pow(kPi / lowest, static_cast<double>(i) / kPoints);
    const auto z = std::polar(1.0, radians);
    points.push_back({radians, group.returned(z), mobility(z)});
  }
  const auto passive_with = [&](double factor) {
    return std::ranges::all_of(points, [&](const PassivityPoint& point) {
      const auto h = -returned_to(point.returned, drive, cut, factor) / point.mobility;
      const auto held = (1.0 - std::polar(1.0, -point.radians)) * h;
      return std::max(0.0, step / 2 / (1 - std::cos(point.radians)) * held.real()) <= damping;
    });
  };
  double low = 1e-6, high = 1e6;
  if (!passive_with(low)) return {damping, 0};
  if (passive_with(high)) return {damping, std::numeric_limits<double>::infinity()};
  while (high > 1.0001 * low) {
    const double middle = std::sqrt(low * high);
    (passive_with(middle) ? low : high) = middle;
  }
  return {damping, low};
}

}  // namespace tactus
