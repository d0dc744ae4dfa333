#include "latency/probe/probe.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "engine/core/index.h"

namespace tactus {
namespace {

using std::numbers::pi;

constexpr double kHighest = 0.42;    // of the sample rate: below where converters' filters begin
constexpr Seconds kRise{0.008};      // of the first edge; the last one lasts an eighth of it
constexpr Seconds kProbeQuiet{0.5};  // before the first probe of a stimulus
constexpr Seconds kProbePilot{0.5}, kPilotEdge{0.002};
// No two stretches of pauses are equally long, so a train fits itself only where it is.
constexpr std::array kPauses{0.100, 0.116, 0.104, 0.124, 0.108, 0.132, 0.112, 0.140};

/// 0 to 1 and back over [0, length), along half a period of a cosine each.
double edges(double at, double length, double rise, double fall) {
  const auto raised = [](double x) { return x >= 1.0 ? 1.0 : 0.5 - 0.5 * std::cos(pi * x); };
  return raised(at / rise) * raised((length - at) / fall);
}

/// A number in [-1, 1) for each n, by a hash (splitmix64).
double even_noise(std::uint64_t n) {
  auto x = (n + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-52 - 1.0;
}

void append(std::vector<double>& to, const std::vector<double>& from, double gain) {
  for (const double sample : from) to.push_back(gain * sample);
}

}  // namespace

std::size_t whole_frames(Seconds time, Hertz sample_rate) {
  return static_cast<std::size_t>(std::llround(frames_in(time, sample_rate)));
}

Seconds ExponentialSweep::growth() const { return duration / std::log(stop / start); }

std::vector<double> ExponentialSweep::samples(Hertz sample_rate) const {
  const double length = frames_in(duration, sample_rate);
  const double growth_s = growth().value;
  std::vector<double> samples(whole_frames(duration, sample_rate));
  const double rise = frames_in(kRise, sample_rate);
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const double at = static_cast<double>(n);
    const double phase = 2 * pi * start.value * growth_s * std::expm1(at / sample_rate.value / growth_s);
    samples[n] = std::sin(phase) * edges(at, length, rise, rise / 8);
  }
  return samples;
}

ExponentialSweep measuring_probe(Hertz sample_rate) { return {20_Hz, sample_rate * kHighest, Seconds{0.35}}; }

ExponentialSweep level_probe(Hertz sample_rate) { return {100_Hz, sample_rate * kHighest, Seconds{0.04}}; }

std::vector<double> pilot(Hertz sample_rate) {
  std::vector<double> samples(whole_frames(kProbePilot, sample_rate));
  const double edge = frames_in(kPilotEdge, sample_rate), length = frames_in(kProbePilot, sample_rate);
  // Nothing at half the sample rate, where a fraction of a frame of delay has no meaning.
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = (0.25 * even_noise(n) + 0.5 * even_noise(n + 1) + 0.25 * even_noise(n + 2)) *
                 edges(static_cast<double>(n), length, edge, edge);
  return samples;
}

double ProbeTrain::gain(int probe) { return probe % 4 == 1 ? kSoftGain : 1.0; }

std::vector<double> ProbeTrain::samples(Hertz sample_rate, int count, double level) {
  std::vector<double> train;
  const auto probe = measuring_probe(sample_rate).samples(sample_rate);
  for (int k = 0; k < count; ++k) {
    append(train, probe, level * gain(k));
    train.resize(train.size() + whole_frames(Seconds{kPauses[index(k) % kPauses.size()]}, sample_rate), 0.0);
  }
  append(train, pilot(sample_rate), level);
  return train;
}

std::vector<double> stimulus(Hertz sample_rate, double level) {
  std::vector<double> samples(whole_frames(kProbeQuiet, sample_rate), 0.0);
  append(samples, ProbeTrain::samples(sample_rate, ProbeTrain::kProbes, level), 1.0);
  return samples;
}

}  // namespace tactus
