#include "latency/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "engine/core/index.h"

namespace tactus {
namespace {

constexpr double kFullScale = 0.99996;  // 16-bit converters end there
constexpr int kClippedRun = 3;          // frames at the end in a row
constexpr double kOverdriven = -20.0;   // dB of any harmonic
constexpr double kHarmonicsSnr = 10.0;  // dB of SNR
constexpr double kLeastDrift = 0.005;   // ppm: a frame in an hour; one clock has none
constexpr double kGainMoves = 0.5;      // dB
constexpr double kGainRises = 1.0;      // dB
constexpr double kCancelled = 3.0;      // dB
constexpr double kUneven = 0.1;         // misfit
constexpr double kEchoShare = 0.6, kLeastEcho = -30.0;
constexpr double kMisfit = 0.005;         // of the power: the phase is then wrong by 4 degrees somewhere
constexpr double kGainRange = 6.0;        // dB; what is between converters has less
constexpr double kFindingsCertain = 5.0;  // standard errors

constexpr const char* kAgainstOverload =
    "turn the input's gain or the output's level down, or measure with a lower --level";
constexpr const char* kAgainstAgc =
    "switch off automatic gain control, noise suppression and limiters of the input";
constexpr const char* kAgainstBackground =
    "measure while it is quiet (speech, music, machines, tapping on the sensor), or play louder";
constexpr const char* kAgainstNoise = "play louder, raise the input's gain, or find the source of the noise";

int longest_clipped_run(std::span<const double> captured) {
  int longest = 0, run = 0;
  for (std::size_t n = 0; n < captured.size(); ++n) {
    run = std::abs(captured[n]) >= kFullScale ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  return longest;
}

Finding clipping(const Analysis& analysis, std::span<const double> captured) {
  if (const int run = longest_clipped_run(captured); run >= kClippedRun)
    return {Verdict::Clipping, fmt::format("the input is at full scale for up to {} frames in a row", run),
            kAgainstOverload};
  for (std::size_t k = 0; k < analysis.harmonics_db.size() && analysis.snr_db > kHarmonicsSnr; ++k)
    if (analysis.harmonics_db[k].value_or(-1e9) > kOverdriven)
      return {Verdict::Clipping,
              fmt::format("harmonic {} is only {:.0f} dB below the probe: a stage of the path is overdriven",
                          k + 2, -*analysis.harmonics_db[k]),
              kAgainstOverload};
  return {};
}

Finding lost_frames(const Analysis& analysis) {
  if (analysis.steps.empty()) return {};
  const auto& first = analysis.steps.front();
  const auto seconds = static_cast<double>(first.frame) / analysis.sample_rate.value;
  const auto what =
      first.frames == 0.0
          ? fmt::format("the signal captured at {:.2f} s is not the played one", seconds)
          : fmt::format("at {:.2f} s the delay changes by {:+.2f} frames", seconds, first.frames);
  return {
      Verdict::LostFrames,
      what + (analysis.steps.size() > 1 ? fmt::format(", and {} more times", analysis.steps.size() - 1) : ""),
      kAgainstGaps};
}

Finding clocks_differ(const Analysis& analysis) {
  if (!analysis.compared || std::abs(analysis.drift_ppm) < kLeastDrift ||
      std::abs(analysis.drift_ppm) < kFindingsCertain * analysis.drift_standard_error_ppm)
    return {};
  return {Verdict::ClocksDiffer,
          fmt::format(
              "the delay drifts by {:.2g} ± {:.1g} ppm ({:+.2g} frames per second): input and output have "
              "separate clocks; in the middle of the measurement it was {:.2f} frames",
              analysis.drift_ppm, analysis.drift_standard_error_ppm,
              1e-6 * analysis.drift_ppm * analysis.sample_rate.value, analysis.delay_frames),
          "use the input and output of one card, or synchronise both by word clock, ADAT or S/PDIF"};
}

double mean(const std::vector<double>& values) {
  return values.empty()
             ? 0.0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  if (values.size() < 2) return 0.0;
  const double middle = mean(values);
  double squares = 0.0;
  for (const double value : values) squares += (value - middle) * (value - middle);
  return std::sqrt(squares / static_cast<double>(values.size() - 1));
}

/// The gains of probes that were played at full level, and of those that were softer by a quarter and more.
struct Gains {
  std::vector<double> loud_db, soft_db;
  double noise_db = 0.0;  ///< of a loud one, as the noise makes it

  explicit Gains(const std::vector<ProbeDelay>& probes) {
    double highest = 0.0;
    for (const auto& probe : probes) highest = std::max(highest, probe.level);
    for (const auto& probe : probes) {
      const bool loud = probe.level > 0.75 * highest;
      (loud ? loud_db : soft_db).push_back(probe.gain_db);
      if (loud) noise_db = std::max(noise_db, probe.gain_deviation_db);
    }
  }
  /// Of the mean of some of them; few may agree by chance.
  double error_of(const std::vector<double>& some, double noise) const {
    return std::max(deviation(some), noise) / std::sqrt(static_cast<double>(some.size()));
  }
  /// How much more the soft ones are amplified, when that is certain.
  double by_level() const {
    if (loud_db.empty() || soft_db.empty()) return 0.0;
    const double difference = mean(soft_db) - mean(loud_db);
    const double error = std::hypot(error_of(loud_db, noise_db), error_of(soft_db, 2.0 * noise_db));
    return std::abs(difference) > kFindingsCertain * error ? difference : 0.0;
  }
  /// By how much it rises from the first loud probe to the last, along a straight line, when that is certain.
  double rise() const {
    const auto count = static_cast<double>(loud_db.size());
    if (count < 4) return 0.0;
    const double middle = 0.5 * (count - 1.0), level = mean(loud_db);
    double times = 0.0, common = 0.0, squares = 0.0;
    for (std::size_t n = 0; n < loud_db.size(); ++n) {
      const double time = static_cast<double>(n) - middle;
      times += time * time;
      common += time * (loud_db[n] - level);
      squares += (loud_db[n] - level) * (loud_db[n] - level);
    }
    const double slope = common / times;
    const double scatter = std::sqrt(std::max(0.0, squares - slope * common) / (count - 2.0));
    const double error = std::max(scatter, noise_db) / std::sqrt(times);
    return slope > kFindingsCertain * error ? slope * (count - 1.0) : 0.0;
  }
  double fall() const { return loud_db.empty() ? 0.0 : loud_db.front() - loud_db.back(); }
};

Finding moving_gain(const Analysis& analysis, const Evidence& evidence) {
  const Gains gains{analysis.probes};
  const double by_level = gains.by_level();
  const double before =
      evidence.level_probe_gain_db ? *evidence.level_probe_gain_db - mean(gains.loud_db) : 0.0;
  const double fall = std::max(gains.fall(), before);
  const bool falls = fall > kCancelled;
  if (!falls && gains.rise() > kGainRises)
    return {Verdict::Agc,
            fmt::format("the gain rises by {:.1f} dB while the played level is constant", gains.rise()),
            kAgainstAgc};
  if (!falls && std::abs(by_level) < kGainMoves) return {};
  // A gain that follows the level keeps the path's shape; a canceller takes away what it has learnt, part by
  // part.
  if (falls && (analysis.misfit > kUneven || std::abs(by_level) < kGainMoves))
    return {Verdict::EchoCancel,
            fmt::format("the gain of the path falls by {:.1f} dB during the recording", fall),
            "switch off echo cancellation in the settings of the driver or the sound server, or choose the "
            "device itself instead of one for calls"};
  return {Verdict::Agc,
          fmt::format("lower levels are amplified by {:.1f} dB more: the gain depends on the level",
                      std::abs(by_level) >= kGainMoves ? by_level : fall),
          kAgainstAgc};
}

/// The place of a response before the linear one says of which order it is.
Finding distorted(int order, double level_db) {
  return {Verdict::Clipping,
          fmt::format("harmonic {} of the probe is {:.0f} dB below it: a stage of the path distorts", order,
                      -level_db),
          kAgainstOverload};
}

Finding detected_twice(std::int64_t frames, double level_db) {
  return {
      Verdict::DirectMonitoring,
      fmt::format("the probe is detected twice: the second is {:.1f} dB {} the first, {:+d} frames from it",
                  std::abs(level_db), level_db > 0.0 ? "above" : "below", frames),
      "switch off direct monitoring in the card's mixer, and remove connections from its inputs to its "
      "outputs"};
}

/// What noise hides: the delay itself, or that frames were lost. Nothing: all can be seen.
std::string hidden_by_noise(const Analysis& analysis, const Evidence& evidence) {
  if (!evidence.coarse.clear())
    return "single probes cannot be separated, and lost frames or drift cannot be detected";
  if (analysis.standard_error_frames >= evidence.widest_error_frames)
    return fmt::format("the delay is uncertain by {:.2f} frames", analysis.standard_error_frames);
  if (evidence.least_step_frames > 1.0)
    return fmt::format("fewer than {:.1f} lost frames cannot be detected", evidence.least_step_frames);
  if (evidence.ends_hidden) return "frames that were lost before or behind the probes cannot be detected";
  return {};
}

Finding too_noisy(const Analysis& analysis, const Evidence& evidence) {
  const auto effect = hidden_by_noise(analysis, evidence);
  if (effect.empty()) return {};
  if (evidence.unsteady)
    return {Verdict::BackgroundSound,
            fmt::format("something else sounds now and then: with a signal {:.1f} dB above it, {}",
                        analysis.snr_db, effect),
            kAgainstBackground};
  return {
      Verdict::LowSnr,
      fmt::format("the noise is too strong: with a signal {:.1f} dB above it, {}", analysis.snr_db, effect),
      kAgainstNoise};
}

Finding not_flat(const Analysis& analysis, const Evidence& evidence) {
  if (evidence.with_profile && analysis.misfit_frames > evidence.widest_error_frames)
    return {Verdict::NotFlat,
            fmt::format("{:.2g} % of the captured signal does not fit the profile, so the delay may be wrong "
                        "by {:.1f} frames",
                        100.0 * analysis.misfit, analysis.misfit_frames),
            "the actuator or the sensor has changed since the calibration: calibrate again"};
  std::string what;
  if (analysis.misfit > kMisfit)
    what =
        fmt::format("{:.1f} % of the captured signal does not fit a single delay", 100.0 * analysis.misfit);
  else if (evidence.gain_range_db > kGainRange)
    what = fmt::format("its gain varies by {:.0f} dB over the band", evidence.gain_range_db);
  else
    return {};
  return {Verdict::NotFlat, "the path is not a cable: " + what,
          "connect the output to the input with a cable, or measure the actuator and sensor with `tactus "
          "latency calibrate` and give the profile"};
}

}  // namespace

Finding not_detected(const std::vector<CoarseDelay>& channels, int channel, bool cut_short) {
  if (cut_short)
    return {Verdict::NoSignal, "fewer than three probes were recorded completely",
            "start the recording before the probe and end it after"};
  int loudest = -1;
  double prominence = CoarseDelay::kNothing * 1.5;
  for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
    const auto& other = channels[index(c)];
    if (c == channel || other.prominence <= prominence) continue;
    loudest = c;
    prominence = other.prominence;
  }
  if (loudest >= 0)
    return {Verdict::WrongChannel,
            fmt::format("nothing is detected on input {}, but on input {}", channel + 1, loudest + 1),
            fmt::format("choose input {} (--in; for a file, --channel), or move the cable to input {}",
                        loudest + 1, channel + 1)};
  return {Verdict::NoSignal, fmt::format("the probe is not detected on input {}", channel + 1),
          "connect the output to the input with a cable, and check that neither is muted or turned down"};
}

Finding first_of(const std::vector<Finding>& findings) {
  Finding first;
  for (const auto& finding : findings)
    if (finding.verdict != Verdict::Ok && (first.verdict == Verdict::Ok || finding.verdict < first.verdict))
      first = finding;
  return first;
}

Finding verdict_of(const Analysis& analysis, const Evidence& evidence, std::span<const double> captured) {
  // A second path far away overlaps the probes, so that nothing else can be separated from them.
  const auto& second = evidence.second;
  const auto& echo = evidence.echo;
  const auto& order = evidence.harmonic;
  const bool near = echo.share >= kEchoShare && echo.level_db >= kLeastEcho;
  const auto twice = [&](std::int64_t frames, double level_db) {
    return order ? distorted(*order, level_db) : detected_twice(frames, level_db);
  };
  const Finding overdriven{Verdict::Clipping,
                           "loud and soft probes differ in shape: a stage of the path is overdriven",
                           kAgainstOverload};
  for (const auto& found :
       {clipping(analysis, captured), second ? twice(second->frames, second->level_db) : Finding{},
        lost_frames(analysis), moving_gain(analysis, evidence), evidence.overdriven ? overdriven : Finding{},
        clocks_differ(analysis), near ? twice(echo.frames, echo.level_db) : Finding{},
        evidence.coarse.clear() ? not_flat(analysis, evidence) : Finding{}, too_noisy(analysis, evidence)})
    if (found.verdict != Verdict::Ok) return found;
  return {};
}

}  // namespace tactus
