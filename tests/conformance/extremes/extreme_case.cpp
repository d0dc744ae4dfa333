#include "tests/conformance/extremes/extreme_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "engine/core/index.h"
#include "tests/conformance/extremes/reference.h"
#include "tests/support/graphs/graph_runner.h"
#include "tests/support/graphs/node_runner.h"

namespace tactus::test {
namespace {

constexpr int kFrames = 512;

struct Version {
  const ExtremeSubject* subject;
  int slot;
  bool by_signal;
  double rate, value;
  Units units = {};

  explicit Version(const ExtremeCase& c)
      : subject(c.subject), slot(c.slot), by_signal(c.by_signal), rate(c.rate), value(c.value) {}

  /// In the units of the reference.
  double plain_number(int i) const { return i == slot ? value : subject->slots[index(i)].value; }
  double number(int i) const { return plain_number(i) * units.factor(counted(i)); }
  Counted counted(int i) const {
    const auto& s = subject->slots[index(i)];
    if (s.exponent < 0) return s.counted;
    return {parse_unit("N")->dimension / parse_unit("m")->dimension.pow(plain_number(s.exponent)), 0};
  }
  bool moves(int i) const {
    const auto& s = subject->slots[index(i)];
    return i == slot ? by_signal : s.moves;
  }
  bool written(int i) const {
    const auto& instead_of = subject->slots[index(slot)].instead_of;
    const auto& s = subject->slots[index(i)];
    return i == slot || (s.written && (instead_of.empty() || s.name != instead_of));
  }
  double sample_rate() const { return rate / units.second; }
};

std::string as_number(double value, const Slot& slot) {
  if (slot.whole && std::floor(value) == value && std::abs(value) < 1e15 &&
      !(value == 0 && std::signbit(value)))
    return fmt::format("{:.0f}", value);
  auto text = fmt::format("{:.17g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return slot.quoted_unit.empty() ? text : "\"" + text + " " + slot.quoted_unit + "\"";
}

std::string unit_of(const Slot& slot) {
  const auto unit = to_string(slot.counted.dimension);
  return unit.empty() ? "" : " unit = \"" + unit + "\"";
}

struct Played {
  std::string text;
  std::vector<Error> errors;
  Channels out;
  std::vector<FaultCount> faults;

  bool ran() const { return errors.empty(); }
};

Samples samples_of(const Version& v, int i) {
  const auto& slot = v.subject->slots[index(i)];
  if (i == v.slot) return Samples(kFrames, v.number(i));
  const double factor = v.units.factor(slot.counted);
  auto samples = noise(kFrames, static_cast<unsigned>(i) + 1, slot.usual.low, slot.usual.high);
  for (auto& sample : samples) sample *= factor;
  return samples;
}

Played play(const Version& v, const std::vector<int>& blocks = {64}) {
  Played played;
  std::vector<std::string> numbers;
  Channels in;
  played.text = "format = 1\n[inputs]\n";
  for (int i = 0; i < std::ssize(v.subject->slots); ++i) {
    const auto& slot = v.subject->slots[index(i)];
    if (!v.written(i)) {
      numbers.emplace_back();
    } else if (v.moves(i)) {
      numbers.push_back(fmt::format("\"s{}\"", i));
      played.text += fmt::format("s{} = {{{} }}\n", i, unit_of(slot));
      in.push_back(samples_of(v, i));
    } else {
      numbers.push_back(as_number(v.number(i), slot));
    }
  }
  played.text += v.subject->text(numbers);
  CompileOptions options;
  options.sample_rate = Hertz{v.sample_rate()};
  auto plan =
      compile(parse_graph_leniently(played.text, v.subject->file.string()), standard_nodes(), options);
  if (!plan) return played.errors = plan.error(), played;
  Player engine{std::move(*plan)};
  played.out = run(engine, in, kFrames, blocks);
  played.faults = engine.faults();
  return played;
}

double largest(const Samples& samples) {
  double most = 0;
  for (const double x : samples) most = std::max(most, std::abs(x));
  return most;
}

/// "" if `a` is `b * factor` to a share of the largest sample, else where it is not.
std::string apart(const Channels& a, const Channels& b, const std::vector<double>& factors, double share) {
  for (std::size_t c = 0; c < a.size(); ++c) {
    const double allowed = share * factors[c] * largest(b[c]) + 1e-290;
    for (std::size_t n = 0; n < a[c].size(); ++n)
      if (!(std::abs(a[c][n] - b[c][n] * factors[c]) <= allowed))
        return fmt::format("output {} frame {}: {} instead of {}", c, n, a[c][n], b[c][n] * factors[c]);
  }
  return "";
}
std::string apart(const Channels& a, const Channels& b, double share) {
  return apart(a, b, std::vector<double>(a.size(), 1.0), share);
}

Judgement wrong(std::string reason) { return {Verdict::Wrong, std::move(reason)}; }

// What a node does at 0 by its declaration, and does not do next to it.
const std::set<std::string> kJumpsAtZero = {
    "decay.length",  // 0: never
    "quantiser.in",  // a step of the staircase
    "sequence.values",   "sequence.values 0", "sequence.values 1", "sequence.values 2", "sequence.values 3",
    "sequence.values 4",  // 0 is a rest
    "proxy.x",           "proxy.y",           "proxy.z",           "proxy.at_x",        "proxy.at_y",
    "proxy.at_z",                             // which face or direction is nearest
    "saw.frequency",     "square.frequency",  // they start in the middle of a jump, and go on or not
};

/// Those that keep times, frequencies or levels of their own by definition: another unit of time is another
/// thing.
const std::set<std::string> kOwnTimes = {
    "onset",                      // bands from 30 Hz to 7 kHz
    "stroke",                     // bands from 90 Hz to 9 kHz
    "align",                      // crossfades in 10 ms, periods up to 0.1 s
    "sample",                     // a recording has a rate
    "pitch",                      // every 5 ms
    "random_walk",                // times from 1 ms to a day
    "six_axis",                   // holds masses against gravity, 9.80665 m/s^2
    "modal",       "modal_body",  // decays from 0.1 ms to 10,000 s
};

/// The reason for a refusal: place, what, and what to do.
Judgement judge_refusal(const ExtremeCase& c, const Played& played, bool beyond) {
  const auto& error = played.errors.front();
  const auto text = to_string(error);
  const auto& slot = c.tested();
  const auto file = c.subject->file.string();
  const auto key = slot.name.substr(0, slot.name.find(' '));
  if (c.by_signal) return wrong("a signal is refused: " + text);
  if (!error.where.starts_with(file + ":")) return wrong("refused without a place: " + text);
  if (error.remedy.empty()) return wrong("refused without a remedy: " + text);
  // "'stiffness' of spring 'push'" or "'ball.stiffness' of network 'tested'".
  if (beyond && error.what.find(key + "'") == std::string::npos)
    return wrong("the refusal does not name '" + key + "': " + text);
  if (beyond && error.remedy.find_first_of("0123456789") == std::string::npos && !slot.whole)
    return wrong("the refusal names no range: " + text);
  return {Verdict::Refused, text};
}

/// By how much a unit must grow so that the number under test becomes moderate.
Units moderate_units(const ExtremeCase& c) {
  const auto& counted = c.tested().counted;
  Units units;
  if (c.value == 0 || !std::isfinite(c.value)) return units;
  const auto shrink = [&](double& unit, double power) {
    unit = std::exp2(-std::round(std::ilogb(c.value) / power / 4) * 4);
  };
  if (counted.level != 0)
    shrink(units.level, counted.level);
  else if (counted.dimension.kilogram != 0)
    shrink(units.kilogram, counted.dimension.kilogram);
  else if (counted.dimension.ampere != 0)
    shrink(units.ampere, counted.dimension.ampere);
  else if (counted.dimension.metre != 0)
    shrink(units.metre, counted.dimension.metre);
  return units;
}

/// Other systems of units, from the most telling to the most modest.
std::vector<Units> other_units(const ExtremeCase& c) {
  const bool own_times = kOwnTimes.contains(c.subject->type);
  const double second = c.rate > 96e3 ? 4 : 0.25;
  auto all = moderate_units(c), in_time = all;
  if (c.subject->assumes_speed) all.metre = in_time.metre = 1;
  in_time.second *= second, in_time.metre *= second;
  const Units time_only{.metre = second, .second = second};
  const Units mild{.kilogram = 64, .ampere = 4, .level = 1024};
  if (own_times) return {all, mild};
  return {in_time,
          all,
          {.metre = second, .kilogram = 64, .second = second, .ampere = 4, .level = 1024},
          time_only,
          mild};
}

bool same(const Units& a, const Units& b) {
  return a.metre == b.metre && a.kilogram == b.kilogram && a.second == b.second && a.ampere == b.ampere &&
         a.level == b.level;
}

/// No number leaves its range, overflows or becomes too small by the change.
bool fits(const Version& v) {
  for (int i = 0; i < std::ssize(v.subject->slots); ++i) {
    const auto& slot = v.subject->slots[index(i)];
    const double number = v.number(i);
    if (!slot.declared.contains(number)) return false;
    if (number != 0 && (!std::isfinite(number) || std::abs(number) < 1e-290)) return false;
  }
  return true;
}

struct Laws {
  const ExtremeCase& c;
  const Played& played;
  std::vector<std::string> held, broken;

  void note(const std::string& law, const std::string& difference) {
    (difference.empty() ? held : broken).push_back(difference.empty() ? law : law + ": " + difference);
  }

  void clamp() {
    const auto& range = c.tested().declared;
    if (!c.by_signal || range.contains(c.value)) return;
    Version at_end{c};
    at_end.value = std::clamp(c.value, range.low, range.high);
    const auto other = play(at_end);
    if (other.ran()) note("a signal beyond the range is its end", first_difference(played.out, other.out));
  }

  void number() {
    if (!c.by_signal || !c.tested().declared.contains(c.value)) return;
    Version constant{c};
    constant.by_signal = false;
    const auto other = play(constant);
    if (other.ran() && other.faults.empty())
      note("a signal at rest is a number", apart(played.out, other.out, 1e-9));
  }

  void zero() {
    if (!(std::abs(c.value) <= 1e-30) || (c.value == 0 && !std::signbit(c.value))) return;
    if (kJumpsAtZero.contains(c.subject->type + "." + c.tested().name)) return;
    Version at_zero{c}, usual{c};
    at_zero.value = 0, usual.value = c.tested().value;
    const auto other = play(at_zero), middle = play(usual);
    if (!other.ran() || !middle.ran()) return;
    std::string difference;
    for (std::size_t o = 0; o < played.out.size() && difference.empty(); ++o) {
      // No node and no graph of these tests makes more than a thousand times as much of it.
      const double size = std::max({largest(other.out[o]), largest(middle.out[o]), 1e12 * std::abs(c.value)});
      for (std::size_t n = 0; n < played.out[o].size() && difference.empty(); ++n)
        if (!(std::abs(played.out[o][n] - other.out[o][n]) <= 1e-9 * size))
          difference =
              fmt::format("output {} frame {}: {} instead of {}", o, n, played.out[o][n], other.out[o][n]);
    }
    note("next to 0 is 0", difference);
  }

  /// The first system of units in which the graph is accepted.
  void units() {
    if (!fits(Version{c})) return;
    for (const auto& units : other_units(c)) {
      Version scaled{c};
      scaled.units = units;
      if (same(units, {}) || !fits(scaled)) continue;
      const auto other = play(scaled);
      if (!other.ran()) continue;
      std::vector<double> factors;
      for (const auto& shown : c.subject->shown) factors.push_back(1 / units.factor(shown.counted));
      bool lost = false;
      for (std::size_t o = 0; o < factors.size(); ++o) {
        const double most = largest(other.out[o]) * factors[o];
        lost = lost || !std::isfinite(most) || (most != 0 && most < 1e-280);
      }
      if (lost || !other.faults.empty()) {
        if (!played.faults.empty() && other.faults.empty()) overflows = true;
        continue;
      }
      if (!played.faults.empty()) return note("other units", "a fault here and none there");
      return note(fmt::format("other units (m {:g}, kg {:g}, s {:g}, A {:g}, level {:g})", units.metre,
                              units.kilogram, units.second, units.ampere, units.level),
                  rigid() ? apart({played.out[0]}, {other.out[0]}, factors, 1e-6)
                          : apart(played.out, other.out, factors, 1e-9));
    }
  }

  /// Parts of a network that move together to the last bit: the force between them is lost, and the position,
  /// the first output, is that of a badly conditioned system.
  bool rigid() const { return of_network() && std::abs(c.value) >= 1e30; }
  bool of_network() const { return c.subject->family == "element"; }

  void equation() {
    if (of_network()) return;  // equations are of nodes
    const Version v{c};
    Given given{.rate = static_cast<long double>(c.rate), .settings = c.subject->settings};
    for (int i = 0; i < std::ssize(c.subject->slots); ++i) {
      const auto& slot = c.subject->slots[index(i)];
      if (slot.fixed && !v.written(i)) continue;
      if (!slot.key.empty()) {
        Series series;
        for (const double x : v.moves(i) ? samples_of(v, i) : Samples(kFrames, v.number(i)))
          series.push_back(static_cast<Series::value_type>(
              std::clamp(taken_for(x), slot.declared.low, slot.declared.high)));
        given.in[slot.name] = std::move(series);
      } else {
        given.numbers.push_back(v.number(i));
      }
    }
    const auto expected = expected_output(c.subject->type, given, kFrames);
    if (!expected) return;
    long double most = 0;
    int known = 0;
    for (const auto x : expected->out)
      if (std::isfinite(x)) most = std::max(most, std::abs(x)), ++known;
    if (most > static_cast<long double>(std::numeric_limits<double>::max())) return void(overflows = true);
    if (known == 0) return;
    std::string difference;
    for (std::size_t n = 0; n < expected->out.size() && difference.empty(); ++n)
      if (std::isfinite(expected->out[n]) &&
          !(std::abs(static_cast<long double>(played.out[0][n]) - expected->out[n]) <=
            expected->tolerance * most + expected->rounding + 1e-300L))
        difference = fmt::format("frame {}: {} instead of {}", n, played.out[0][n],
                                 static_cast<double>(expected->out[n]));
    note("equation", difference);
  }

  bool overflows = false;  ///< the right result is beyond what a double holds
};

bool all_finite(const Channels& out) {
  return std::ranges::all_of(out, [](const auto& samples) {
    return std::ranges::all_of(samples, [](double x) { return std::isfinite(x); });
  });
}

}  // namespace

std::string ExtremeCase::name() const {
  return fmt::format("{}.{} = {:g}{} at {:g} kHz", subject->name, tested().name, value,
                     by_signal ? " by a signal" : "", rate / 1000);
}

std::vector<double> extreme_values(const Interval& declared, bool whole) {
  std::set<double> values = {0.0, 5e-324, 1e-310, 1e-30, 1e30, 1e300, -5e-324, -1e-30, -1.0, -1e30, -1e300};
  for (const double end : {declared.low, declared.high})
    if (std::isfinite(end)) {
      const double step = whole ? 1 : 1e-9 * std::max(1e-9, std::abs(end));
      values.insert({end - step, end, end + step});
      if (whole) values.insert(end + 0.5);
    }
  std::vector<double> all{values.begin(), values.end()};
  all.push_back(-0.0);
  return all;
}

std::vector<ExtremeCase> extreme_cases(const ExtremeSubject& subject, const std::vector<double>& rates) {
  std::vector<ExtremeCase> cases;
  for (int slot = 0; slot < std::ssize(subject.slots); ++slot) {
    const auto& s = subject.slots[index(slot)];
    if (s.name.starts_with("ball ")) continue;  // a mass and a spring have subjects of their own
    for (const double rate : rates)
      for (const double value : extreme_values(s.declared, s.whole))
        for (const bool by_signal : {false, true})
          if (!by_signal || !s.fixed) cases.push_back({&subject, slot, by_signal, rate, value});
  }
  return cases;
}

Judgement judge(const ExtremeCase& c) {
  const auto played = play(Version{c});
  const auto& slot = c.tested();
  const double taken = taken_for(c.value);
  const bool beyond =
      !c.by_signal && (!slot.declared.contains(taken) || (slot.whole && std::floor(taken) != taken));
  if (!played.ran()) return judge_refusal(c, played, beyond);
  if (beyond)
    return wrong(
        fmt::format("accepted beyond the range {:g} to {:g}", slot.declared.low, slot.declared.high));
  if (!all_finite(played.out)) return wrong("an output is not finite");
  const auto recut = play(Version{c}, {1, 37, 100, 3});
  if (const auto difference = first_difference(played.out, recut.out); !difference.empty())
    return wrong("blocks matter: " + difference);
  Laws laws{c, played, {}, {}};
  laws.equation();
  laws.units();
  if (!played.faults.empty() && laws.overflows)
    return {Verdict::Right, "the result overflows, and is reported"};
  if (!played.faults.empty()) return wrong("a fault of " + played.faults.front().path);
  laws.clamp();
  laws.number();
  laws.zero();
  if (!laws.broken.empty()) return wrong(laws.broken.front());
  if (laws.held.empty()) return {Verdict::Finite};
  return {Verdict::Right, laws.held.front()};
}

}  // namespace tactus::test
