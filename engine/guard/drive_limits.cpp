#include "engine/guard/drive_limits.h"

#include <string>

#include "engine/guard/guard_group.h"
#include "engine/guard/heat_limiter.h"

namespace tactus {
namespace {

// Written so that a NaN lies outside of everything.
bool positive(double x) { return x > 0.0 && x < std::numeric_limits<double>::infinity(); }
bool within(double x, double low, double high) { return x >= low && x <= high; }

constexpr double kShortestTime_s = 0.01;
constexpr double kLongestTime_s = 1e6;

Status refuse(const std::string& what, const std::string& remedy = {}) {
  return fail(Errc::OutOfRange, "", what, remedy);
}

Status check(const HeatLimits& heat, double ceiling, double slew_per_second, Hertz sample_rate) {
  if (!positive(heat.watts_at_full_scale) || !positive(heat.watts_for_ever) || !positive(heat.rise_kelvin))
    return refuse("a power or a rise in the heat limit of a drive is not positive");
  if (!within(heat.coil_time.value, kShortestTime_s, kLongestTime_s) ||
      !within(heat.body_time.value, kShortestTime_s, kLongestTime_s))
    return refuse("a time constant in the heat limit of a drive lies outside 10 ms to a million seconds");
  if (!(heat.coil_share > 0.0 && heat.coil_share < 1.0))
    return refuse("the coil's share of the heat of a drive lies outside 0 to 1");
  if (fastest_rise(heat, ceiling) * kGuardGroup / sample_rate.value > 0.125)
    return refuse("the coil of a drive would burn before the guard could act",
                  "lower its ceiling or the volts per full scale");
  if (rise_on_the_way_down(heat, ceiling, slew_per_second) > 0.125)
    return refuse("the coil of a drive would burn before its slew limit lets it come down",
                  "lower its ceiling, or let it move faster");
  return {};
}

Status check(const ExcursionLimits& travel) {
  if (!positive(travel.metres) || !positive(travel.metres_at_full_scale) || !positive(travel.q))
    return refuse("a length or the quality factor in the travel limit of a drive is not positive");
  if (!positive(travel.resonance.value))
    return refuse("the resonance in the travel limit of a drive is not positive");
  return {};
}

}  // namespace

DriveLimits cautious_limits() {
  DriveLimits limits;
  limits.ceiling = 0.5;
  limits.slew_per_second = 1000.0;
  limits.soft_start = Seconds{0.5};
  limits.fade_out = Seconds{0.01};
  limits.dc = {0.15, Seconds{5.0}};
  return limits;
}

Status check(const DriveLimits& limits, Hertz sample_rate) {
  if (!(limits.ceiling > 0.0 && limits.ceiling <= 1.0))
    return refuse("the ceiling of a drive lies outside (0, 1] full scale",
                  "give it as a fraction of what the converter can put out");
  if (!(limits.slew_per_second > 0.0))
    return refuse("the slew limit of a drive is not positive",
                  "leave it out for no limit, or give full scales a second");
  if (!within(limits.soft_start.value, 0.0, 60.0))
    return refuse("the soft start of a drive lies outside 0 s to 60 s");
  if (!within(limits.fade_out.value, 0.0, 1.0))
    return refuse("the fade out of a drive lies outside 0 s to 1 s");
  if (!positive(limits.dc.level)) return refuse("the level of direct current of a drive is not positive");
  if (!within(limits.dc.time.value, 0.0, 3600.0))
    return refuse("the time of direct current of a drive lies outside 0 s to an hour");
  if (limits.heat)
    if (auto status = check(*limits.heat, limits.ceiling, limits.slew_per_second, sample_rate); !status)
      return status;
  if (limits.excursion)
    if (auto status = check(*limits.excursion); !status) return status;
  return {};
}

}  // namespace tactus
