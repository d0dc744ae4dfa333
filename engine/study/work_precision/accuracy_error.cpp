#include "engine/study/work_precision/accuracy_error.h"

#include <algorithm>
#include <cmath>

#include "engine/study/work_precision/oscillation.h"

namespace tactus {
namespace {

using Samples = std::span<const double>;

constexpr double kExplosion = 10.0;

double largest(Samples samples) {
  double most = 0;
  for (const double x : samples) most = std::max(most, std::abs(x));
  return most;
}

Samples window_of(const Accuracy& accuracy, const SceneRecording& recording) {
  const auto* signal = recording.find(accuracy.of);
  if (signal == nullptr) return {};
  const auto size = static_cast<double>(signal->samples.size());
  const auto frame = [&](double seconds) {
    return static_cast<std::size_t>(std::clamp(std::round(seconds * recording.sample_rate.value), 0.0, size));
  };
  const auto first = frame(accuracy.from_s.value_or(0)), last = frame(accuracy.to_s.value_or(1e9));
  return Samples{signal->samples}.subspan(first, std::max(first, last) - first);
}

/// One thing that two runs, or a run and a theory, are compared in.
class Judgement {
 public:
  Judgement(const Accuracy& accuracy, const SceneRecording& run, const SceneRecording& reference)
      : accuracy_(accuracy),
        rate_(run.sample_rate),
        run_(window_of(accuracy, run)),
        reference_(window_of(accuracy, reference)) {}

  double position() const {
    double squares = 0;
    for (std::size_t n = 0; n < frames(); ++n) squares += std::pow(run_[n] - reference_[n], 2);
    return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, frames()))) /
           scale(largest(reference_));
  }

  /// Of what it has become since the first sample: where a scheme keeps its energy between two instants, what
  /// it calls so differs from the true one, and need not drift.
  double energy() const {
    double most = 0;
    for (std::size_t n = 0; n < frames(); ++n) {
      const double change = accuracy_.exact ? 0 : reference_[n] - reference_[0];
      most = std::max(most, std::abs(run_[n] - run_[0] - change));
    }
    return most / scale(accuracy_.exact ? std::abs(accuracy_.exact->si) : largest(reference_));
  }

  using Reading = std::optional<double> (*)(Samples, Hertz);
  double number(Reading reading) const {
    const auto wanted = accuracy_.exact ? std::optional{accuracy_.exact->si} : reading(reference_, rate_);
    const auto found = reading(run_, rate_);
    if (!wanted || !found) return wanted || found ? 1.0 : 0.0;
    // Which way something moves is as much its own as how fast.
    return std::abs(*found - *wanted) / scale(std::abs(*wanted));
  }

  double event_times() const {
    const auto wanted = falls_through_zero(reference_, rate_), found = falls_through_zero(run_, rate_);
    const auto all = std::max(wanted.size(), found.size()), both = std::min(wanted.size(), found.size());
    if (all == 0) return 0;
    if (wanted.empty()) return 1;
    const double interval = wanted.size() > 1
                                ? (wanted.back() - wanted.front()) / static_cast<double>(wanted.size() - 1)
                                : wanted.front();
    // One that is missing, or elsewhere altogether, is wrong by 1.
    double squares = static_cast<double>(all - both);
    for (std::size_t i = 0; i < both; ++i)
      squares += std::pow(std::min(1.0, std::abs(found[i] - wanted[i]) / scale(interval)), 2);
    return std::sqrt(squares / static_cast<double>(all));
  }

 private:
  std::size_t frames() const { return std::min(run_.size(), reference_.size()); }
  double scale(double natural) const {
    const double chosen = accuracy_.scale ? accuracy_.scale->si : natural;
    return chosen > 0 ? chosen : 1.0;
  }

  const Accuracy& accuracy_;
  Hertz rate_;
  Samples run_, reference_;
};

}  // namespace

Result<double> accuracy_error(const Accuracy& accuracy, const SceneRecording& run,
                              const SceneRecording& reference) {
  for (const auto* recording : {&run, &reference})
    if (recording->find(accuracy.of) == nullptr)
      return fail(Errc::UnknownName, accuracy.of_at.text(),
                  "nothing called '" + accuracy.of + "' was recorded", "name an output of the plant");
  const Judgement judgement(accuracy, run, reference);
  const auto& what = accuracy.measure;
  if (what == "position") return judgement.position();
  if (what == "energy") return judgement.energy();
  if (what == "event_times") return judgement.event_times();
  return judgement.number(what == "frequency" ? frequency_of : what == "decay" ? decay_of : slope_of);
}

bool exploded(const Accuracy& accuracy, const SceneRecording& run, const SceneRecording& reference) {
  if (!run.faults.empty()) return true;
  Accuracy everywhere = accuracy;
  everywhere.from_s = everywhere.to_s = std::nullopt;
  const auto samples = window_of(everywhere, run);
  if (!std::all_of(samples.begin(), samples.end(), [](double x) { return std::isfinite(x); })) return true;
  const double most =
      std::max(largest(window_of(everywhere, reference)), accuracy.scale ? accuracy.scale->si : 0);
  return largest(samples) > kExplosion * most && most > 0;
}

}  // namespace tactus
