#pragma once

// Thread: [control]

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "engine/guard/guarded.h"
#include "engine/rig/profile.h"
#include "engine/scene/file/scene_spec.h"

namespace tactus {

/// What the guard of one output did.
struct GuardedOutput {
  std::string name;
  GuardCounts counts;
  ThermalState heat;
  double rise_kelvin = 0;             ///< above the room, at the end; 0 without a heat limit
  std::vector<LimitOrigin> limits{};  ///< that it kept
};

/// What all guards of a run did.
struct GuardReport {
  std::vector<GuardedOutput> outputs;
  std::vector<GuardEvent> events;        ///< oldest first
  std::vector<std::string> input_names;  ///< of the channels of events

  /// True if no stage had anything to do and nothing faded.
  bool idle() const;
  /// True if --raise-limit raised a limit.
  bool any_raised() const;
  /// True if outputs were faded out: by feedback, since a sensor failed, or by the dead man's switch.
  bool faded() const { return !events.empty(); }
};

/// "nonfinite", "heat", "direct", "travel", "ceiling", "slew"
const char* name_of(GuardStage::Index stage);
/// "howl", "sensor railed", "sensor stuck", "stop inputs blocked", "stop inputs blocked for 5 s"
const char* name_of(GuardEvent::Kind kind);

/// Names of the outputs that a schedule gives to the outside.
std::vector<std::string> output_names(const Plan& schedule);
/// Of those, the monitor outputs: the one with the role "monitor" if it is of kind "audio"; without it all
/// of that kind. A carrier for a sensor is of that kind too.
std::vector<std::string> sound_names(const Plan& schedule, const std::vector<Role>& roles = {});
/// The same, with what the limits of an output depend on.
std::vector<LimitedOutput> limited_outputs(const Plan& schedule);
/// Their guards.
std::vector<GuardedChannel> guarded_channels(const Plan& schedule, const LimitBook& drives);

/// [control, one thread] Names stand for channels, in their order. Takes the events out of `guarded`.
GuardReport report_of(Guarded& guarded, const std::vector<GuardedChannel>& channels,
                      std::vector<std::string> inputs, const std::vector<std::string>& outputs);
/// The same for what `guarded_channels` gave.
GuardReport report_of(Guarded& guarded, const Plan& schedule, const LimitBook& drives);

/// The limits of outputs, a line each: "woofer: ceiling 0.8 of [outputs] woofer; slew 500 … of profile
/// 'woofer' of [outputs] woofer".
std::vector<std::string> describe_limits(const std::vector<std::string>& outputs,
                                         const std::vector<GuardedChannel>& channels);
/// Those that --raise-limit raised: "woofer: the limit 'ceiling' is raised from 0.5 (…) to 0.8".
std::vector<std::string> describe_raises(const std::string& output, const std::vector<LimitOrigin>& limits);

/// As text, a line each: "woofer: the excursion limit attenuated it for 0.42 s, by up to 0.3 full scale; …",
/// with where the limit is from and what would allow more.
std::vector<std::string> describe(const GuardReport& report, Hertz sample_rate);

}  // namespace tactus
