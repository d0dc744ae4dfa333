#include "engine/guard/drive_limits.h"

#include <initializer_list>

#include "engine/guard/guard_group.h"
#include "engine/guard/heat_limiter.h"

namespace tactus {
namespace {

// Written so that a NaN is outside of everything.
bool positive(double x) { return x > 0.0 && x < std::numeric_limits<double>::infinity(); }
bool within(double x, double low, double high) { return x >= low && x <= high; }

constexpr double kShortestTime_s = 0.01;
constexpr double kLongestTime_s = 1e6;
constexpr double kLongestFall_s = 60.0;

struct Rule {
  bool satisfied;
  const char* violation;
  const char* remedy = "";
};

Status first_violation(std::initializer_list<Rule> rules) {
  for (const auto& rule : rules)
    if (!rule.satisfied) return fail(Errc::OutOfRange, "", rule.violation, rule.remedy);
  return {};
}

Status check(const HeatLimits& heat, double ceiling, double slew_per_second, Hertz sample_rate) {
  return first_violation(
      {{positive(heat.watts_at_full_scale) && positive(heat.watts_for_ever) && positive(heat.rise_kelvin),
        "the powers and the temperature rise of a drive's heat limit must be positive"},
       {within(heat.coil_time.value, kShortestTime_s, kLongestTime_s) &&
            within(heat.body_time.value, kShortestTime_s, kLongestTime_s),
        "the time constants of a drive's heat limit must be between 10 ms and 1e6 s"},
       {heat.coil_share > 0.0 && heat.coil_share < 1.0,
        "the coil's share of a drive's temperature rise must be between 0 and 1"},
       {!(fastest_rise(heat, ceiling) * kGuardGroup / sample_rate.value > 0.125),
        "the coil of a drive would overheat before the guard could act",
        "lower its ceiling or the volts per full scale"},
       {!(rise_on_the_way_down(heat, ceiling, slew_per_second) > 0.125),
        "the coil of a drive would overheat before its slew limit allows the level to fall",
        "lower its ceiling, or raise its slew limit"}});
}

Status check(const ExcursionLimits& excursion) {
  return first_violation(
      {{positive(excursion.metres) && positive(excursion.metres_at_full_scale) && positive(excursion.q),
        "the lengths and the quality factor of a drive's excursion limit must be positive"},
       {positive(excursion.resonance.value),
        "the resonance frequency of a drive's excursion limit must be positive"}});
}

}  // namespace

DriveLimits conservative_limits() {
  return {.ceiling = 0.5,
          .slew_per_second = 6300.0,
          .soft_start = Seconds{0.5},
          .fade_out = Seconds{0.01},
          .dc = {0.15, Seconds{5.0}}};
}

Status check(const DriveLimits& limits, Hertz sample_rate) {
  auto status = first_violation(
      {{limits.ceiling > 0.0 && limits.ceiling <= 1.0,
        "the ceiling of a drive must be above 0 and at most 1 full scale",
        "give it as a fraction of the converter's full scale"},
       {limits.slew_per_second > 0.0, "the slew limit of a drive must be positive",
        "omit it for no limit, or give it in full scale per second"},
       {!(limits.ceiling / limits.slew_per_second > kLongestFall_s),
        "a drive must be able to fall from its ceiling to zero within 60 s", "raise its slew limit"},
       {within(limits.soft_start.value, 0.0, 60.0),
        "the soft-start time of a drive must be between 0 s and 60 s"},
       {within(limits.fade_out.value, 0.0, 1.0), "the fade-out time of a drive must be between 0 s and 1 s"},
       {positive(limits.dc.level), "the DC level of a drive must be positive"},
       {within(limits.dc.time.value, 0.0, 3600.0), "the DC time of a drive must be between 0 s and 1 h"}});
  if (status && limits.heat)
    status = check(*limits.heat, limits.ceiling, limits.slew_per_second, sample_rate);
  if (status && limits.excursion) status = check(*limits.excursion);
  return status;
}

}  // namespace tactus
