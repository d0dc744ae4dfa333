#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/core/decibels.h"
#include "engine/core/median.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/scene/measures/measure.h"
#include "engine/scene/measures/motion.h"
#include "engine/scene/measures/playability_result.h"

// The table of measures: a new one is a line of `measures()`, a function where it needs one, and its test.

namespace tactus {
namespace {

constexpr double kUndefined = std::numeric_limits<double>::quiet_NaN();

double peak(const Window& w) { return peak_of(w.samples()); }

double rms(const Window& w) { return rms_of(w.samples()); }

double crest_factor(const Window& w) {
  const double level = rms(w);
  return level > 0 ? peak(w) / level : 0;
}

double pitch(const Window& w) {
  std::vector<double> found;
  for (const auto& point : track_pitch(w.samples(), w.rate(), 40_Hz, 2_kHz)) found.push_back(point.hertz);
  return median(std::move(found));
}

double faults(const Window& w) {
  double sum = static_cast<double>(w.recording.bad_inputs);
  for (const auto& fault : w.recording.faults) sum += static_cast<double>(fault.count);
  return sum;
}

double energy_given(const Window& w) {
  const auto force = w.samples(*w.recording.find(w.port->force.name));
  const auto position = w.samples(*w.recording.find(w.port->position.name));
  EnergyWatch watch{*w.port};
  watch.take(force.data(), position.data(), static_cast<int>(force.size()));
  return watch.energy(w.rate()).given;
}

double period(const Window& w) {
  return bouncing_in(w.signal->samples, w.beside->samples, w.rate(), w.from_s, w.to_s).period;
}

double restitution_of(const Window& w) {
  std::vector<Strike> strikes;
  for (const auto& strike : strikes_in(*w.beside, w.rate()))
    if (strike.start_s >= w.from_s && strike.end_s <= w.to_s) strikes.push_back(strike);
  return restitution(w.signal->samples, w.rate(), strikes);
}

Rhythm rhythm(const Window& w) { return rhythm_of(w.event_times(), w.from_s, w.to_s); }

Detection detection(const Window& w) {
  if (w.detection != nullptr) return *w.detection;
  const auto triggers =
      w.signal == nullptr ? std::vector<double>{} : trigger_times(w.signal->samples, w.rate());
  return detection_of(*w.beside, w.rate(), triggers, w.from_s, w.to_s);
}

double sustained_of(const Window& w) {
  const double fewest = w.playability != nullptr ? w.playability->fewest : Playability{}.fewest;
  return sustained(w.event_times(), w.from_s, w.to_s, fewest);
}

ToneValues tone(const Window& w) {
  if (w.tone != nullptr) return *w.tone;
  return w.playability->kind == Playability::Kind::Tone ? tone_of(w.recording, *w.playability).values
                                                        : ToneValues{};
}

// ---- errors of a run against a reference ----

double position_error(const Measure&, const RunPair& pair) {
  const auto run = pair.run.samples(), reference = pair.reference.samples();
  const auto frames = std::min(run.size(), reference.size());
  double squares = 0;
  for (std::size_t n = 0; n < frames; ++n) squares += std::pow(run[n] - reference[n], 2);
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, frames))) /
         pair.scale(peak_of(reference));
}

/// Of the change since the first sample: a solver that keeps its energy between two instants reports an
/// energy that differs from the true one, and need not drift.
double energy_error(const Measure&, const RunPair& pair) {
  const auto run = pair.run.samples(), reference = pair.reference.samples();
  const auto& exact = pair.accuracy.exact;
  double most = 0;
  for (std::size_t n = 0; n < std::min(run.size(), reference.size()); ++n) {
    const double change = exact ? 0 : reference[n] - reference[0];
    most = std::max(most, std::abs(run[n] - run[0] - change));
  }
  return most / pair.scale(exact ? std::abs(exact->si) : peak_of(reference));
}

double relative_error(const Measure& measure, const RunPair& pair) {
  const auto& exact = pair.accuracy.exact;
  const double expected = exact ? exact->si : measure.value(pair.reference), found = measure.value(pair.run);
  if (std::isnan(expected) || std::isnan(found)) return std::isnan(expected) == std::isnan(found) ? 0.0 : 1.0;
  // The sign of a motion counts as much as its size.
  return std::abs(found - expected) / pair.scale(std::abs(expected));
}

double event_times_error(const Measure&, const RunPair& pair) {
  const auto expected = falls_through_zero(pair.reference.samples(), pair.run.rate()),
             found = falls_through_zero(pair.run.samples(), pair.run.rate());
  const auto all = std::max(expected.size(), found.size()), both = std::min(expected.size(), found.size());
  if (all == 0) return 0;
  if (expected.empty()) return 1;
  const double interval =
      expected.size() > 1 ? (expected.back() - expected.front()) / static_cast<double>(expected.size() - 1)
                          : expected.front();
  // One that is missing, or elsewhere altogether, is wrong by 1.
  double squares = static_cast<double>(all - both);
  for (std::size_t i = 0; i < both; ++i)
    squares += std::pow(std::min(1.0, std::abs(found[i] - expected[i]) / pair.scale(interval)), 2);
  return std::sqrt(squares / static_cast<double>(all));
}

using W = const Window&;
using S = Measure::Subject;
constexpr auto kSame = Measure::kUnitOfSubject;

/// Only compares two runs.
Measure compared(const char* name, const char* unit, double (*error)(const Measure&, const RunPair&),
                 const char* doc, bool has_exact = false) {
  return {name, unit, "", S::Signal, nullptr, "", "", error, doc, has_exact};
}

std::vector<Measure> all_measures() {
  return {
      {"count", "", "number of events", S::Events, [](W w) -> double { return rhythm(w).count; }},
      {"rate", "Hz", "events per second, from the first to the last event", S::Events,
       [](W w) { return rhythm(w).rate_hz; }},
      {"fewest_per_second", "", "fewest events in any second", S::Events,
       [](W w) -> double { return rhythm(w).fewest_in_a_second; }},
      {"spread", "", "standard deviation of the intervals divided by their mean", S::Events,
       [](W w) { return rhythm(w).spread; }},
      {"long_short", "", "ratio of the longer to the shorter of two neighbouring intervals, median",
       S::Events, [](W w) { return rhythm(w).long_short; }},
      {"growing", "", "longest run of intervals each at least 3 % longer than the one before", S::Events,
       [](W w) -> double { return rhythm(w).growing; }},
      {"last", "s", "time of the last event", S::Events, [](W w) { return rhythm(w).last_s; }},
      {"sustained", "",
       "fraction of the seconds with at least the number of events required by [playability], or 10",
       S::Events, sustained_of},
      {"even_spread", "", "standard deviation of the intervals divided by their mean; 1: fewer than 6 events",
       S::Events, [](W w) { return evenness_of(w.event_times()).spread; }},
      {"beats", "", "events after which the pattern of the intervals repeats", S::Events,
       [](W w) -> double { return evenness_of(w.event_times()).beats; }},
      {"pattern_spread", "", "relative spread of the intervals around the repeating pattern", S::Events,
       [](W w) { return evenness_of(w.event_times()).pattern_spread; }},
      {"restitution", "", "ratio of the speeds after and before a strike, geometric mean", S::Signal,
       restitution_of, "stick", "contact"},
      {"detected", "", "number of strikes detected, each by a separate hit", S::Events,
       [](W w) -> double { return detection(w).found; }, "hit", "contact"},
      {"missed", "", "number of strikes above 5 N that were not detected", S::Events,
       [](W w) -> double { return detection(w).missed; }, "hit", "contact"},
      {"doubled", "", "detected hits without a matching strike (false triggers)", S::Events,
       [](W w) -> double { return detection(w).doubled; }, "hit", "contact"},
      {"detection_time", "s", "longest time from the start of a strike to the hit", S::Events,
       [](W w) { return detection(w).latest_s; }, "hit", "contact"},
      {"period", "", "landings per orbit of a ball on a table; 0: not periodic within 8 landings", S::Signal,
       period, "ball", "table"},
      {"peak", kSame, "largest absolute value", S::Signal, peak},
      {"rms", kSame, "root mean square", S::Signal, rms},
      {"crest_factor", "", "ratio of peak to root mean square; 0: silence", S::Signal, crest_factor},
      {"pitch", "Hz", "median fundamental frequency; 0: no pitch", S::Signal, pitch},
      {"energy_given", "J", "largest energy delivered by the instrument to the plant since any earlier time",
       S::Port, energy_given},
      {"faults", "", "number of non-finite values at inputs and in nodes", S::Nothing, faults},
      {"score", "", "score from 0 (no criterion of [playability] met) to 1 (all met)", S::Playing,
       [](W w) { return evaluate(w.recording, *w.playability).score; }},
      {"playable", "", "1: playable by the criteria of [playability], 0: not playable", S::Playing,
       [](W w) { return evaluate(w.recording, *w.playability).playable ? 1.0 : 0.0; }},
      {"onset_time", "s", "time from the beginning of the note to a steady tone", S::Playing,
       [](W w) { return tone(w).start_s; }},
      {"partial", "", "number of the expected note's partial nearest to the tone; 0: none", S::Playing,
       [](W w) -> double { return tone(w).partial; }},
      {"cents", "", "deviation of the tone's pitch from that partial, or from the note", S::Playing,
       [](W w) { return tone(w).cents; }},
      {"right_share", "", "fraction of the time with the expected note", S::Playing,
       [](W w) { return tone(w).right; }},
      {"level_spread", "", "standard deviation of the level divided by its mean", S::Playing,
       [](W w) { return tone(w).level_spread; }},
      {"onset_noise", "",
       "energy of the first 0.3 s of a note that does not repeat after a period, over the tone's", S::Playing,
       [](W w) { return tone(w).onset_noise; }},
      {"note_levels", "", "standard deviation of the levels of the notes [dB]", S::Playing,
       [](W w) { return tone(w).level_deviation_db; }},
      {"swing", "", "range of the pitch, 5th to 95th percentile [cents]", S::Playing,
       [](W w) { return tone(w).swing_cents; }},
      {"tone_level", "", "root mean square of the tone [full scale]", S::Playing,
       [](W w) { return tone(w).level; }},
      {"notes", "",
       "number of expected notes; the other measures of a tone are those of the note with the lowest score",
       S::Playing, [](W w) -> double { return tone(w).notes; }},
      {"good_notes", "", "number of playable notes", S::Playing,
       [](W w) -> double { return tone(w).good_notes; }},
      compared("position", kSame, position_error,
               "root mean square of the difference, relative to the largest value"),
      compared("energy", kSame, energy_error,
               "largest difference of the change since the first sample, relative to the largest value",
               true),
      {"frequency", "Hz", "frequency of an oscillation, from its first to its last zero crossing", S::Signal,
       [](W w) { return frequency_of(w.samples(), w.rate()).value_or(kUndefined); }, "", "", relative_error,
       "relative difference of the frequency of an oscillation", true},
      {"decay", "1/s", "decay rate of an oscillation about 0", S::Signal,
       [](W w) { return decay_of(w.samples(), w.rate()).value_or(kUndefined); }, "", "", relative_error,
       "relative difference of the decay rate of an oscillation", true},
      {"speed", "m/s", "slope of a line fitted to a position", S::Signal,
       [](W w) { return slope_of(w.samples(), w.rate()).value_or(kUndefined); }, "", "", relative_error,
       "relative difference of the speed, the slope of a line fitted to a position", true},
      compared("event_times", "s", event_times_error,
               "root mean square difference of the falling zero crossings' times, relative to their mean "
               "interval"),
  };
}

}  // namespace

const std::vector<Measure>& measures() {
  static const auto all = all_measures();
  return all;
}

}  // namespace tactus
