#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/graph/file/read_graph.h"
#include "engine/study/stability/stability.h"

// The verdict in sentences: is it stable, what becomes unstable first, what to change.
namespace tactus {
namespace {

double decibels(double factor) { return 20 * std::log10(factor); }

std::string joined(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, " -> "));
}

std::string newtons_per_metre(double stiffness) {
  return std::isfinite(stiffness) ? fmt::format("{:.4g} N/m", stiffness) : "any stiffness";
}

/// Where one change does most: of what is stable, the place with the least margin; of what is not, the one
/// that is nearest to stability. Fingertips do not count.
struct Critical {
  const RegimeVerdict* regime = nullptr;
  const LoopVerdict* loop = nullptr;
  const StiffVerdict* stiff = nullptr;
  double border = std::numeric_limits<double>::infinity();
};

bool more_critical(double border, const Critical& than) {
  if (!std::isfinite(border) || border <= 0) return false;
  return than.border < 1 ? border < 1 && border > than.border : border < than.border;
}

Critical most_critical(const StabilityVerdict& verdict) {
  Critical found;
  for (const bool springs : {true, false}) {
    for (const auto& regime : verdict.regimes) {
      if (regime.held || (!verdict.stable && regime.is_stable())) continue;
      for (const auto& stiff : regime.stiff)
        if (const double border = stiff.stable_up_to / stiff.stiffness;
            springs && more_critical(border, found))
          found = {&regime, nullptr, &stiff, border};
      for (const auto& loop : regime.loops)
        if (!springs && !loop.wave_port && !loop.integrates() && more_critical(loop.margin.border, found))
          found = {&regime, &loop, nullptr, loop.margin.border};
    }
    // A spring says more than the loop that contains it.
    if (found.regime != nullptr) return found;
  }
  return found;
}

bool several_drives(const StabilityVerdict& verdict) {
  const auto& loops = verdict.regimes.front().loops;
  return std::count_if(loops.begin(), loops.end(), [](const auto& loop) { return loop.drive; }) > 1;
}

const LoopVerdict* widest_drive(const RegimeVerdict& regime) {
  for (const auto& loop : regime.loops)
    if (loop.drive) return &loop;
  return nullptr;
}

std::string headline(const StabilityVerdict& verdict, const Critical& first) {
  const auto at =
      fmt::format("at {:g} kHz with a delay of {:.4g} ms", verdict.rate.value / 1e3, 1e3 * verdict.delay_s);
  if (!verdict.stable) return "unstable " + at;
  const auto stable = (verdict.outside_known ? "stable " : "stable by itself ") + at;
  if (first.regime == nullptr) return stable + ": no loop is closed";
  const double hertz = first.stiff != nullptr ? first.stiff->border_hz : first.loop->margin.border_hz;
  return fmt::format("{}: margin {:.1f} dB at {:.4g} Hz", stable, decibels(first.border), hertz);
}

void report_growing(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  for (const auto& regime : verdict.regimes) {
    if (regime.is_stable()) continue;
    std::string line =
        fmt::format("{}{}: {} root{} grow{}", regime.name, regime.held ? ", held by a fingertip" : "",
                    regime.growing, regime.growing == 1 ? "" : "s", regime.growing == 1 ? "s" : "");
    if (!regime.roots.empty() && regime.roots.front().growth_per_s > 0)
      line += fmt::format(", the fastest at {:.4g} Hz with a time constant of {:.3g} s",
                          regime.roots.front().frequency_hz, 1 / regime.roots.front().growth_per_s);
    words.push_back(std::move(line));
  }
}

void report_first(const Critical& first, std::vector<std::string>& words) {
  if (first.regime == nullptr) return;
  if (first.stiff != nullptr) {
    const bool pushes = first.stiff->stiffness < 0;
    words.push_back(fmt::format("most critical: {} '{}' ({}), which {} {} and is stable up to {}",
                                first.stiff->type, first.stiff->path, first.regime->name,
                                pushes ? "pushes away with" : "has",
                                newtons_per_metre(std::abs(first.stiff->stiffness)),
                                newtons_per_metre(std::abs(first.stiff->stable_up_to))));
    return;
  }
  words.push_back(fmt::format("most critical ({}): the loop {}, unstable from {:.3g} times its gain on",
                              first.regime->name, joined(first.loop->way), first.border));
}

void report_room(const StabilityVerdict& verdict, const Critical& first, std::vector<std::string>& words) {
  if (several_drives(verdict)) {
    words.emplace_back(
        "several drives: each margin is that of one drive alone; all together have smaller margins of gain "
        "and "
        "of delay");
    return;
  }
  const auto* drive = first.regime == nullptr ? nullptr : widest_drive(*first.regime);
  if (drive != nullptr && drive->margin.more_delay_s > 0 && std::isfinite(drive->margin.more_delay_s))
    words.push_back(fmt::format("delay margin: {:.3g} ms", 1e3 * drive->margin.more_delay_s));
}

void report_controls(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  for (const auto& control : verdict.controls)
    if (control.border)
      words.push_back(fmt::format("stable with control '{}' {} {}", control.control.name,
                                  control.stable_low ? "up to" : "from",
                                  in_unit(*control.border, control.control.unit)));
}

void report_change(const StabilityVerdict& verdict, const Critical& first, std::vector<std::string>& words) {
  if (verdict.stable) return;
  std::vector<std::string> ways;
  if (first.regime == nullptr)
    for (const auto& regime : verdict.regimes)
      for (const auto& stiff : regime.stiff)
        if (!regime.held && !regime.is_stable())
          ways.push_back(fmt::format("give '{}' less than its {} (it grows together with others)", stiff.path,
                                     newtons_per_metre(std::abs(stiff.stiffness))));
  if (first.stiff != nullptr)
    ways.push_back(fmt::format("give '{}' less than {}", first.stiff->path,
                               newtons_per_metre(std::abs(first.stiff->stable_up_to))));
  if (first.loop != nullptr) ways.push_back(fmt::format("use less than {:.3g} times the gain", first.border));
  for (const auto& control : verdict.controls)
    if (control.border)
      ways.push_back(fmt::format("set '{}' {} {}", control.control.name,
                                 control.stable_low ? "below" : "above",
                                 in_unit(*control.border, control.control.unit)));
  if (verdict.delay_s > 0) ways.emplace_back("shorten the delay");
  if (!ways.empty()) words.push_back(fmt::format("remedies, one of: {}", fmt::join(ways, "; ")));
}

/// Of each spring the least stable stiffness over all regimes in which a fingertip holds the device.
void report_held(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  std::vector<StiffVerdict> least;
  for (const auto& regime : verdict.regimes)
    for (const auto& stiff : regime.stiff) {
      if (!regime.held) continue;
      const auto known = std::find_if(least.begin(), least.end(),
                                      [&](const auto& other) { return other.path == stiff.path; });
      if (known == least.end())
        least.push_back(stiff);
      else if (stiff.stable_up_to < known->stable_up_to)
        *known = stiff;
    }
  for (const auto& stiff : least)
    words.push_back(fmt::format(
        "held by a fingertip, '{}' is stable up to {}{}", stiff.path, newtons_per_metre(stiff.stable_up_to),
        stiff.passive_up_to ? ", and is passive up to " + newtons_per_metre(*stiff.passive_up_to)
                            : std::string{}));
}

/// Nothing keeps a system at an unstable equilibrium: no loop causes that.
void report_equilibria(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  for (const auto& path : verdict.regimes.front().unstable_equilibria)
    words.push_back(
        fmt::format("rests on an unstable equilibrium of '{}': analysed where its force restores", path));
}

/// An instrument alone whose world is not known.
void report_outside(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  if (verdict.outside_known) return;
  words.emplace_back(
      "not analysed: the path outside from its outputs to its inputs; a scene with a plant has it (or, for "
      "outputs in N and inputs in m, the assumed device)");
  for (const auto& pair : verdict.open)
    words.push_back(
        fmt::format("{} -> {}: gain at most {:.3g} (at {:.4g} Hz): with a gain outside below "
                    "{:.3g} it is stable at every delay",
                    pair.input, pair.output, pair.peak, pair.peak_hz, 1 / pair.peak));
}

void report_networks(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  for (const auto& network : verdict.networks) {
    const bool first = &network == &verdict.networks.front() || (&network - 1)->path != network.path;
    if (first && !network.contacts_stable())
      words.push_back(
          network.contact_steps < kFewestContactSteps
              ? fmt::format("network '{}': a strike at 1 m/s lasts {:.2g} steps, fewer than {:g}: explicit "
                            "contacts then add energy; oversample = {:.0f}, or solver = \"passive\"",
                            network.path, network.contact_steps, kFewestContactSteps,
                            std::ceil(kFewestContactSteps / network.contact_steps))
              : fmt::format("network '{}': its initial state presses a contact too stiff for explicit steps, "
                            "which then add energy; more steps, or solver = \"passive\"",
                            network.path));
    if (network.stable || !network.grows) continue;
    std::string line = fmt::format("network '{}' ({}) is unstable by itself: spectral radius {:.9g}",
                                   network.path, network.regime, network.radius);
    if (!network.weakest.empty()) line += ", mode of " + network.weakest;
    if (network.needed_hz && std::isfinite(*network.needed_hz))
      line += fmt::format("; it needs {:.4g} Hz: oversample = {:.0f}, or solver = \"passive\"",
                          *network.needed_hz, std::ceil(*network.needed_hz / verdict.rate.value));
    words.push_back(std::move(line));
  }
}

void report_events(const StabilityVerdict& verdict, std::vector<std::string>& words) {
  for (const auto& event : verdict.events) {
    if (!event.on_loop || !event.place.hold_s) continue;
    std::string line = fmt::format("the loop through {} '{}' is event-driven: no small-signal gain exists",
                                   event.place.type, event.place.path);
    if (*event.place.hold_s > 0)
      line += fmt::format("; its hold limits it to {:.4g} events per second", 1 / *event.place.hold_s);
    words.push_back(std::move(line));
  }
  const auto unheld = [](const auto& event) { return event.on_loop && !event.place.hold_s; };
  const bool held = std::any_of(verdict.events.begin(), verdict.events.end(),
                                [](const auto& e) { return e.on_loop && e.place.hold_s; });
  for (const auto& event : verdict.events)
    if (!held && unheld(event))
      words.push_back(fmt::format("the loop through {} '{}' is event-driven: no small-signal gain exists",
                                  event.place.type, event.place.path));
}

}  // namespace

std::vector<std::string> describe(const StabilityVerdict& verdict) {
  const auto first = most_critical(verdict);
  std::vector<std::string> words{headline(verdict, first)};
  report_growing(verdict, words);
  report_networks(verdict, words);
  if (std::any_of(verdict.networks.begin(), verdict.networks.end(),
                  [](const auto& n) { return n.has_friction; }))
    words.emplace_back("dry friction is left out: it stabilises small motions beyond these limits");
  report_equilibria(verdict, words);
  report_first(first, words);
  report_change(verdict, first, words);
  report_room(verdict, first, words);
  if (verdict.stable) report_controls(verdict, words);
  report_held(verdict, words);
  report_events(verdict, words);
  report_outside(verdict, words);
  for (const auto& path : verdict.skipped) words.push_back(path + ": too large to analyse; skipped");
  return words;
}

}  // namespace tactus
