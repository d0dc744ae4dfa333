#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/decibels.h"
#include "engine/core/prefixed.h"
#include "engine/graph/file/read_graph.h"
#include "engine/study/stability/stability.h"

namespace tactus {
namespace {

std::string stiffness_text(const StiffVerdict& stiff, double stiffness) {
  return std::isfinite(stiffness) ? stiff.with_unit(std::abs(stiffness)) : "any stiffness";
}

/// Where one change has the largest effect: in a stable system the place with the least margin, else the one
/// nearest to stability. Systems held by a fingertip do not count.
struct Critical {
  const RegimeVerdict* regime = nullptr;
  const LoopVerdict* loop = nullptr;
  const StiffVerdict* stiff = nullptr;
  double border = std::numeric_limits<double>::infinity();
};

/// Of two that differ by rounding, the first.
bool more_critical(double border, const Critical& than) {
  constexpr double kRounding = 1e-6;
  if (!std::isfinite(border) || border <= 0) return false;
  return than.border < 1 ? border < 1 && border > (1 + kRounding) * than.border
                         : border < (1 - kRounding) * than.border;
}

Critical most_critical(const StabilityVerdict& verdict) {
  Critical found;
  for (const bool springs : {true, false}) {
    for (const auto& regime : verdict.regimes) {
      if (regime.held || (!verdict.stable() && regime.is_stable())) continue;
      for (const auto& stiff : regime.stiff)
        if (const double border = stiff.stable_up_to / stiff.stiffness;
            springs && more_critical(border, found))
          found = {&regime, nullptr, &stiff, border};
      for (const auto& loop : regime.loops)
        if (!springs && !loop.wave_port && !loop.integrates() && more_critical(loop.margin.border, found))
          found = {&regime, &loop, nullptr, loop.margin.border};
    }
    // A spring is more specific than the loop that contains it.
    if (found.regime != nullptr) return found;
  }
  return found;
}

class Report {
 public:
  explicit Report(const StabilityVerdict& verdict) : verdict_(verdict), critical_(most_critical(verdict)) {}

  std::vector<std::string> run() {
    add_headline();
    for (const auto& regime : verdict_.regimes) add_growing(regime);
    for (const auto& gesture : verdict_.gestures) add_gesture(gesture);
    for (const auto& held : verdict_.held)
      if (held.stability == Stability::Unstable)
        held.place ? add("unstable where input '{}' is at {:.4g} {}", held.input, *held.place, held.unit)
                   : add("unstable while {} to input '{}'", added(held), held.input);
    for (const auto& doubt : verdict_.doubts) add("undecided: {}; {}", doubt.reason, doubt.remedy);
    for (const auto& network : verdict_.networks) add_network(network);
    if (std::ranges::any_of(verdict_.networks, &NetworkVerdict::has_friction))
      add("dry friction is neglected: it keeps small motions stable even above these limits");
    for (const auto& path : verdict_.regimes.front().unstable_equilibria)
      add("the operating point is an unstable equilibrium of '{}': analysed where its force is restoring",
          path);
    add_critical();
    if (verdict_.stability == Stability::Unstable) add_remedies();
    add_delay_margin();
    if (verdict_.stable()) add_controls();
    add_held();
    add_events();
    add_outside();
    return std::move(lines_);
  }

 private:
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    lines_.push_back(fmt::format(format, std::forward<Args>(args)...));
  }

  void add_headline() {
    const auto at = fmt::format("at {:g} kHz with a delay of {}", verdict_.rate.value / 1e3,
                                prefixed(verdict_.delay_s, "s"));
    const auto* const stable = verdict_.outside_known ? "stable" : "stable by itself";
    if (!verdict_.stable())
      return add("{} {}", verdict_.stability == Stability::Undecided ? "undecided" : "unstable", at);
    if (critical_.regime == nullptr)
      return add("{} {}: no loop is closed{}", stable, at,
                 may_close() ? " " + verdict_.regimes.front().name : "");
    add("{} {}: margin {:.1f} dB at {}", stable, at, amplitude_to_db(critical_.border),
        prefixed(critical_.stiff != nullptr ? critical_.stiff->border_hz : critical_.loop->margin.border_hz,
                 "Hz"));
  }

  /// Events or a contact close a loop that is open at rest.
  bool may_close() const {
    return std::ranges::any_of(verdict_.events, &EventPlace::on_loop) ||
           std::ranges::any_of(verdict_.controls,
                               [](const auto& control) { return control.border.has_value(); });
  }

  static std::string added(const HeldVerdict& held) {
    return fmt::format("{}{:g} (in its unit) is added", held.alternates ? "+-" : "", held.level);
  }

  void add_growing(const RegimeVerdict& regime) {
    if (regime.is_stable()) return;
    const bool one = regime.growing == 1;
    add("{}{}: {} root{} grow{}", regime.name, regime.held ? ", held by a fingertip" : "", regime.growing,
        one ? "" : "s", one ? "s" : "");
    if (!regime.roots.empty() && regime.roots.front().growth_per_s > 0)
      lines_.back() += fmt::format(", the fastest at {} with a time constant of {}",
                                   prefixed(regime.roots.front().frequency_hz, "Hz"),
                                   prefixed(1 / regime.roots.front().growth_per_s, "s"));
  }

  void add_gesture(const GestureVerdict& gesture) {
    if (gesture.stability != Stability::Stable)
      add("unstable at {:.3g} s, where a gesture takes control '{}' to {}", gesture.seconds, gesture.control,
          in_unit(gesture.value, gesture.unit));
  }

  void add_network(const NetworkVerdict& network) {
    const bool first = &network == &verdict_.networks.front() || (&network - 1)->path != network.path;
    if (first && network.stability() != Stability::Stable && !network.within_steps()) add_contacts(network);
    if (!network.grows) return;
    add("network '{}' ({}) is unstable by itself: spectral radius {:.9g}", network.path, network.regime,
        network.radius);
    if (!network.weakest.empty()) lines_.back() += ", mode of " + network.weakest;
    if (network.needed_hz && std::isfinite(*network.needed_hz))
      lines_.back() += fmt::format("; it needs {}: oversample = {:.0f}, or solver = \"passive\"",
                                   prefixed(*network.needed_hz, "Hz"),
                                   std::ceil(*network.needed_hz / verdict_.rate.value));
  }

  void add_contacts(const NetworkVerdict& network) {
    if (network.contact_steps < network.needed_contact_steps)
      add("network '{}': a strike at 1 m/s lasts {:.2g} steps, fewer than {:.2g}, so explicit contacts add "
          "energy; use oversample = {:.0f}, or solver = \"passive\"",
          network.path, network.contact_steps, network.needed_contact_steps,
          std::ceil(network.needed_contact_steps / network.contact_steps));
    else
      add("network '{}': its initial state or a strike at 1 m/s compresses a contact that is too stiff for "
          "explicit "
          "steps, which then add energy; use more steps, or solver = \"passive\"",
          network.path);
    if (network.stability() == Stability::Undecided)
      lines_.back() += "; undecided: thrown at 1 m/s it does not grow in 200000 frames, at 1.2 m/s it does";
  }

  void add_critical() {
    const auto& [regime, loop, stiff, border] = critical_;
    if (stiff != nullptr)
      add("most critical: {} '{}' ({}), which {} {} and is stable up to {}", stiff->type, stiff->path,
          regime->name, stiff->stiffness < 0 ? "pushes away with" : "has",
          stiffness_text(*stiff, stiff->stiffness), stiffness_text(*stiff, stiff->stable_up_to));
    else if (loop != nullptr)
      add("most critical ({}): the loop {}, unstable above {:.3g} times its gain", regime->name,
          fmt::join(loop->way, " -> "), border);
  }

  void add_remedies() {
    std::vector<std::string> remedies;
    if (critical_.regime == nullptr)
      for (const auto& regime : verdict_.regimes)
        for (const auto& stiff : regime.stiff)
          if (!regime.held && !regime.is_stable())
            remedies.push_back(fmt::format("give '{}' less than its {} (it increases together with others)",
                                           stiff.path, stiffness_text(stiff, stiff.stiffness)));
    if (critical_.stiff != nullptr)
      remedies.push_back(fmt::format("give '{}' less than {}", critical_.stiff->path,
                                     stiffness_text(*critical_.stiff, critical_.stiff->stable_up_to)));
    if (critical_.loop != nullptr)
      remedies.push_back(fmt::format("use less than {:.3g} times the gain", critical_.border));
    for (const auto& control : verdict_.controls)
      if (control.border)
        remedies.push_back(fmt::format("set '{}' {}", control.control.name, stable_values(control)));
    if (verdict_.delay_s > 0) remedies.emplace_back("shorten the delay");
    if (!remedies.empty()) add("remedies, one of: {}", fmt::join(remedies, "; "));
  }

  /// "below 3 N"; "to 0 N" where only this end of the range is stable.
  static std::string stable_values(const ControlVerdict& verdict) {
    const auto& [low, high] = verdict.control.range;
    const double end = verdict.stable_low ? low : high;
    const bool only = std::abs(*verdict.border - end) <= 1e-6 * (high - low);
    return fmt::format("{} {}",
                       only                 ? "to"
                       : verdict.stable_low ? "below"
                                            : "above",
                       in_unit(only ? end : *verdict.border, verdict.control.unit));
  }

  void add_delay_margin() {
    const auto& loops = verdict_.regimes.front().loops;
    if (std::ranges::count(loops, true, &LoopVerdict::drive) > 1)
      return add(
          "several drives: each margin is for one drive alone; the gain and delay margins of all drives "
          "together are smaller");
    if (critical_.regime == nullptr) return;
    const auto& own = critical_.regime->loops;
    const auto drive = std::ranges::find(own, true, &LoopVerdict::drive);
    if (drive != own.end() && drive->margin.more_delay_s > 0 && std::isfinite(drive->margin.more_delay_s))
      add("delay margin: {}", prefixed(drive->margin.more_delay_s, "s"));
  }

  void add_controls() {
    for (const auto& control : verdict_.controls)
      if (control.border)
        add("stable with control '{}' {} {}", control.control.name, control.stable_low ? "up to" : "from",
            in_unit(*control.border, control.control.unit));
  }

  /// Of each spring the least stable stiffness over all regimes in which a fingertip holds the device.
  void add_held() {
    std::vector<const StiffVerdict*> least;
    for (const auto& regime : verdict_.regimes)
      for (const auto& stiff : regime.stiff) {
        if (!regime.held) continue;
        const auto known = std::ranges::find(least, stiff.path, &StiffVerdict::path);
        if (known == least.end())
          least.push_back(&stiff);
        else if (stiff.stable_up_to < (*known)->stable_up_to)
          *known = &stiff;
      }
    for (const auto* stiff : least) {
      add("held by a fingertip, '{}' is stable up to {}", stiff->path,
          stiffness_text(*stiff, stiff->stable_up_to));
      if (stiff->passive_up_to)
        lines_.back() += ", and is passive up to " + stiffness_text(*stiff, *stiff->passive_up_to);
    }
  }

  /// Those with a hold limit the rate of events; the others are listed only if none has one.
  void add_events() {
    const bool limited =
        std::ranges::any_of(verdict_.events, [](const auto& event) { return event.on_loop && event.hold_s; });
    for (const auto& place : verdict_.events) {
      if (!place.on_loop || place.hold_s.has_value() != limited) continue;
      add("the loop through {} '{}' is event-driven: no small-signal gain exists", place.type, place.path);
      if (limited && *place.hold_s > 0)
        lines_.back() +=
            fmt::format("; its 'hold' time limits it to {:.4g} events per second", 1 / *place.hold_s);
    }
  }

  /// Of an instrument alone, without a plant.
  void add_outside() {
    if (verdict_.outside_known) return;
    add("not analysed: the external path from the outputs to the inputs; check a scene with a plant instead "
        "(for outputs in N and inputs in m, a device is assumed)");
    for (const auto& pair : verdict_.open)
      add("{} -> {}: gain at most {:.3g} (at {}): stable at every delay if the external gain is below {:.3g}",
          pair.input, pair.output, pair.peak, prefixed(pair.peak_hz, "Hz"), 1 / pair.peak);
  }

  const StabilityVerdict& verdict_;
  const Critical critical_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> describe(const StabilityVerdict& verdict) { return Report{verdict}.run(); }

}  // namespace tactus
