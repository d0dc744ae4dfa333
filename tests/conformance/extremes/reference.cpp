#include "tests/conformance/extremes/reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace tactus::test {
namespace {

using Real = long double;
constexpr Real kPi = std::numbers::pi_v<long double>;
const Real kOpen = std::numeric_limits<Real>::quiet_NaN();

/// One value a frame.
Expected frame_by_frame(std::size_t frames, const std::function<Real(std::size_t)>& value,
                        Real tolerance = 1e-9L) {
  Expected expected{Series(frames), tolerance};
  for (std::size_t n = 0; n < frames; ++n) expected.out[n] = value(n);
  return expected;
}

/// e^(-1 / (rate time)), 0 for a time of 0.
Real keep(Real rate, Real time) { return time > 0 ? std::exp(-1 / (rate * time)) : 0; }

struct Rise {
  bool high = false;
  bool operator()(Real trigger) {
    const bool was = high;
    high = trigger >= 0.5L;
    return high && !was;
  }
};

Expected sine(const Given& g, std::size_t frames) {
  Real turns = 0, uncertain = 0;
  auto expected = frame_by_frame(frames, [&](std::size_t n) {
    const Real step = g.at("frequency", n) / g.rate;
    const Real angle = 2 * kPi * turns + g.at("phase", n);
    turns += step;
    turns -= std::floor(turns);
    const bool open = uncertain + std::abs(g.at("phase", n)) * 1e-16L > 1e-11L;
    uncertain += (std::abs(step) + 1) * 2e-16L;
    return open ? kOpen : g.at("level", n) * std::sin(angle);
  });
  for (const auto level : g.in.at("level"))
    expected.rounding = std::max(expected.rounding, 1e-10L * std::abs(level));
  return expected;
}

Expected clip(const Given& g, std::size_t frames) {
  return frame_by_frame(frames, [&](std::size_t n) {
    return std::max(g.at("low", n), std::min(g.at("high", n), g.at("in", n)));
  });
}

Expected quantiser(const Given& g, std::size_t frames) {
  const bool nearest = !g.settings.contains("rounding") || g.settings.at("rounding") == "nearest";
  return frame_by_frame(frames, [&, nearest](std::size_t n) {
    const Real in = g.at("in", n), step = g.at("step", n), steps = step > 0 ? in / step : 0;
    if (step <= 0 || std::abs(steps) > 1e15L) return in;
    return step * (nearest ? std::rint(steps) : std::floor(steps));
  });
}

Expected slew(const Given& g, std::size_t frames) {
  Real last = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    last = std::clamp(g.at("in", n), last - g.at("fall", n) / g.rate, last + g.at("rise", n) / g.rate);
    return last;
  });
}

Expected hysteresis(const Given& g, std::size_t frames) {
  Real last = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    const Real half = g.at("width", n) / 2;
    last = std::clamp(last, g.at("in", n) - half, g.at("in", n) + half);
    return last;
  });
}

Expected envelope(const Given& g, std::size_t frames) {
  Real e = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    const Real r = std::abs(g.at("in", n));
    e += (1 - keep(g.rate, g.at(r > e ? "attack" : "release", n))) * (r - e);
    return e;
  });
}

Expected decay(const Given& g, std::size_t frames) {
  Rise rise;
  Real value = 0, age = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    if (rise(g.at("trigger", n))) value = g.at("level", n), age = 0;
    const Real length = g.at("length", n) * g.rate;
    if (length > 0 && age + 0.5L >= length) value = 0;
    const Real now = value;
    value *= keep(g.rate, g.at("time", n)), age += 1;
    return now;
  });
}

Expected adsr(const Given& g, std::size_t frames) {
  // An attack of whole frames ends one frame sooner or later, by rounding: what it decays in one frame.
  const Real frame = (1 - g.at("sustain", 0)) * (1 - keep(g.rate, g.at("decay", 0))) + 1e-9L;
  Real e = 0;
  bool high = false, attacking = false;
  return frame_by_frame(
      frames,
      [&](std::size_t n) {
        const bool gate = g.at("gate", n) >= 0.5L;
        attacking = gate && (attacking || !high);
        high = gate;
        const Real sustain = g.at("sustain", n), attack = g.at("attack", n) * g.rate;
        if (!gate)
          e *= keep(g.rate, g.at("release", n));
        else if (attacking)
          e = std::min<Real>(1, e + (attack > 1 ? 1 / attack : 1)), attacking = e < 1 - 1e-12L;
        else
          e = sustain + (e - sustain) * keep(g.rate, g.at("decay", n));
        return e;
      },
      frame);
}

/// Radians a frame of a cutoff, which filters take between 1e-6 and 0.49 of the rate.
Real radians(const Given& g, const char* port) {
  return 2 * kPi * std::clamp(g.at(port, 0) / g.rate, 1e-6L, 0.49L);
}

/// y = b0 x + b1 x1 + b2 x2 + a1 y1 + a2 y2. Poles at a very low cutoff are uncertain by 1e-16 / w^2.
Expected filtered(const Given& g, std::size_t frames, Real w, std::array<Real, 3> b, std::array<Real, 2> a) {
  Real x1 = 0, x2 = 0, y1 = 0, y2 = 0;
  return frame_by_frame(
      frames,
      [&](std::size_t n) {
        const Real x = g.at("in", n), y = b[0] * x + b[1] * x1 + b[2] * x2 + a[0] * y1 + a[1] * y2;
        x2 = x1, x1 = x, y2 = y1, y1 = y;
        return y;
      },
      std::max(1e-9L, 1e-15L / (w * w)));
}

Real matched_pole(Real w) {
  const Real c = 2 - std::cos(w);
  return c - std::sqrt(c * c - 1);
}

Expected one_pole(const Given& g, std::size_t frames) {
  const Real w = radians(g, "cutoff");
  if (g.settings.contains("form") && g.settings.at("form") == "matched") {
    const Real p = matched_pole(w);
    return filtered(g, frames, w, {1 - p, 0, 0}, {p, 0});
  }
  const Real t = std::tan(w / 2), p = (1 - t) / (1 + t);
  return filtered(g, frames, w, {(1 - p) / 2, (1 - p) / 2, 0}, {p, 0});
}

Expected dc_blocker(const Given& g, std::size_t frames) {
  const Real w = radians(g, "cutoff"), p = 1 / (1 + w);
  return filtered(g, frames, w, {p, -p, 0}, {p, 0});
}

Expected velocity(const Given& g, std::size_t frames) {
  const Real w = radians(g, "cutoff"), p = matched_pole(w);
  return filtered(g, frames, w, {(1 - p) * g.rate, -(1 - p) * g.rate, 0}, {p, 0});
}

Expected difference(const Given& g, std::size_t frames) {
  return frame_by_frame(
      frames, [&](std::size_t n) { return (g.at("in", n) - (n > 0 ? g.at("in", n - 1) : 0)) * g.rate; });
}

/// Of the analogue B / (s^2 + s/q + 1), bilinear, s = j at w.
Expected biquad(const Given& g, std::size_t frames, const char* corner, char shape) {
  const Real w = radians(g, corner), q = std::clamp(g.at("q", 0), 0.01L, 1000.0L);
  const Real alpha = std::sin(w) / (2 * q), c = std::cos(w), scale = 1 / (1 + alpha);
  std::array<Real, 3> b{alpha, 0, -alpha};
  if (shape == 'l') b = {(1 - c) / 2, 1 - c, (1 - c) / 2};
  if (shape == 'h') b = {(1 + c) / 2, -(1 + c), (1 + c) / 2};
  for (auto& x : b) x *= scale;
  return filtered(g, frames, w, b, {2 * c * scale, (alpha - 1) * scale});
}

/// The polynomial through the taps nearest to the place; below the middle of the taps none is newer than 0.
Expected delay(const Given& g, std::size_t frames) {
  const auto& word = g.settings.contains("interpolation") ? g.settings.at("interpolation") : "lagrange3";
  const int order = word == "none" ? 0 : word == "linear" ? 1 : word == "lagrange5" ? 5 : 3;
  const auto limit = [&](const char* key, Real otherwise) {
    return g.in.contains(key) ? g.at(key, 0) : otherwise;
  };
  Real wanted = std::clamp(g.at("time", 0), limit("min", 0), limit("max", 1e300L)) * g.rate;
  if (std::abs(wanted - std::rint(wanted)) < 1e-9L) wanted = std::rint(wanted);
  // Where the time is never below a frame, no tap is newer than a frame.
  const long long least = wanted >= 1 ? 1 : 0;
  const auto newest = std::max(least, order == 0 ? std::llround(std::floor(wanted + 0.5L))
                                                 : std::llround(std::floor(wanted)) - (order - 1) / 2);
  std::vector<Real> weights(static_cast<std::size_t>(order) + 1, 1);
  const Real t = wanted - static_cast<Real>(newest);
  for (int k = 0; k <= order; ++k)
    for (int j = 0; j <= order; ++j)
      if (j != k) weights[static_cast<std::size_t>(k)] *= (t - j) / (k - j);
  return frame_by_frame(frames, [&](std::size_t n) {
    Real sum = 0;
    for (int k = 0; k <= order; ++k) {
      const auto from = static_cast<long long>(n) - newest - k;
      if (from >= 0) sum += weights[static_cast<std::size_t>(k)] * g.at("in", static_cast<std::size_t>(from));
    }
    return sum;
  });
}

Expected fir(const Given& g, std::size_t frames) {
  return frame_by_frame(frames, [&](std::size_t n) {
    Real sum = 0;
    for (std::size_t k = 0; k < g.numbers.size() && k <= n; ++k)
      sum += Real(g.numbers[k]) * g.at("in", n - k);
    return sum;
  });
}

Expected threshold(const Given& g, std::size_t frames) {
  bool fired = false;
  long long wait = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    const Real in = g.at("in", n), level = g.at("level", n);
    if (wait > 0) --wait;
    if (in < level - g.at("hysteresis", n)) fired = false;
    if (fired || in < level || wait > 0) return Real{0};
    fired = true, wait = std::llround(g.at("hold", n) * g.rate);
    return Real{1};
  });
}

Expected sample_hold(const Given& g, std::size_t frames) {
  Rise rise;
  Real held = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    if (rise(g.at("trigger", n))) held = g.at("in", n);
    return held;
  });
}

Expected latch(const Given& g, std::size_t frames) {
  Rise set, reset;
  bool on = false;
  return frame_by_frame(frames, [&](std::size_t n) {
    if (set(g.at("set", n))) on = true;
    if (reset(g.at("reset", n))) on = false;
    return on ? Real{1} : Real{0};
  });
}

Expected counter(const Given& g, std::size_t frames) {
  Rise trigger, reset;
  Real count = 0;
  return frame_by_frame(frames, [&](std::size_t n) {
    const Real wrap = std::floor(g.at("count", n));
    if (trigger(g.at("trigger", n))) count = wrap >= 1 && count + 1 >= wrap ? 0 : count + 1;
    if (reset(g.at("reset", n))) count = 0;
    return count;
  });
}

Expected spring(const Given& g, std::size_t frames) {
  return frame_by_frame(
      frames, [&](std::size_t n) { return -g.at("stiffness", n) * (g.at("in", n) - g.at("rest", n)); });
}

Expected damper(const Given& g, std::size_t frames) {
  return frame_by_frame(frames, [&](std::size_t n) { return -g.at("damping", n) * g.at("in", n); });
}

Expected wall(const Given& g, std::size_t frames) {
  return frame_by_frame(frames, [&](std::size_t n) {
    const Real depth = g.at("position", n) - g.at("at", n);
    if (!(depth > 0)) return Real{0};
    return -std::max<Real>(0, g.at("stiffness", n) * depth + g.at("damping", n) * g.at("velocity", n));
  });
}

/// The force; the profile of points is a spline, which is tested on its own.
Expected terrain(const Given& g, std::size_t frames) {
  const auto profile = g.settings.contains("profile") ? g.settings.at("profile") : "detent";
  Real rounding = 0;
  auto expected = frame_by_frame(frames, [&](std::size_t n) {
    const Real x = g.at("position", n), h = g.at("height", n), length = g.at("length", n);
    const Real w = g.at("weight", n), turn = 2 * kPi * x / length, steepest = w * h * 2 * kPi / length;
    if (profile == "points") return kOpen;
    if (profile == "detent") return -w * h * x / (length * length) * std::exp(-x * x / (2 * length * length));
    // The sine of a multiple of pi is what rounding the angle leaves.
    rounding = std::max(rounding, steepest * (1 + std::abs(turn)) * 1e-15L);
    return std::abs(turn) > 1e5L ? kOpen : steepest * std::sin(turn);
  });
  expected.rounding = rounding;
  return expected;
}

using Equation = Expected (*)(const Given&, std::size_t);

Equation equation_of(const std::string& type) {
  static const std::map<std::string, Equation> kEquations = {
      {"sine", sine},
      {"clip", clip},
      {"quantiser", quantiser},
      {"slew", slew},
      {"hysteresis", hysteresis},
      {"mix",
       [](const Given& g, std::size_t frames) {
         return frame_by_frame(frames, [&](std::size_t n) { return g.at("in", n); });
       }},
      {"envelope", envelope},
      {"decay", decay},
      {"adsr", adsr},
      {"one_pole", one_pole},
      {"dc_blocker", dc_blocker},
      {"velocity", velocity},
      {"difference", difference},
      {"low_pass", [](const Given& g, std::size_t frames) { return biquad(g, frames, "cutoff", 'l'); }},
      {"high_pass", [](const Given& g, std::size_t frames) { return biquad(g, frames, "cutoff", 'h'); }},
      {"band_pass", [](const Given& g, std::size_t frames) { return biquad(g, frames, "frequency", 'b'); }},
      {"delay", delay},
      {"fir", fir},
      {"threshold", threshold},
      {"sample_hold", sample_hold},
      {"latch", latch},
      {"counter", counter},
      {"spring", spring},
      {"damper", damper},
      {"wall", wall},
      {"terrain", terrain}};
  const auto found = kEquations.find(type);
  return found != kEquations.end() ? found->second : nullptr;
}

}  // namespace

std::optional<Expected> expected_output(const std::string& type, const Given& given, std::size_t frames) {
  const auto equation = equation_of(type);
  if (given.in.contains("rate")) return std::nullopt;  // taps of another rate are resampled
  return equation != nullptr ? std::optional{equation(given, frames)} : std::nullopt;
}

}  // namespace tactus::test
