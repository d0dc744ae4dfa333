#include "apps/actuators/scene_verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "apps/actuators/actuator_text.h"
#include "engine/guard/drive_guard.h"

namespace tactus::app {
namespace {

constexpr double kLimitedShare = 1e-3;    // of the frames: fewer are not felt
constexpr double kEdgeUncertainty = 0.1;  // of the ends of a band that were not read in a source
constexpr int kBlock = 64;

/// The limits of the scene where its profile has the figures of the actuator's, whatever its name and place.
const DriveLimits* own_limits(const Drive& drive, const Actuator& actuator) {
  const auto found = std::ranges::find_if(
      drive.profiles, [&](const DriveProfile& profile) { return profile.figures == actuator.profile; });
  return found == drive.profiles.end() ? nullptr : &found->limits;
}

/// Those, else the limits with full scale at the largest voltage. It must have a profile.
DriveLimits limits_of(const Drive& drive, const Actuator& actuator) {
  const auto* own = own_limits(drive, actuator);
  return own != nullptr ? *own : limits_for(*actuator.profile, actuator.profile->at("drive.peak"));
}

/// The largest force on the case of an actuator in a scene; nothing: no profile of it has a moving mass.
std::optional<double> force_on_case(const Actuator& actuator, const Drive& drive, double rate_hz) {
  if (!actuator.profile || !actuator.profile->contains("travel.mass")) return std::nullopt;
  return drive.force_on_case(*limits_of(drive, actuator).excursion, actuator.profile->at("travel.mass"),
                             rate_hz);
}

/// As they are printed: what differs by less is equal.
bool exceeds(double needed, double has) { return three_digits(needed) > three_digits(has); }

/// Whether the plant of the scene is that of the actuator, or its drives have the profile of the actuator.
bool is_simulated(const Actuator& actuator, const Demand& demand) {
  std::error_code none;
  const auto plant = actuator.file.parent_path() / actuator.figures.plant;
  const auto is_plant = [&](const std::string& file) {
    return std::filesystem::equivalent(plant, file, none);
  };
  const auto has_profile = [&](const Drive& drive) { return own_limits(drive, actuator) != nullptr; };
  return (!actuator.figures.plant.empty() && std::ranges::any_of(demand.plants, is_plant)) ||
         std::ranges::all_of(demand.drives, has_profile);
}

class Comparison {
 public:
  Comparison(const Actuator& actuator, const Demand& demand)
      : actuator_(actuator), demand_(demand), simulated_(is_simulated(actuator, demand)) {}

  Verdict run() {
    if (compare_motion()) {
      compare_force();
      compare_travel();
    }
    if (demand_.senses && figures_.no_sensor && !simulated_) against("it needs a sensor of its own");
    if (!figures_.band.high && !is_followed()) open("band");
    for (const auto& drive : demand_.drives) is_followed() ? compare_changes(drive) : compare_band(drive);
    // The scene was played with this actuator, and with its sensor.
    if (simulated_) verdict_.open.clear();
    if (!actuator_.profile) open("drive guard");
    for (const auto& drive : demand_.drives)
      if (actuator_.profile) compare_guard(drive);
    compare_stability();
    return std::move(verdict_);
  }

 private:
  template <class... Args>
  void against(fmt::format_string<Args...> format, Args&&... args) {
    verdict_.against.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
  void open(const char* what) { verdict_.open.emplace_back(what); }

  /// False: it moves in another way, and its forces and ways are others.
  bool compare_motion() {
    if (demand_.rotates() && !figures_.rotates())
      return against("the scene turns, and it moves along a line"), false;
    if (demand_.moves_straight() && figures_.rotates() && !figures_.arm)
      return against("the scene moves along a line, and it turns without an arm"), false;
    return true;
  }

  void compare_force() {
    if (demand_.force) compare_largest("force", "N", *demand_.force, figures_.force.high);
    if (demand_.torque) compare_largest("torque", "N m", *demand_.torque, figures_.torque());
    if (demand_.force || demand_.torque) return;
    demand_.case_force ? compare_case_force() : open("force");
  }

  /// `needed`: largest of the scene; `has`: of the actuator.
  void compare_largest(const char* what, const char* unit, double needed, std::optional<double> has) {
    if (!has) return open(what);
    if (exceeds(needed, *has))
      against("the {} reaches {}, and it has {}", what, number_text(needed, unit), number_text(*has, unit));
  }

  /// By the models of both; of an actuator without one, the figure.
  void compare_case_force() {
    std::optional<double> given;
    for (const auto& drive : demand_.drives)
      if (const auto force = force_on_case(actuator_, drive, demand_.rate_hz))
        given = std::max(given.value_or(0.0), *force);
    if (!given) return compare_largest("force", "N", *demand_.case_force, figures_.force.high);
    if (exceeds(*demand_.case_force, *given))
      against("the force reaches {}, and with this drive it gives {}", number_text(*demand_.case_force, "N"),
              number_text(*given, "N"));
  }

  void compare_travel() {
    const auto& has = figures_.excursion.high;
    if (!demand_.travel && !demand_.angle) {
      // Without a sensor the plant moves by its drive alone, and the drive guard compares its excursion.
      const bool guarded = actuator_.profile && actuator_.profile->contains("travel.limit");
      if (demand_.senses || !(figures_.turns_without_end() || guarded)) open("travel");
      return;
    }
    if (figures_.turns_without_end()) return;  // the tip of an arm goes as far as its angle
    if (demand_.angle || !has) return open("travel");
    if (exceeds(*demand_.travel, *has))
      against("the plant moves {} to either side, and it has {}", number_text(*demand_.travel, "m"),
              number_text(*has, "m"));
  }

  /// A force that is held must have the frequencies of the drive; otherwise a vibration may follow it.
  bool is_followed() const { return figures_.drive_to && !demand_.holds_force(); }

  /// A scene may drive its own actuator faster than that, by overdrive and brake.
  void compare_changes(const Drive& drive) {
    const double high = drive.band().high;
    if (!simulated_ && exceeds(high, *figures_.drive_to))
      against("'{}' changes at up to {}, and it follows changes up to {}", drive.name,
              number_text(high, "Hz"), number_text(*figures_.drive_to, "Hz"));
  }

  void compare_band(const Drive& drive) {
    const auto band = drive.band();
    const auto& has = figures_.band;
    const double slack = has.kind == ActuatorFigure::Kind::Sheet ? 0.0 : kEdgeUncertainty;
    if (has.high && exceeds(band.high, *has.high))
      (exceeds(band.high, *has.high * (1 + slack)) ? verdict_.against : verdict_.close)
          .push_back(fmt::format("'{}' reaches up to {}, and it moves up to {}", drive.name,
                                 number_text(band.high, "Hz"), number_text(*has.high, "Hz")));
    if (has.low && exceeds(*has.low, band.low))
      (exceeds(*has.low * (1 - slack), band.low) ? verdict_.against : verdict_.close)
          .push_back(fmt::format("{:.0f} % of the energy of '{}' lies below {}, where its band begins",
                                 100 * drive.spectrum.share_below(*has.low), drive.name,
                                 number_text(*has.low, "Hz")));
  }

  /// What the drive guard does to a drive.
  void compare_guard(const Drive& drive) {
    DriveGuard guard{
        DriveGuard::Kind::Drive, limits_of(drive, actuator_), Hertz{demand_.rate_hz}, {false, false}};
    guard.set_open(true, 0);
    guard.skip_soft_start();
    auto samples = drive.samples;
    for (std::size_t at = 0; at < samples.size(); at += kBlock)
      guard.process(samples.data() + at, static_cast<int>(std::min<std::size_t>(kBlock, samples.size() - at)),
                    static_cast<std::int64_t>(at));
    const auto counts = guard.counts();
    for (std::size_t stage = 0; stage < kGuardStages; ++stage) {
      const double share = static_cast<double>(counts[stage].frames) / static_cast<double>(samples.size());
      if (share >= kLimitedShare)
        against("its drive guard limits '{}' for {:.1f} % of the time ({})", drive.name, 100 * share,
                name_of(GuardStage::Index{stage}));
    }
  }

  /// A stable scene is stable with the actuator that it simulates; with the mass of another one that is not
  /// known.
  void compare_stability() {
    if (!demand_.senses) return;
    if (demand_.stability == Stability::Unstable)
      against("the scene is unstable (see tactus check)");
    else if (!simulated_ || demand_.stability != Stability::Stable)
      open("stability");
  }

  const Actuator& actuator_;
  const ActuatorFigures& figures_ = actuator_.figures;
  const Demand& demand_;
  const bool simulated_;
  Verdict verdict_;
};

}  // namespace

std::optional<double> force_on_case(const std::vector<Actuator>& all, const Demand& demand) {
  double most = 0.0;
  for (const auto& drive : demand.drives) {
    const auto own = std::ranges::find_if(
        all, [&](const Actuator& actuator) { return own_limits(drive, actuator) != nullptr; });
    if (own == all.end()) return std::nullopt;
    const auto force = force_on_case(*own, drive, demand.rate_hz);
    if (!force) return std::nullopt;
    most = std::max(most, *force);
  }
  return most;
}

Verdict compare(const Actuator& actuator, const Demand& demand) { return Comparison{actuator, demand}.run(); }

std::string Verdict::text() const {
  auto parts = against;
  if (parts.empty() && (!close.empty() || !open.empty())) parts.emplace_back("no objection");
  if (!close.empty()) parts.push_back(fmt::format("at the edge of its band: {}", fmt::join(close, ", ")));
  if (!open.empty()) parts.push_back(fmt::format("not compared: {}", fmt::join(open, ", ")));
  return parts.empty() ? "renders it" : fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace tactus::app
