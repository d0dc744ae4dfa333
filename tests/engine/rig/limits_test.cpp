#include "engine/rig/limits.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <map>

#include "tests/support/error_summary.h"

using namespace tactus;

namespace {

using Kind = LimitSource::Kind;
constexpr double kNone = std::numeric_limits<double>::infinity();

const std::vector<std::string> kNames = {"ceiling",      "slew",        "power",      "travel",
                                         "direct_level", "direct_time", "soft_start", "fade_out"};

/// What is compared: of heat and excursion the share of full scale that may last; the longest soft start is
/// the strictest.
std::map<std::string, double> strictness(const DriveLimits& limits) {
  const bool dc = limits.dc.level < 1;
  return {{"ceiling", limits.ceiling},
          {"slew", limits.slew_per_second},
          {"power", limits.heat ? limits.heat->watts_for_ever / limits.heat->watts_at_full_scale : kNone},
          {"travel",
           limits.excursion ? limits.excursion->metres / limits.excursion->metres_at_full_scale : kNone},
          {"direct_level", dc ? limits.dc.level : kNone},
          {"direct_time", dc ? limits.dc.time.value : kNone},
          {"soft_start", -limits.soft_start.value},
          {"fade_out", limits.fade_out.value}};
}

DriveLimits limits_of(double ceiling, double slew, double watts, double metres, double level, double dc_s,
                      double start_s, double fade_s) {
  return {.ceiling = ceiling,
          .slew_per_second = slew,
          .soft_start = Seconds{start_s},
          .fade_out = Seconds{fade_s},
          .heat = HeatLimits{50, watts, 3_s, 400_s, 0.6, 80},
          .excursion = ExcursionLimits{metres, 0.004, 40_Hz, 1},
          .dc = {level, Seconds{dc_s}}};
}

/// As a rig, a scene, a take and the command line state them; no source is the lowest in everything.
const std::vector<LimitSource> kSources = {
    {Kind::Profile, "actuator", limits_of(0.9, 300, 20, 0.003, 0.3, 2, 0.2, 0.01)},
    {Kind::Ceiling, "actuator ceiling", {.ceiling = 0.6}},
    {Kind::Profile, "output", limits_of(0.7, 500, 10, 0.004, 0.2, 3, 0.1, 0.02)},
    {Kind::Ceiling, "output ceiling", {.ceiling = 0.4}},
    {Kind::Profile, "--profile", limits_of(0.8, 400, 30, 0.001, 0.4, 1, 0.9, 0.03)},
    {Kind::Take, "take", limits_of(0.5, 900, 40, 0.002, 0.1, 4, 0.3, 0.005)},
    {Kind::Profile, "profile with the least", {.ceiling = 0.95, .soft_start = 0.05_s, .fade_out = 0.5_s}},
};

/// The table of docs/drive_guard.md.
bool states(Kind kind, const std::string& limit) {
  if (kind == Kind::Profile || kind == Kind::Take) return true;
  if (kind == Kind::Ceiling) return limit == "ceiling";
  const bool ramp = limit == "soft_start" || limit == "fade_out";
  if (kind == Kind::Sound) return ramp;
  if (limit == "slew") return kind == Kind::Drive;
  return ramp || limit == "ceiling" || limit.starts_with("direct");
}

bool kept(OutputTarget target, const std::string& limit) {
  return target != OutputTarget::Sound || limit == "ceiling" || limit == "soft_start" || limit == "fade_out";
}

std::vector<LimitSource> with_built_in(OutputTarget target, std::vector<LimitSource> sources) {
  const bool described = std::ranges::any_of(
      sources, [](const auto& source) { return source.kind == Kind::Profile || source.kind == Kind::Take; });
  if (target == OutputTarget::Drive && !described)
    sources.push_back({Kind::Drive, "", conservative_limits()});
  if (target == OutputTarget::UnknownSound)
    sources.push_back({Kind::UnknownSound, "", conservative_limits()});
  if (target == OutputTarget::Sound)
    sources.push_back({Kind::Sound, "", combine_limits(OutputTarget::Sound, {}).limits});
  return sources;
}

double expected(OutputTarget target, const std::vector<LimitSource>& sources, const std::string& limit) {
  double least = kNone;
  for (const auto& source : with_built_in(target, sources))
    if (states(source.kind, limit)) least = std::min(least, strictness(source.limits).at(limit));
  return kept(target, limit) ? least : kNone;
}

std::vector<LimitSource> chosen(unsigned bits) {
  std::vector<LimitSource> sources;
  for (std::size_t s = 0; s < kSources.size(); ++s)
    if ((bits >> s & 1) != 0) sources.push_back(kSources[s]);
  return sources;
}

const LimitOrigin* origin(const GuardedChannel& channel, const std::string& limit) {
  const auto found = std::ranges::find(channel.origins, limit, &LimitOrigin::limit);
  return found == channel.origins.end() ? nullptr : &*found;
}

}  // namespace

TEST_CASE("limits: of every combination of sources the lowest of each limit counts, and its source is named",
          "[rig]") {
  for (const auto target : {OutputTarget::Drive, OutputTarget::Sound, OutputTarget::UnknownSound})
    for (unsigned bits = 0; bits < 1u << kSources.size(); ++bits) {
      const auto sources = chosen(bits);
      const auto channel = combine_limits(target, sources);
      const auto combined = strictness(channel.limits);
      CAPTURE(static_cast<int>(target), bits);
      for (const auto& limit : kNames) {
        CAPTURE(limit);
        const double wanted = expected(target, sources, limit);
        const auto* from = origin(channel, limit);
        REQUIRE((from != nullptr) == (wanted != kNone));
        if (from == nullptr) continue;
        CHECK(combined.at(limit) == wanted);
        const auto named = std::ranges::find(sources, from->source, &LimitSource::name);
        if (named != sources.end()) CHECK(strictness(named->limits).at(limit) == wanted);
      }
      CHECK(check(channel.limits));
    }
}

TEST_CASE("limits: a built-in limit of a drive yields to a profile and to nothing else", "[rig]") {
  CHECK(combine_limits(OutputTarget::Drive, chosen(0)).limits.ceiling == conservative_limits().ceiling);
  CHECK(combine_limits(OutputTarget::Drive, chosen(2)).limits.ceiling == conservative_limits().ceiling);
  CHECK(combine_limits(OutputTarget::Drive, chosen(1)).limits.ceiling == 0.9);
  CHECK(combine_limits(OutputTarget::UnknownSound, chosen(1)).limits.ceiling ==
        conservative_limits().ceiling);
}

TEST_CASE("limits: of every combination of sources --raise-limit raises what is named and nothing else",
          "[rig]") {
  struct Raise {
    const char *limit, *value;
    double strictness;
  };
  for (unsigned bits = 0; bits < 1u << kSources.size(); ++bits)
    for (const auto& raise : {Raise{"ceiling", "0.99", 0.99}, Raise{"slew", "9000", 9000}}) {
      CAPTURE(bits, raise.limit);
      auto channel = combine_limits(OutputTarget::Drive, chosen(bits));
      const auto before = strictness(channel.limits);
      const auto status = raise_limit(channel, raise.limit, raise.value, "--raise-limit");
      REQUIRE(status.has_value() == (before.at(raise.limit) != kNone));
      if (!status) continue;
      for (const auto& limit : kNames)
        CHECK(strictness(channel.limits).at(limit) ==
              (limit == raise.limit ? raise.strictness : before.at(limit)));
      CHECK(origin(channel, raise.limit)->raised_from == before.at(raise.limit));
      CHECK(origin(channel, raise.limit)->value == raise.strictness);
    }
}

TEST_CASE("limits: only up, within sense, and only what is there", "[rig]") {
  auto channel = combine_limits(OutputTarget::Drive, {});
  const auto error = [&](const char* limit, const char* value) {
    return test::summary(raise_limit(channel, limit, value, "--raise-limit"));
  };
  CHECK(error("ceiling", "0.8").empty());
  CHECK(error("direct_time", "20 s").empty());
  CHECK(channel.limits.ceiling == 0.8);
  CHECK(channel.limits.dc.time == 20_s);
  CHECK(error("ceiling", "0.7") == "--raise-limit OutOfRange 'ceiling' 0.8");
  CHECK(error("ceiling", "1.2") == "--raise-limit OutOfRange 0 1");
  CHECK(error("travel", "8 mm") == "--raise-limit OutOfRange 'travel'");
  CHECK(error("soft_start", "9 s") ==
        "--raise-limit UnknownName 'soft_start' 'ceiling' 'slew' 'power' 'travel' 'direct_level' "
        "'direct_time'");
  CHECK(channel.limits.ceiling == 0.8);
  CHECK(origin(channel, "ceiling")->raised_from == conservative_limits().ceiling);
}

TEST_CASE("limits: a raise is for all drives, or for one output of any kind", "[rig]") {
  LimitBook book;
  book.named["sound"] = {{Kind::Ceiling, "[outputs] sound", {.ceiling = 0.1}}};
  const LimitedOutput first{"strings[1]", OutputUse::Drive}, second{"woofer", OutputUse::Drive},
      sound{"sound", OutputUse::Audio};
  const auto ceilings = [&](std::vector<LimitRaise> raises) {
    book.raises = std::move(raises);
    std::vector<double> values;
    for (const auto& output : {first, second, sound}) values.push_back(book.of(output).limits.ceiling);
    return values;
  };
  CHECK(ceilings({}) == std::vector{0.5, 0.5, 0.1});
  CHECK(ceilings({{"", "ceiling", "0.8"}}) == std::vector{0.8, 0.8, 0.1});
  CHECK(ceilings({{"strings", "ceiling", "0.7"}}) == std::vector{0.7, 0.5, 0.1});
  CHECK(ceilings({{"sound", "ceiling", "0.3"}}) == std::vector{0.5, 0.5, 0.3});
  CHECK(ceilings({{"", "ceiling", "0.8"}, {"woofer", "ceiling", "0.9"}}) == std::vector{0.8, 0.9, 0.1});

  const auto errors = [&](std::vector<LimitRaise> raises) {
    book.raises = std::move(raises);
    return test::summary(book.check_raises({first, second, sound}));
  };
  CHECK(errors({{"", "ceiling", "0.8"}, {"sound", "ceiling", "0.3"}}).empty());
  CHECK(errors({{"", "ceiling", "0.4"}}) == "--raise-limit OutOfRange 'ceiling' 0.5");
  CHECK(errors({{"", "ceiling", "0.8"}, {"", "ceiling", "0.7"}}) == "--raise-limit OutOfRange 'ceiling' 0.8");
  CHECK(errors({{"wofer", "ceiling", "0.8"}}) == "--raise-limit UnknownName 'wofer' 'woofer'");
  CHECK(test::summary(book.check_raises({sound})) == "--raise-limit UnknownName 'wofer' 'sound'");
  book.raises = {{"", "ceiling", "0.8"}};
  CHECK(test::summary(book.check_raises({sound})).starts_with("--raise-limit UnknownName 'ceiling'"));
}
