#include "engine/analysis/judged_tone.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/analysis/judged_roll.h"
#include "engine/core/median.h"

namespace tactus {
namespace {

constexpr double kRightShare = 0.9;               // of a right note
constexpr double kLowest = 0.45, kHighest = 6.5;  // of the pitch wanted: where it is looked for

double rms_of(std::span<const double> samples) {
  double squares = 0;
  for (const double x : samples) squares += x * x;
  return samples.empty() ? 0 : std::sqrt(squares / static_cast<double>(samples.size()));
}

std::span<const double> between(const RecordedSignal& signal, Hertz rate, double from, double to) {
  const auto frame = [&](double time) {
    return std::min(signal.samples.size(), static_cast<std::size_t>(time * rate.value));
  };
  return std::span{signal.samples}.subspan(frame(from), frame(to) - frame(from));
}

/// The moments of the part that should be steady.
struct Moments {
  double frames = 0;  ///< that there are, with a pitch or without
  double right = 0, partials = 0;
  std::vector<double> hertz, level;

  double right_share() const { return right / frames; }
  double strays() const { return frames - right - partials; }
};

Moments moments_of(const std::vector<PitchPoint>& track, double from, double to, double wanted) {
  Moments moments;
  moments.frames = std::max(1.0, std::floor((to - from) / kPitchHop_s));
  for (const auto& point : track) {
    if (point.time_s < from || point.time_s >= to) continue;
    moments.hertz.push_back(point.hertz);
    moments.level.push_back(point.rms);
    const int partial = partial_of(point.hertz, wanted);
    if (partial == 1 && std::abs(cents(point.hertz, wanted)) <= kInTune_cents) ++moments.right;
    if (partial > 1) ++moments.partials;
  }
  moments.right = std::min(moments.right, moments.frames);
  return moments;
}

double spread_of(const std::vector<double>& values) {
  double sum = 0, squares = 0;
  for (const double x : values) sum += x;
  const double mean = values.empty() ? 0 : sum / static_cast<double>(values.size());
  if (mean <= 0) return 1;
  for (const double x : values) squares += (x - mean) * (x - mean);
  return std::sqrt(squares / static_cast<double>(values.size())) / mean;
}

/// The first moment from which on it stands; `latest` if there is none.
double stands_before(double latest, const std::vector<PitchPoint>& track, const Moments& moments,
                     double wanted) {
  if (moments.hertz.empty()) return latest;
  std::vector<ToneMoment> all;
  for (const auto& point : track)
    if (point.time_s < latest) all.push_back({point.time_s, cents(point.hertz, wanted), point.rms});
  return stands_at(all, cents(median(moments.hertz), wanted), median(moments.level)).value_or(latest);
}

const char* kind_of(double level, double quiet, const Moments& moments) {
  if (level < quiet) return "silent";
  if (moments.right_share() >= kRightShare) return "right note";
  return moments.partials > moments.strays() ? "wrong partial" : "howl";
}

}  // namespace

const std::vector<ReadingType>& tone_readings() {
  static const std::vector<ReadingType> readings = {
      {"start_s", "speaks s", 2, "from the bow to a tone that stands", true},
      {"partial", "partial", 0, "of the note wanted, nearest to what sounds; 0: none"},
      {"cents", "cents", 1, "what sounds over that partial, or over the note", true},
      {"right", "right", 2, "share of the moments with the note wanted", true},
      {"level_spread", "unsteady", 2, "standard deviation of the level over its mean", true},
      {"swing_cents", "swing", 1, "how far its pitch swings, the middle nine tenths [cents]"},
      {"rms", "rms", 3, "root mean square [full scale]"},
  };
  return readings;
}

const std::vector<RunKind>& tone_kinds() {
  static const std::vector<RunKind> kinds = {
      {"right note", 'N', "in tune within 25 cents in 9 of 10 moments"},
      {"wrong partial", 'p', "mostly another partial of the note"},
      {"howl", 'h', "another pitch, or none"},
      {"silent", '.', "softer than is asked"},
  };
  return kinds;
}

JudgedRun judge_tone(const SceneRecording& recording, const Playability& judged) {
  JudgedRun run{"silent", 0, false, std::vector<double>(tone_readings().size(), 0.0)};
  const auto* sound = recording.find(judged.sound.name);
  if (sound == nullptr) return run;
  const double from = judged.from_s, to = judged.to_s.value_or(recording.seconds());
  const auto rate = recording.sample_rate;
  const double level = rms_of(between(*sound, rate, from, to));
  // The tracker leaves out both ends of what it is given.
  auto track = track_pitch(between(*sound, rate, judged.begin_s, recording.seconds()), rate,
                           Hertz{std::max(20.0, kLowest * judged.pitch_hz)},
                           Hertz{std::min(0.1 * rate.value, kHighest * judged.pitch_hz)});
  for (auto& point : track) point.time_s += judged.begin_s;
  const double ends = std::min(to, recording.seconds() - 10 / judged.pitch_hz);
  const auto moments = moments_of(track, from, ends, judged.pitch_hz);
  const double start = stands_before(to, track, moments, judged.pitch_hz) - judged.begin_s;
  const double spread = spread_of(moments.level);
  const double pitch = median(moments.hertz);
  const int partial = pitch > 0 ? partial_of(pitch, judged.pitch_hz) : 0;
  run.kind = kind_of(level, judged.quiet, moments);
  if (run.kind != "silent")
    run.score = moments.right_share() * kPrompt_s / std::max(start, kPrompt_s) * kSteadySpread /
                std::max(spread, kSteadySpread);
  run.playable = run.kind == "right note" && run.score >= kLeastScore;
  run.readings = {start,
                  static_cast<double>(partial),
                  pitch > 0 ? cents(pitch, std::max(1, partial) * judged.pitch_hz) : 0,
                  moments.right_share(),
                  spread,
                  swing_of(moments.hertz),
                  level};
  return run;
}

}  // namespace tactus
