#include "engine/rig/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "engine/core/index.h"
#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "engine/graph/file/error_list.h"
#include "engine/graph/file/quantity.h"

namespace tactus {
namespace {

constexpr double kNone = std::numeric_limits<double>::infinity();

/// A limit: a column of the tables below.
struct LimitType {
  const char* name;
  const char* unit;
  bool raisable;
  /// The lower, the stricter; kNone: there is no such limit.
  double (*strictness)(const DriveLimits&);
  void (*copy)(const DriveLimits& from, DriveLimits& to);
  /// nullptr: there is no such limit.
  double* (*value)(DriveLimits&);
};

const std::array<LimitType, 8> kLimits = {{
    {"ceiling", "", true, [](const DriveLimits& l) { return l.ceiling; },
     [](const DriveLimits& from, DriveLimits& to) { to.ceiling = from.ceiling; },
     [](DriveLimits& l) { return &l.ceiling; }},
    {"slew", "", true, [](const DriveLimits& l) { return l.slew_per_second; },
     [](const DriveLimits& from, DriveLimits& to) { to.slew_per_second = from.slew_per_second; },
     [](DriveLimits& l) { return &l.slew_per_second; }},
    {"power", "W", true,
     [](const DriveLimits& l) {
       return l.heat ? l.heat->watts_for_ever / l.heat->watts_at_full_scale : kNone;
     },
     [](const DriveLimits& from, DriveLimits& to) { to.heat = from.heat; },
     [](DriveLimits& l) { return l.heat ? &l.heat->watts_for_ever : nullptr; }},
    {"travel", "m", true,
     [](const DriveLimits& l) {
       return l.excursion ? l.excursion->metres / l.excursion->metres_at_full_scale : kNone;
     },
     [](const DriveLimits& from, DriveLimits& to) { to.excursion = from.excursion; },
     [](DriveLimits& l) { return l.excursion ? &l.excursion->metres : nullptr; }},
    {"direct_level", "", true, [](const DriveLimits& l) { return l.dc.level < 1.0 ? l.dc.level : kNone; },
     [](const DriveLimits& from, DriveLimits& to) { to.dc.level = from.dc.level; },
     [](DriveLimits& l) { return &l.dc.level; }},
    {"direct_time", "s", true,
     [](const DriveLimits& l) { return l.dc.level < 1.0 ? l.dc.time.value : kNone; },
     [](const DriveLimits& from, DriveLimits& to) { to.dc.time = from.dc.time; },
     [](DriveLimits& l) { return &l.dc.time.value; }},
    {"soft_start", "s", false, [](const DriveLimits& l) { return -l.soft_start.value; },
     [](const DriveLimits& from, DriveLimits& to) { to.soft_start = from.soft_start; },
     [](DriveLimits& l) { return &l.soft_start.value; }},
    {"fade_out", "s", false, [](const DriveLimits& l) { return l.fade_out.value; },
     [](const DriveLimits& from, DriveLimits& to) { to.fade_out = from.fade_out; },
     [](DriveLimits& l) { return &l.fade_out.value; }},
}};

/// Which source states which limit: a row for each LimitSource::Kind, a column for each of kLimits.
constexpr std::array<std::string_view, 6> kSources = {
    // ceiling, slew, power, travel, direct_level, direct_time, soft_start, fade_out
    "xxxxxxxx",  // Profile
    "x.......",  // Ceiling
    "xxxxxxxx",  // Take
    "xx..xxxx",  // Drive
    "x...xxxx",  // UnknownSound
    "......xx",  // Sound
};

/// What the guard of an output keeps, and the source that is always there: a row for each OutputTarget.
struct TargetType {
  std::string_view keeps;  ///< a column for each of kLimits
  DriveGuard::Kind guard;
  LimitSource::Kind built_in;
  bool yields_to_profile;  ///< the built-in limits are a guess, which a profile replaces
  const char* built_in_name;
};
constexpr std::array<TargetType, 3> kTargets = {{
    {"xxxxxxxx", DriveGuard::Kind::Drive, LimitSource::Kind::Drive, true,
     "the built-in limits of a drive without a profile"},
    {"x.....xx", DriveGuard::Kind::Audio, LimitSource::Kind::Sound, false, "the built-in limits of sound"},
    {"xxxxxxxx", DriveGuard::Kind::Drive, LimitSource::Kind::UnknownSound, false,
     "the built-in limits of sound without a rig"},
}};

/// Actuators need half a second before a hand; an ear needs no click.
constexpr Seconds kSoundSoftStart{0.1};

DriveLimits built_in_limits(LimitSource::Kind kind) {
  return kind == LimitSource::Kind::Sound ? DriveLimits{.soft_start = kSoundSoftStart}
                                          : conservative_limits();
}

/// The limits of the actuator itself, instead of a guess.
bool describes_actuator(const LimitSource& source) {
  return source.kind == LimitSource::Kind::Profile || source.kind == LimitSource::Kind::Take;
}

std::vector<LimitSource> with_built_in(const TargetType& target, std::vector<LimitSource> sources) {
  if (!target.yields_to_profile || std::ranges::none_of(sources, describes_actuator))
    sources.push_back({target.built_in, target.built_in_name, built_in_limits(target.built_in)});
  return sources;
}

/// nullptr: none of them states it.
const LimitSource* strictest(std::size_t limit, const std::vector<LimitSource>& sources) {
  const LimitSource* found = nullptr;
  double least = kNone;
  for (const auto& source : sources) {
    if (kSources[static_cast<std::size_t>(source.kind)][limit] != 'x') continue;
    const double here = kLimits[limit].strictness(source.limits);
    if (here >= least) continue;  // not a NaN, which `check` refuses
    least = here;
    found = &source;
  }
  return found;
}

std::vector<std::string> raisable_names() {
  std::vector<std::string> names;
  for (const auto& type : kLimits)
    if (type.raisable) names.emplace_back(type.name);
  return names;
}

LimitOrigin* origin_of(GuardedChannel& channel, const char* limit) {
  const auto found = std::ranges::find(channel.origins, limit, &LimitOrigin::limit);
  return found == channel.origins.end() ? nullptr : &*found;
}

bool is_lane_of(const std::string& channel, const std::string& output) {
  return channel == output || port_of(channel) == output;
}

bool concerns(const LimitRaise& raise, const LimitedOutput& output) {
  return raise.output.empty() ? output.use == OutputUse::Drive : is_lane_of(output.name, raise.output);
}

Status report_unconcerned(const LimitRaise& raise, const std::vector<LimitedOutput>& outputs) {
  const auto names = names_of(outputs);
  if (raise.output.empty())
    return fail(
        Errc::UnknownName, "--raise-limit", "there is no drive whose '" + raise.limit + "' could be raised",
        names.empty() ? "omit it"
                      : "name the output, as in " + names.front() + "." + raise.limit + "=" + raise.value);
  return fail(Errc::UnknownName, "--raise-limit", "there is no output '" + raise.output + "'",
              suggest(raise.output, names));
}

}  // namespace

GuardedChannel combine_limits(OutputTarget target, const std::vector<LimitSource>& sources) {
  const auto& type = kTargets[static_cast<std::size_t>(target)];
  const auto all = with_built_in(type, sources);
  GuardedChannel channel{type.guard, {}};
  for (std::size_t limit = 0; limit < kLimits.size(); ++limit) {
    const auto* source = type.keeps[limit] == 'x' ? strictest(limit, all) : nullptr;
    if (source == nullptr) continue;
    const auto& [name, unit, raisable, strictness, copy, value] = kLimits[limit];
    copy(source->limits, channel.limits);
    channel.origins.push_back({name, *value(channel.limits), source->name});
  }
  return channel;
}

Status raise_limit(GuardedChannel& channel, const std::string& limit, const std::string& text,
                   const std::string& where) {
  const auto* type = find_named(kLimits, limit);
  const auto names = raisable_names();
  if (type == nullptr || !type->raisable)
    return fail(Errc::UnknownName, where, "there is no limit '" + limit + "'", "there are " + listed(names));
  const auto value = read_quantity(Value{text, {}}, *parse_unit(type->unit), limit);
  if (!value) return tl::unexpected(value.error().at(where));
  auto* const origin = origin_of(channel, type->name);
  if (origin == nullptr)
    return fail(Errc::OutOfRange, where, "this output has no limit on '" + limit + "' to raise", "remove it");
  auto raised = channel.limits;
  double& now = *type->value(raised);
  if (!(*value > now))
    return fail(Errc::OutOfRange, where, "'" + limit + "' is already " + short_number(now),
                "a limit can only be raised here");
  const double before = std::exchange(now, *value);
  if (auto status = check(raised); !status) return tl::unexpected(status.error().at(where));
  channel.limits = raised;
  origin->value = *value;
  if (!origin->raised_from) origin->raised_from = before;
  return {};
}

std::string limit_text(const std::string& limit, double value) {
  const auto* type = find_named(kLimits, limit);
  return short_quantity(value, type == nullptr ? Dimension{} : parse_unit(type->unit)->dimension);
}

GuardedChannel LimitBook::raised(const LimitedOutput& output, std::size_t raise_count) const {
  auto found = named.find(output.name);
  if (found == named.end()) found = named.find(port_of(output.name));
  auto sources = found == named.end() ? std::vector<LimitSource>{} : found->second;
  const bool drive = output.use == OutputUse::Drive;
  if (drive) sources.insert(sources.end(), drives.begin(), drives.end());
  auto channel = combine_limits(drive         ? OutputTarget::Drive
                                : sound_known ? OutputTarget::Sound
                                              : OutputTarget::UnknownSound,
                                sources);
  for (std::size_t r = 0; r < raise_count; ++r)
    if (concerns(raises[r], output)) (void)raise_limit(channel, raises[r].limit, raises[r].value, {});
  return channel;
}

GuardedChannel LimitBook::of(const LimitedOutput& output) const { return raised(output, raises.size()); }

Status LimitBook::check_raises(const std::vector<LimitedOutput>& outputs) const {
  for (std::size_t r = 0; r < raises.size(); ++r) {
    std::vector<Status> results;
    for (const auto& output : outputs) {
      if (!concerns(raises[r], output)) continue;
      auto channel = raised(output, r);
      results.push_back(raise_limit(channel, raises[r].limit, raises[r].value, "--raise-limit"));
    }
    if (results.empty()) return report_unconcerned(raises[r], outputs);
    const auto is_error = [](const Status& status) { return !status; };
    if (std::ranges::all_of(results, is_error)) return results.front();
  }
  return {};
}

}  // namespace tactus
