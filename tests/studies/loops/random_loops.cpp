#include "tests/studies/loops/random_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>

#include "tests/studies/loops/thrown_springs.h"

namespace tactus::study {
namespace {

using Signal = Circuit::Signal;

class Random {
 public:
  explicit Random(std::uint64_t seed) : bits_(seed) {}
  double uniform(double low = 0, double high = 1) {
    return low + (high - low) * static_cast<double>(bits_() >> 11) * 0x1p-53;
  }
  double decades(double low, double high) { return low * std::pow(high / low, uniform()); }
  int below(int count) { return static_cast<int>(uniform() * count); }
  bool chance(double of) { return uniform() < of; }
  double sign() { return chance(0.5) ? 1 : -1; }
  template <class T>
  T among(std::initializer_list<T> list) {
    return *(list.begin() + below(static_cast<int>(list.size())));
  }

 private:
  std::mt19937_64 bits_;
};

/// How a loop is written and what it is, at a gain.
struct Written {
  LoopFiles loop;
  std::vector<Circuit> pieces;        ///< of each region in which it is linear; the first: at rest
  Signal output = -1;                 ///< of the first piece: the instrument's first output
  std::optional<double> growth = {};  ///< where there are no pieces
};
using Write = std::function<Written(double gain)>;

std::string number(double value) { return fmt::format("{:.17g}", value); }
std::string seconds(double value) { return "\"" + number(value) + " s\""; }
std::string hertz(double value) { return "\"" + number(value) + " Hz\""; }

/// A filter as a node and as what it is.
struct Filter {
  std::string fields;
  std::vector<Taps> taps;
  std::string output = {};
};

double any_rate(Random& random) {
  return random.among(
      {8000.0, 11025.0, 16000.0, 22050.0, 32000.0, 44100.0, 48000.0, 88200.0, 96000.0, 192000.0});
}

Filter any_filter(Random& random, double rate, double low, double high) {
  const double cutoff = random.decades(low, std::min(high, 0.4 * rate)), q = random.decades(0.3, 5);
  const auto with_q = [&](const char* type, const char* port) {
    return fmt::format("type = \"{}\", {} = {}, q = {}", type, port, hertz(cutoff), number(q));
  };
  switch (random.below(6)) {
    case 0:
      return {"type = \"one_pole\", cutoff = " + hertz(cutoff), {one_pole(cutoff, rate)}, ".low"};
    case 1:
      return {"type = \"one_pole\", form = \"matched\", cutoff = " + hertz(cutoff),
              {matched_one_pole(cutoff, rate)},
              ".low"};
    case 2:
      return {with_q("low_pass", "cutoff"), {low_pass(cutoff, q, rate)}};
    case 3:
      return {with_q("band_pass", "frequency"), {band_pass(cutoff, q, rate)}};
    case 4:
      return {with_q("high_pass", "cutoff"), {high_pass(cutoff, q, rate)}};
    default:
      return {"type = \"dc_blocker\", cutoff = " + hertz(cutoff), {dc_blocker(cutoff, rate)}};
  }
}

/// One that lets low frequencies through.
Filter any_smoother(Random& random, double rate, double low, double high) {
  const double cutoff = random.decades(low, std::min(high, 0.4 * rate)), q = random.decades(0.4, 1.5);
  if (random.chance(0.5))
    return {"type = \"one_pole\", form = \"matched\", cutoff = " + hertz(cutoff),
            {matched_one_pole(cutoff, rate)},
            ".low"};
  return {fmt::format("type = \"low_pass\", cutoff = {}, q = {}", hertz(cutoff), number(q)),
          {low_pass(cutoff, q, rate)}};
}

/// A delay as a node and as what it is.
struct DelayText {
  std::string fields;
  double frames;
  int order;
  Signal add(Circuit& circuit) const { return circuit.delay(frames, order); }
};
DelayText any_delay(Random& random, double rate, double least, double most) {
  const int order = random.among({0, 1, 3, 3, 5});
  // The engine takes what is within 1e-9 of a whole frame for one.
  double frames = random.decades(std::max(least, order > 1 ? order / 2.0 + 1 : 1.0), most);
  if (order == 0 || random.chance(0.2)) frames = std::floor(frames);
  const double time = frames / rate;
  const char* words[] = {"none", "linear", "", "lagrange3", "", "lagrange5"};
  return {fmt::format("type = \"delay\", time = {}, interpolation = \"{}\"", seconds(time), words[order]),
          frames, order};
}

/// A loop of signals through a filter and a delay.
struct SignalLoop {
  LoopFiles files;
  Filter filter;
  DelayText delay;
  double sign;
};
SignalLoop any_signal_loop(Random& random) {
  LoopFiles files;
  files.rate = any_rate(random);
  const auto filter = any_filter(random, files.rate, 50, 8000);
  const auto delay = any_delay(random, files.rate, 1, 60);
  return {files, filter, delay, random.sign()};
}

/// The assumed device: a mass on a damper, whose place and speed come first.
struct Device {
  double mass, damping;
  std::vector<Signal> add(Circuit& circuit, double rate) const {
    Masses masses(1);
    masses.m[0] = mass;
    masses.join(0, -1, 0, damping);
    return circuit.masses(masses, Method::Passive, rate);
  }
};

LoopFiles on_device(Random& random, double most_delay_s) {
  LoopFiles loop;
  loop.rate = any_rate(random);
  // Whole frames, at most 120 of them.
  const int frames = std::min(120, static_cast<int>(random.uniform(0, most_delay_s) * loop.rate));
  loop.delay_s = frames / loop.rate;
  loop.device_mass = random.decades(0.01, 0.5);
  loop.device_damping = loop.device_mass * random.decades(1, 20);
  return loop;
}
int delay_frames(const LoopFiles& loop) { return static_cast<int>(std::lround(loop.delay_s * loop.rate)); }

/// A force through the system's delay onto a device. Without delay it acts in the frame of its sensors.
void close(Circuit& circuit, const LoopFiles& loop, Signal place, int mass, Signal force) {
  const int frames = delay_frames(loop);
  if (frames == 0) return circuit.push(place, mass, force);
  const auto late = circuit.delay(frames, 0);
  circuit.feed(late, force);
  circuit.push(place, mass, late);
}

std::string node(const std::string& name, const std::string& in, const std::string& fields) {
  return fmt::format("{} = {{ in = \"{}\", {} }}\n", name, in, fields);
}

const char* const kDeviceInputs =
    "format = 1\n[inputs]\nplace = { unit = \"m\" }\nspeed = { unit = \"m/s\" }\n[nodes]\n";

// ---- kinds

/// Springs and dampers by feedback, filtered and late, on a device.
Write device(Random& random) {
  const auto loop = on_device(random, 0.01);
  const double rate = loop.rate;
  const bool filtered = random.chance(0.6), late = random.chance(0.5), own_speed = random.chance(0.3);
  const auto filter = any_smoother(random, rate, 100, 5000);
  const auto delay = any_delay(random, rate, 1, 40);
  const double damping = loop.device_damping * random.uniform(0, 1.5), cutoff = random.decades(200, 2000);
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    const double stiffness = gain * loop.device_damping / (loop.delay_s + 1 / rate);
    std::string text = kDeviceInputs, from = "place";
    auto& c = made.pieces[0];
    const auto kick = c.input();
    const auto device = Device{loop.device_mass, loop.device_damping}.add(c, rate);
    const auto place = c.sum({{1, device[0]}, {1, kick}});
    auto sensed = place;
    if (late) {
      const auto to = delay.add(c);
      c.feed(to, sensed);
      sensed = to;
      text += node("late", from, delay.fields);
      from = "late";
    }
    if (filtered) {
      sensed = c.filter(sensed, filter.taps[0]);
      text += node("smooth", from, filter.fields);
      from = "smooth" + filter.output;
    }
    text += node("pull", from, fmt::format("type = \"spring\", stiffness = {}", number(stiffness)));
    auto speed = device[1];
    if (own_speed) {
      speed = c.filter(place, velocity(cutoff, rate));
      text += node("rate", "place", "type = \"velocity\", cutoff = " + hertz(cutoff));
    }
    text += node("drag", own_speed ? "rate" : "speed",
                 fmt::format("type = \"damper\", damping = {}", number(damping)));
    const auto force = c.sum({{-stiffness, sensed}, {-damping, speed}});
    close(c, loop, device[0], 0, force);
    made.output = force;
    made.loop.files["i.toml"] = text + "[outputs]\npush = { from = \"pull + drag\", unit = \"N\" }\n";
    return made;
  };
}

/// Loops of signals: filters and delays, one within another.
Write signals(Random& random) {
  LoopFiles loop;
  const double rate = loop.rate = any_rate(random);
  const bool nested = random.chance(0.4), two = random.chance(0.5), filtered_twice = random.chance(0.4);
  const auto first = any_filter(random, rate, 50, 8000), second = any_filter(random, rate, 50, 8000);
  const auto far = any_delay(random, rate, 1, 60), near = any_delay(random, rate, 1, 20),
             inner = any_delay(random, rate, 1, 6);
  const double far_gain = random.sign() * random.uniform(0.3, 1),
               near_gain = random.sign() * random.uniform(0.3, 1),
               inner_gain = random.sign() * random.uniform(0.1, 0.85);
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    auto& c = made.pieces[0];
    const auto kick = c.input();
    const auto back = far.add(c), short_back = two ? near.add(c) : -1, within = nested ? inner.add(c) : -1;
    std::vector<std::pair<double, Signal>> terms{{1, kick}, {gain * far_gain, back}};
    std::string text = "format = 1\n[inputs]\nin = {}\n[nodes]\n";
    std::string expression = fmt::format("in + {} * back", number(gain * far_gain));
    if (two) {
      terms.emplace_back(gain * near_gain, short_back);
      expression += fmt::format(" + {} * shorter", number(gain * near_gain));
    }
    auto at = c.sum(terms);
    text += "sum = \"" + expression + "\"\n";
    std::string name = "sum";
    if (nested) {
      const auto x = c.sum({{1, at}, {inner_gain, within}});
      c.feed(within, x);
      text += fmt::format("ringing = \"sum + {} * within\"\n", number(inner_gain)) +
              node("within", "ringing", inner.fields);
      at = x;
      name = "ringing";
    }
    at = c.filter(at, first.taps[0]);
    text += node("first", name, first.fields);
    name = "first" + first.output;
    if (two) {
      c.feed(short_back, at);
      text += node("shorter", name, near.fields);
    }
    if (filtered_twice) {
      at = c.filter(at, second.taps[0]);
      text += node("second", name, second.fields);
      name = "second" + second.output;
    }
    c.feed(back, at);
    text += node("back", name, far.fields);
    made.output = at;
    made.loop.files["i.toml"] = text + "[outputs]\nout = { from = \"" + name + "\" }\n";
    return made;
  };
}

/// Two or three masses in a scene, with one or two drives.
Write scenes(Random& random) {
  auto loop = on_device(random, 0.006);
  const double rate = loop.rate;
  const int count = 2 + random.below(2), drives = 1 + random.below(2);
  const auto method = random.among({Method::Exact, Method::Passive, Method::Explicit, Method::Implicit});
  const char* solvers[] = {"explicit", "passive", "implicit", "exact"};
  Masses masses(count);
  std::string plant = fmt::format("[networks.n]\nsolver = \"{}\"\nground = {{ type = \"ground\" }}\n",
                                  solvers[static_cast<int>(method)]);
  for (int i = 0; i < count; ++i) {
    masses.m[i] = random.decades(0.01, 0.3);
    const double w = 2 * std::numbers::pi * random.decades(2, std::min(300.0, 0.01 * rate));
    const double stiffness = masses.m[i] * w * w, damping = masses.m[i] * w * random.decades(0.01, 0.3);
    masses.join(i, i - 1, stiffness, damping);
    plant += fmt::format(
        "m{0} = {{ type = \"mass\", mass = {1} }}\ns{0} = {{ type = \"spring\", between = [\"{2}\", "
        "\"m{0}\"], "
        "stiffness = {3}, damping = {4} }}\n",
        i, number(masses.m[i]), i == 0 ? "ground" : fmt::format("m{}", i - 1), number(stiffness),
        number(damping));
  }
  std::vector<int> on, of;
  std::vector<double> springs, dampers;
  std::vector<Filter> filters;
  for (int d = 0; d < drives; ++d) {
    on.push_back(random.below(count));
    of.push_back(random.below(count));
    springs.push_back(random.sign() *
                      masses.k(on[static_cast<std::size_t>(d)], on[static_cast<std::size_t>(d)]) *
                      random.uniform(0.2, 1));
    dampers.push_back(random.sign() *
                      masses.c(on[static_cast<std::size_t>(d)], on[static_cast<std::size_t>(d)]) *
                      random.uniform(0, 1));
    filters.push_back(any_smoother(random, rate, 100, 4000));
  }
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    auto& c = made.pieces[0];
    const auto kick = c.input();
    const auto moving = c.masses(masses, method, rate);
    std::string inputs, parts, nodes, outputs, plant_inputs, plant_outputs, forces, wires;
    for (int d = 0; d < drives; ++d) {
      const auto i = static_cast<std::size_t>(d);
      const double stiffness = gain * springs[i], damping = gain * dampers[i];
      inputs += fmt::format("x{0} = {{ unit = \"m\" }}\nv{0} = {{ unit = \"m/s\" }}\n", d);
      nodes += node(fmt::format("f{}", d), fmt::format("x{}", d), filters[i].fields) +
               fmt::format("u{0} = \"{1} N/m * f{0}{2} + {3} N s/m * v{0}\"\n", d, number(stiffness),
                           filters[i].output, number(damping));
      outputs += fmt::format("motor{0} = {{ from = \"u{0} / 1 N\" }}\n", d);
      plant_inputs += fmt::format("d{} = {{ unit = \"full scale\" }}\n", d);
      plant_outputs += fmt::format(
          "x{0} = {{ from = \"n.m{1}.position\", unit = \"m\" }}\nv{0} = {{ from = \"n.m{1}.velocity\", unit "
          "= \"m/s\" "
          "}}\n",
          d, of[i]);
      forces +=
          fmt::format("p{0} = {{ type = \"force\", on = \"m{1}\", force = \"1 N * d{0}\" }}\n", d, on[i]);
      parts += fmt::format(", x{0} = \"plant.x{0}\", v{0} = \"plant.v{0}\"", d);
      wires += fmt::format(", d{0} = \"instrument.motor{0}\"", d);
      auto place = moving[static_cast<std::size_t>(2 * of[i])];
      if (d == 0) place = c.sum({{1, place}, {1, kick}});
      const auto smooth = c.filter(place, filters[i].taps[0]);
      const auto force =
          c.sum({{stiffness, smooth}, {damping, moving[static_cast<std::size_t>(2 * of[i] + 1)]}});
      close(c, loop, moving[0], on[i], force);
      if (d == 0) made.output = force;
    }
    made.loop.files["i.toml"] =
        "format = 1\n[inputs]\n" + inputs + "[nodes]\n" + nodes + "[outputs]\n" + outputs;
    made.loop.files["p.toml"] =
        "format = 1\n[inputs]\n" + plant_inputs + plant + forces + "[outputs]\n" + plant_outputs;
    made.loop.files["scene.toml"] = fmt::format(
        "format = 1\nrate = {}\ndelay = {}\nduration = \"1 s\"\n[parts]\ninstrument = {{ use = \"i.toml\"{} "
        "}}\nplant = {{ use = \"p.toml\"{} }}\n[converters]\noff = true\n",
        hertz(rate), seconds(loop.delay_s), parts, wires);
    return made;
  };
}

/// An explicit network by itself.
Write networks(Random& random) {
  LoopFiles loop;
  const double rate = loop.rate = any_rate(random);
  const int count = 1 + random.below(10);
  Masses masses(count);
  struct Link {
    int one, other;
    double stiffness, damping;
  };
  std::vector<Link> links;
  for (int i = 0; i < count; ++i) {
    masses.m[i] = random.decades(0.001, 0.1);
    const double stiffness = masses.m[i] * rate * rate * random.uniform(0.2, 1);
    links.push_back(
        {i, i - 1, stiffness, stiffness / rate * (random.chance(0.5) ? random.decades(1e-4, 0.1) : 1e-4)});
    if (i > 1 && random.chance(0.4)) links.push_back({i, random.below(i - 1), 0.3 * stiffness, 0.0});
  }
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    std::string text = "format = 1\n[networks.n]\nsolver = \"explicit\"\nground = { type = \"ground\" }\n";
    auto m = masses;
    for (int i = 0; i < count; ++i)
      text += fmt::format("m{} = {{ type = \"mass\", mass = {}, at = \"{} mm\" }}\n", i, number(m.m[i]),
                          1 + i % 3);
    int named = 0;
    for (const auto& link : links) {
      m.join(link.one, link.other, gain * link.stiffness, gain * link.damping);
      text += fmt::format(
          "s{} = {{ type = \"spring\", between = [\"{}\", \"m{}\"], stiffness = {}, damping = {} }}\n",
          named++, link.other < 0 ? "ground" : fmt::format("m{}", link.other), link.one,
          number(gain * link.stiffness), number(gain * link.damping));
    }
    made.pieces[0].masses(m, Method::Explicit, rate);
    made.loop.files["i.toml"] = text + "[outputs]\nx = { from = \"n.m0.position\", unit = \"m\" }\n";
    return made;
  };
}

/// An explicit network of a mass on a cubic spring that is thrown.
Write cubic(Random& random) {
  LoopFiles loop;
  loop.rate = any_rate(random);
  ThrownSpring thrown;
  thrown.rate = loop.rate;
  thrown.mass = random.decades(0.001, 0.1);
  thrown.stiffness = thrown.mass * loop.rate * loop.rate * random.uniform(0, 0.4);
  thrown.damping = random.chance(0.5) ? thrown.stiffness / loop.rate * random.decades(1e-3, 0.05) : 0.0;
  thrown.speed = random.chance(0.5) ? 0.0 : random.decades(1, 10);
  thrown.place = random.chance(0.5) ? 0.0 : random.decades(1e-4, 1e-2);
  const double scale = thrown.mass * std::pow(loop.rate, 4) / std::max(1.0, thrown.speed * thrown.speed);
  return [=](double gain) {
    Written made{loop, {}, -1};
    auto now = thrown;
    now.cubic = gain * scale;
    made.growth = now.grows() ? 1.0 : -1.0;
    made.loop.files["i.toml"] = fmt::format(
        "format = 1\n[networks.n]\nsolver = \"explicit\"\nground = {{ type = \"ground\" }}\nball = {{ type = "
        "\"mass\", mass "
        "= {}, at = {}, velocity = {} }}\nhold = {{ type = \"spring\", between = [\"ground\", \"ball\"], "
        "stiffness = {}, "
        "damping = {}, cubic = {} }}\n[outputs]\nx = {{ from = \"n.ball.position\", unit = \"m\" }}\n",
        number(now.mass), number(now.place), number(now.speed), number(now.stiffness), number(now.damping),
        number(now.cubic));
    return made;
  };
}

/// A spring in a part with a rate of its own.
Write divided(Random& random) {
  const auto loop = on_device(random, 0.004);
  const double rate = loop.rate;
  const int divisor = random.among({2, 3, 4, 6, 8, 12, 16});
  const bool mean = random.chance(0.5), line = random.chance(0.5), filtered = random.chance(0.5),
             late = random.chance(0.5), outside = random.chance(0.4);
  const double slow = rate / divisor;
  const auto filter = any_smoother(random, slow, 100, 4000);
  const int slow_frames = 1 + random.below(4);
  const double drag = loop.device_damping * random.uniform(0, 1);
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    const double stiffness = gain * loop.device_damping / (loop.delay_s + divisor / rate);
    auto& c = made.pieces[0];
    const auto kick = c.input();
    const auto device = Device{loop.device_mass, loop.device_damping}.add(c, rate);
    const auto place = c.sum({{1, device[0]}, {1, kick}});
    auto sensed = mean ? c.mean(place, divisor) : place;
    std::string part = "format = 1\n[inputs]\nplace = { unit = \"m\" }\n[nodes]\n", from = "place";
    c.begin_part(divisor);
    if (late) {
      const auto to = c.delay(slow_frames, 0);
      c.feed(to, sensed);
      sensed = to;
      part += node("late", from,
                   fmt::format("type = \"delay\", time = \"{} / system.rate\", interpolation = \"none\"",
                               slow_frames));
      from = "late";
    }
    if (filtered) {
      sensed = c.filter(sensed, filter.taps[0]);
      part += node("smooth", from, filter.fields);
      from = "smooth" + filter.output;
    }
    auto force = c.sum({{-stiffness, sensed}});
    c.end_part();
    part += node("pull", from, fmt::format("type = \"spring\", stiffness = {}", number(stiffness)));
    if (line) force = c.line(force, divisor);
    force = c.sum({{1, force}, {outside ? -drag : 0, device[1]}});
    close(c, loop, device[0], 0, force);
    made.output = force;
    made.loop.files["part.toml"] = part + "[outputs]\nforce = { from = \"pull\", unit = \"N\" }\n";
    made.loop.files["i.toml"] =
        std::string{kDeviceInputs} +
        fmt::format(
            "felt = {{ use = \"part.toml\", place = \"place\", rate = \"1/{}\", take = \"{}\", between = "
            "\"{}\" }}\n",
            divisor, mean ? "mean" : "last", line ? "line" : "hold") +
        (outside ? node("drag", "speed", fmt::format("type = \"damper\", damping = {}", number(drag))) : "") +
        "[outputs]\npush = { from = \"felt" + (outside ? " + drag" : "") + "\", unit = \"N\" }\n";
    return made;
  };
}

/// A loop of signals through something that bends: it is as steep as each of its pieces.
Write bent(Random& random) {
  const auto [loop, filter, delay, sign] = any_signal_loop(random);
  std::string law;
  std::vector<double> slopes;
  const double low = -random.decades(0.05, 2), high = random.decades(0.05, 2), a = random.uniform(-1, 1),
               b = random.uniform(-1, 1);
  switch (random.below(6)) {
    case 0:
      law = fmt::format("bent = {{ type = \"clip\", in = \"sum\", low = {}, high = {} }}\n", number(low),
                        number(high));
      slopes = {1, 0};
      break;
    case 1: {  // a table of four straight lines
      std::string points;
      double y = random.uniform(-1, 1), x = low - 0.5;
      for (int i = 0; i < 5; ++i) {
        points += fmt::format("{}[{}, {}]", i > 0 ? ", " : "", number(x), number(y));
        if (i == 4) break;
        const double step = random.uniform(0.2, 1), slope = random.uniform(-1, 1);
        slopes.push_back(slope);
        x += step, y += slope * step;
      }
      slopes.push_back(0);
      law = "bent = { type = \"map\", in = \"sum\", points = [" + points + "] }\n";
      break;
    }
    case 2:
      law = fmt::format("bent = \"{} * sum + {} * abs(sum)\"\n", number(a), number(b));
      slopes = {a + b, a - b};
      break;
    case 3:
      law = fmt::format("bent = \"max({} * sum, {} * sum)\"\n", number(a), number(b));
      slopes = {a, b};
      break;
    case 4:
      law = fmt::format("bent = \"{} * sum + {} * min(sum, {})\"\n", number(a), number(b), number(high));
      slopes = {a + b, a};
      break;
    default:
      law = fmt::format(
          "bent = \"{} * sum + first_clip\"\nfirst_clip = {{ type = \"clip\", in = \"{} * sum - 0.3\", low = "
          "0, high = 0.2 }}\n",
          number(a), number(b));
      slopes = {a, a + b};
      break;
  }
  return [=](double gain) {
    Written made{loop, {}, -1};
    for (const double slope : slopes) {
      auto& c = made.pieces.emplace_back();
      const auto back = delay.add(c);
      const auto sum = c.sum({{sign * gain, back}});
      const auto at = c.filter(c.sum({{slope, sum}}), filter.taps[0]);
      c.feed(back, at);
    }
    made.loop.files["i.toml"] =
        fmt::format("format = 1\n[inputs]\nin = {{}}\n[nodes]\nsum = \"in + {} * back\"\n",
                    number(sign * gain)) +
        law + node("first", "bent", filter.fields) + node("back", "first" + filter.output, delay.fields) +
        "[outputs]\nout = { from = \"sum\" }\n";
    return made;
  };
}

/// Walls with damping on a device, one at each end or one behind the other, or a sprung contact of the plant.
Write walls(Random& random) {
  const auto loop = on_device(random, 0.006);
  const double rate = loop.rate;
  const int kind = random.below(3);  // one wall, two ends, one behind the other
  const double share = random.uniform(0.2, 1), damping = loop.device_damping * random.uniform(0, 1),
               at = random.decades(1e-3, 1e-2), spring = random.chance(0.4) ? random.uniform(0, 0.5) : 0;
  return [=](double gain) {
    Written made{loop, {}, -1};
    const double unit = gain * loop.device_damping / (loop.delay_s + 1 / rate);
    const double first = unit, second = share * unit, always = spring * unit;
    const auto add = [&](double stiffness, double drag) {
      auto& c = made.pieces.emplace_back();
      const auto device = Device{loop.device_mass, loop.device_damping}.add(c, rate);
      close(c, loop, device[0], 0, c.sum({{-stiffness, device[0]}, {-drag, device[1]}}));
    };
    add(always, 0);
    add(always + first, damping);
    if (kind == 1) add(always + second, 0);
    if (kind == 2) add(always + first + second, damping);
    std::string text = kDeviceInputs;
    text += fmt::format(
        "stop = {{ type = \"wall\", position = \"place\", velocity = \"speed\", stiffness = {}, damping = "
        "{}, at = {} }}\n",
        number(first), number(damping), number(at));
    text += fmt::format("back = \"{} N/m * place\"\n", number(-always));
    if (kind == 1)
      text += fmt::format(
          "other = \"-mirror\"\nmirror = {{ type = \"wall\", position = \"-place\", stiffness = {}, at = {} "
          "}}\n",
          number(second), number(at));
    if (kind == 2)
      text += fmt::format("other = {{ type = \"wall\", position = \"place\", stiffness = {}, at = {} }}\n",
                          number(second), number(2 * at));
    made.loop.files["i.toml"] =
        text + fmt::format("[outputs]\npush = {{ from = \"stop + back{}\", unit = \"N\" }}\n",
                           kind > 0 ? " + other" : "");
    return made;
  };
}

/// A loop of signals behind a gate that its own input opens.
Write gates(Random& random) {
  const auto [loop, filter, delay, sign] = any_signal_loop(random);
  const double level = random.uniform(0.03, 0.6), rest = random.uniform(0, 0.6);
  const int kind = random.below(4);
  return [=](double gain) {
    Written made{loop, {}, -1};
    for (const double open : {rest, 1.0}) {
      auto& c = made.pieces.emplace_back();
      const auto back = delay.add(c);
      c.feed(back, c.filter(c.sum({{open * sign * gain, back}}), filter.taps[0]));
    }
    std::string text = "format = 1\n[inputs]\nx = { unit = \"full scale\" }\n[nodes]\n";
    text += fmt::format("sum = \"x + {} * ({} + {} * open) * back\"\n", number(sign * gain), number(rest),
                        number(1 - rest));
    const auto gate = fmt::format("{{ type = \"threshold\", in = \"{}\", level = {}, hysteresis = {} }}\n",
                                  kind == 2 ? "strong" : "x", number(level), number(0.5 * level));
    if (kind == 0) text += "open = \"gate.gate\"\ngate = " + gate;
    if (kind == 1)
      text +=
          "open = { type = \"adsr\", gate = \"gate.gate\", attack = \"1 ms\", sustain = 1, release = \"20 "
          "ms\" }\ngate = " +
          gate;
    if (kind == 2)
      text +=
          "open = { type = \"adsr\", gate = \"gate.gate\", attack = \"1 ms\", sustain = 1, release = \"20 "
          "ms\" }\ngate = " +
          gate +
          "strong = { type = \"envelope\", in = \"ac\", attack = \"0.5 ms\", release = \"20 ms\" }\nac = { "
          "type = "
          "\"dc_blocker\", in = \"x\" }\n";
    if (kind == 3)
      text += fmt::format("open = \"max(0, min(1, (abs(x) - {0}) / {1}))\"\n", number(level), number(0.3));
    made.loop.files["i.toml"] = text + node("late", "sum", filter.fields) +
                                node("back", "late" + filter.output, delay.fields) +
                                "[outputs]\ny = { from = \"sum\" }\n";
    return made;
  };
}

/// Loops whose gain is a product of moving signals. Inputs go to full scale, or to 1 m and 1 m/s.
Write products(Random& random) {
  const int kind = random.below(4);
  const auto loop = on_device(random, 0.002);
  const double rate = loop.rate, sign = random.sign(), rest = random.uniform(0, 0.6);
  const auto filter = any_filter(random, rate, 50, 8000);
  const auto delay = any_delay(random, rate, 1, 60);
  const double cutoff = random.decades(20, 500);
  if (kind < 2)
    return [=](double gain) {
      Written made{loop, {}, -1};
      made.loop.delay_s = 0;
      std::vector<double> shares{rest};
      for (const double x : {-1.0, -0.5, 0.5, 1.0})
        shares.push_back(rest + (1 - rest) * (kind == 0 ? x : x * x));
      for (const double open : shares) {
        auto& c = made.pieces.emplace_back();
        const auto back = delay.add(c);
        c.feed(back, c.filter(c.sum({{open * sign * gain, back}}), filter.taps[0]));
      }
      made.loop.files["i.toml"] =
          "format = 1\n[inputs]\nx = { unit = \"full scale\" }\n[nodes]\n" +
          fmt::format("sum = \"x + {} * ({} + {} * open) * back\"\nopen = \"{}\"\n", number(sign * gain),
                      number(rest), number(1 - rest), kind == 0 ? "slow.low" : "slow.low * slow.low") +
          node("slow", "x", "type = \"one_pole\", cutoff = " + hertz(cutoff)) +
          node("late", "sum", filter.fields) + node("back", "late" + filter.output, delay.fields) +
          "[outputs]\ny = { from = \"sum\" }\n";
      return made;
    };
  // Damping that grows with the distance from 0; with a sign that feeds energy in it grows, with the other
  // the delay lets it.
  return [=](double gain) {
    Written made{loop, {}, -1};
    const double b = loop.device_damping, spring = 0.3 * b / (loop.delay_s + 1 / rate), c2 = sign * gain * b;
    for (const double x : {0.0, 0.25, 0.5, 1.0}) {
      auto& c = made.pieces.emplace_back();
      const auto device = Device{loop.device_mass, b}.add(c, rate);
      const double by = c2 * (kind == 2 ? x : x * x);
      close(c, loop, device[0], 0, c.sum({{-spring, device[0]}, {by, device[1]}}));
    }
    made.loop.files["i.toml"] =
        std::string{kDeviceInputs} +
        fmt::format("far = \"{}\"\nfed = \"{} N s/m * speed * far\"\nback = \"{} N/m * place\"\n",
                    kind == 2 ? "abs(place) / 1 m" : "place * place / 1 m^2", number(c2), number(-spring)) +
        "[outputs]\npush = { from = \"fed + back\", unit = \"N\" }\n";
    return made;
  };
}

/// A spring on a device whose place is held by a clock.
Write held(Random& random) {
  const auto loop = on_device(random, 0.004);
  const double rate = loop.rate;
  int period = 8 + random.below(60);
  if (period % 12 == 0) ++period;
  // The sine passes 1/2 at a twelfth of its period.
  const int first = static_cast<int>(std::ceil(period / 12.0));
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    const double stiffness = gain * loop.device_damping / (loop.delay_s + period / rate);
    auto& c = made.pieces[0];
    const auto kick = c.input();
    const auto device = Device{loop.device_mass, loop.device_damping}.add(c, rate);
    const auto now = c.hold(c.sum({{1, device[0]}, {1, kick}}), period, first);
    const auto force = c.sum({{-stiffness, now}});
    close(c, loop, device[0], 0, force);
    made.output = force;
    made.loop.files["i.toml"] =
        std::string{kDeviceInputs} +
        fmt::format("tick = {{ type = \"sine\", frequency = {} }}\n", hertz(rate / period)) +
        "now = { type = \"sample_hold\", in = \"place\", trigger = \"tick\" }\n" +
        node("pull", "now", fmt::format("type = \"spring\", stiffness = {}", number(stiffness))) +
        "[outputs]\npush = { from = \"pull\", unit = \"N\" }\n";
    return made;
  };
}

/// Two gestures that move the stiffness of a spring and its share: between their extremes it may be stiffest.
Write gestures(Random& random) {
  auto loop = on_device(random, 0.006);
  const double rate = loop.rate;
  const double damping = loop.device_damping;
  struct Point {
    double time, value;
  };
  const auto path = [&](double low, double high) {
    std::vector<Point> points;
    const int count = 2 + random.below(3);
    for (int i = 0; i < count; ++i)
      points.push_back({(i + random.uniform(0.1, 0.9)) / count, random.uniform(low, high)});
    return points;
  };
  const auto harder = path(0.1, 1), more = path(0.1, 1);
  const auto at = [](const std::vector<Point>& points, double time) {
    if (time <= points.front().time) return points.front().value;
    for (std::size_t i = 1; i < points.size(); ++i)
      if (time < points[i].time) {
        const auto &a = points[i - 1], &b = points[i];
        return a.value + (b.value - a.value) * (time - a.time) / (b.time - a.time);
      }
    return points.back().value;
  };
  double most = 0;
  for (int i = 0; i <= 100'000; ++i) most = std::max(most, at(harder, 1e-5 * i) * at(more, 1e-5 * i));
  const auto text_of = [](const std::vector<Point>& points, double scale, const char* unit) {
    std::string text;
    for (const auto& p : points)
      text += fmt::format("{}[\"{} s\", \"{}{}\"]", text.empty() ? "" : ", ", number(p.time),
                          number(p.value * scale), unit);
    return text;
  };
  return [=](double gain) {
    Written made{loop, std::vector<Circuit>(1), -1};
    const double stiffness = gain * damping / (loop.delay_s + 1 / rate);
    auto& c = made.pieces[0];
    const auto device = Device{loop.device_mass, damping}.add(c, rate);
    close(c, loop, device[0], 0, c.sum({{-stiffness * most, device[0]}}));
    made.loop.files["i.toml"] = fmt::format(
        "format = 1\n[inputs]\nx = {{ unit = \"m\" }}\n[controls]\nk = {{ value = \"0 N/m\", range = [\"0 "
        "N/m\", \"{0} N/m\"] }}\n"
        "share = {{ value = 0, range = [0, 1] }}\n[nodes]\npull = {{ type = \"spring\", in = \"x\", "
        "stiffness = \"k * share\" "
        "}}\n[outputs]\nmotor = {{ from = \"pull / 1 N\" }}\n",
        number(stiffness));
    made.loop.files["p.toml"] = fmt::format(
        "format = 1\n[inputs]\nf = {{ unit = \"full scale\" }}\n[networks.n]\nground = {{ type = \"ground\" "
        "}}\na = {{ type = "
        "\"mass\", mass = {} }}\nb = {{ type = \"damper\", between = [\"ground\", \"a\"], damping = {} }}\np "
        "= {{ type = "
        "\"force\", on = \"a\", force = \"1 N * f\" }}\n[outputs]\nx = {{ from = \"n.a.position\", unit = "
        "\"m\" }}\n",
        number(loop.device_mass), number(damping));
    made.loop.files["scene.toml"] = fmt::format(
        "format = 1\nrate = {}\ndelay = {}\nduration = \"1 s\"\n[parts]\ninstrument = {{ use = \"i.toml\", x "
        "= \"plant.x\", k "
        "= \"harder\", share = \"more\" }}\nplant = {{ use = \"p.toml\", f = \"instrument.motor\" "
        "}}\n[gestures]\nharder = {{ "
        "points = [{}] }}\nmore = {{ points = [{}] }}\n[converters]\noff = true\n",
        hertz(rate), seconds(loop.delay_s), text_of(harder, stiffness, " N/m"), text_of(more, 1, ""));
    return made;
  };
}

struct Kind {
  std::string name;
  Write (*make)(Random&);
};
const std::vector<Kind>& kinds() {
  static const std::vector<Kind> all{{"device", device},     {"signals", signals}, {"scenes", scenes},
                                     {"networks", networks}, {"cubic", cubic},     {"divided", divided},
                                     {"bent", bent},         {"walls", walls},     {"gates", gates},
                                     {"products", products}, {"held", held},       {"gestures", gestures}};
  return all;
}

// ---- where they lie

/// Per second, of the piece that grows fastest.
double growth_of(const Written& made) {
  if (made.growth) return *made.growth;
  double most = -std::numeric_limits<double>::infinity();
  for (const auto& piece : made.pieces) most = std::max(most, piece.growth() * made.loop.rate);
  return most;
}

// Per second. Roots at z = 1 (the place of a device that nothing holds) are off by rounding; what is between
// the two has no clear truth.
constexpr double kRounding = 2e-5, kClear = 1e-3;

/// The least gain at which it grows, to a part in 10^5, from the side where it decays; nullopt: there is
/// none, or it grows at every gain. Regula falsi, with the halved weights of the Illinois method.
std::optional<double> border_of(const Write& write) {
  constexpr double kLowest = 1e-4, kHighest = 1e5, kStep = 3;
  const auto growth = [&](double gain) { return growth_of(write(gain)) - kRounding; };
  double low = 0.05, at_low = growth(low);
  while (at_low > 0) {
    if ((low *= 0.1) < kLowest) return std::nullopt;
    at_low = growth(low);
  }
  double high = kStep * low, at_high = growth(high);
  while (at_high <= 0) {
    low = high, at_low = at_high;
    if ((high *= kStep) > kHighest) return std::nullopt;
    at_high = growth(high);
  }
  for (int side = 0; high > (1 + 1e-5) * low;) {
    double middle = std::exp((std::log(low) * at_high - std::log(high) * at_low) / (at_high - at_low));
    if (!(middle > low * (1 + 1e-6) && middle < high * (1 - 1e-6))) middle = std::sqrt(low * high);
    const double found = growth(middle);
    if (found > 0) {
      high = middle, at_high = found;
      if (side == 1) at_low *= 0.5;
      side = 1;
    } else {
      low = middle, at_low = found;
      if (side == -1) at_high *= 0.5;
      side = -1;
    }
  }
  return low;
}

std::optional<RandomLoop> try_loop(long number, std::uint64_t seed) {
  Random random(seed);
  const auto count = static_cast<long>(kinds().size());
  const auto& kind = kinds()[static_cast<std::size_t>(number % count)];
  const bool near = number / count % 2 == 0;
  const auto write = kind.make(random);
  const auto border = border_of(write);
  if (!border) return std::nullopt;
  RandomLoop made;
  made.kind = kind.name;
  made.of_border = near ? random.sign() > 0 ? 1.01 : 0.99 : random.decades(0.1, 10);
  const auto written = write(made.of_border * *border);
  made.loop = written.loop;
  made.truth.growth = growth_of(written);
  if (made.truth.growth > kRounding && made.truth.growth < kClear) return std::nullopt;
  if (near && made.truth.grows() != (made.of_border > 1)) return std::nullopt;
  constexpr int kCompared = 400;
  if (written.output >= 0) made.response = written.pieces.front().respond(kCompared, written.output);
  return made;
}

}  // namespace

const std::vector<std::string>& loop_kinds() {
  static const auto names = [] {
    std::vector<std::string> list;
    for (const auto& kind : kinds()) list.push_back(kind.name);
    return list;
  }();
  return names;
}

RandomLoop random_loop(long number) {
  for (std::uint64_t attempt = 0;; ++attempt)
    if (auto made = try_loop(number, static_cast<std::uint64_t>(number) * 1'000'003 + attempt)) return *made;
}

}  // namespace tactus::study
