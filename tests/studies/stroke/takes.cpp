#include "tests/studies/stroke/takes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/dsp/envelopes/stroke.h"
#include "tests/studies/stroke/vary.h"

namespace tactus::study {
namespace {

/// Where scripts/study_stroke unpacks more recordings.
constexpr const char* kUnpacked = "build/stroke_study/recordings/";

/// First frame within `part` of the peak.
std::size_t first_at(const std::vector<float>& hit, float level, std::size_t from = 0) {
  std::size_t n = from;
  while (n < hit.size() && std::abs(hit[n]) < level) ++n;
  return n;
}

/// The recording's onset: the first frame within 26 dB (5 %) of the peak. Recordings are normalised to 1.
std::size_t onset_of(const std::vector<float>& hit) { return first_at(hit, 0.05f); }

bool rises_slowly(const std::vector<float>& hit) {
  return static_cast<double>(first_at(hit, 0.3f) - onset_of(hit)) > 0.005 * kRate;
}

/// A drum's recordings differ by what follows its last letter or dash: "PearlTom1-Soft", "tom_03".
std::string drum_of(const std::string& name) {
  auto end = name.find_last_of("-_ ");
  return name.substr(0, end == std::string::npos ? name.size() : end);
}

double gain(double db) { return std::pow(10.0, db / 20); }

using Frames = std::vector<std::array<double, TACTUS_STROKE_BANDS>>;

/// Energies of the frames of 0.5 ms, in the bands of the node `stroke`.
Frames energies(const std::vector<double>& audio) {
  constexpr int samples = 24;
  tactus_stroke state{};
  tactus_stroke_start(&state, kRate, &tactus_stroke_nets[0]);
  state.samples = samples;
  Frames frames;
  for (std::size_t n = 0; n + samples <= audio.size(); n += samples) {
    filter_stroke(state, state.heard, &audio[n], samples);
    tactus_stroke_energies(&state, &state.heard, frames.emplace_back().data());
  }
  return frames;
}

}  // namespace

const std::vector<Part>& all_parts() {
  static const std::vector<Part> parts = {
      {"design",
       {"BJA_Pacific", "ForzeeStereo", "Gimme A Hand 1.0", "Millo_MultiLayered2", "samples", "FluidR3_GM",
        "MuseScore_General", "TimGM6mb", "freepats", "lmms", "TR808EmulationKit", "sonic-pi-others"},
       840,
       5,
       true},
      {"choice", {"The Black Pearl 1.0", "Millo_MultiLayered3", "circAfrique v4", "Millo-Drums_v.1"}, 158, 6},
      {"report", {"Red_Zeppelin_4"}, 70, 8},
      {"second_report", {"ColomboAcousticDrumkit"}, 64, 8},
      {"electronic", {"VariBreaks", "ElectricEmpireKit", "HardElectro1", "Audiophob"}, 63, 8},
      {"design_noise", {}, 30, 5},
      {"choice_noise", {}, 20, 10},
      {"report_noise", {}, 40, 15}};
  return parts;
}

TakeMaker::TakeMaker(Part part, bool audibility) : part_(std::move(part)), audibility_(audibility) {
  if (part_.kits.empty()) return;
  SampleSet set =
      load_samples(part_.name == "electronic" ? Recordings::Electronic : Recordings::Acoustic, part_.kits);
  for (const std::string& kit : part_.kits)
    for (Sample& sample : load_kit(kUnpacked + kit).samples) set.samples.push_back(std::move(sample));
  for (const Sample& sample : set.samples) {
    const bool struck = sample.kind != "kick" && sample.kind != "closed hat";
    if (!struck || rises_slowly(sample.shifted[0])) continue;
    Hit hit{sample.name, drum_of(sample.name), {}, {}};
    for (const auto& shifted : sample.shifted) {
      hit.shifted.push_back(shifted);
      hit.onset_s.push_back(static_cast<double>(onset_of(shifted)) / kRate);
    }
    hits_.push_back(std::move(hit));
    names_.push_back(sample.name);
  }
}

Take TakeMaker::noise(int index) const {
  Random random(part_.name + std::to_string(index));
  Take take;
  take.name = part_.name + "_" + std::to_string(index);
  take.audio.resize(static_cast<std::size_t>(part_.take_s * kRate));
  const double cutoff_hz = 100 * std::pow(200.0, random.uniform());
  const double feed = 1 - std::exp(-2 * std::numbers::pi * cutoff_hz / kRate);
  const double hum = random.uniform() < 0.5 ? gain(-70 + 30 * random.uniform()) : 0;
  double low = 0, power = 0;
  for (float& x : take.audio) {
    low += feed * (random.normal() - low);
    power += low * low / static_cast<double>(take.audio.size());
    x = static_cast<float>(low);
  }
  const double scale = gain(-70 + 34 * random.uniform()) / std::sqrt(power);
  for (std::size_t n = 0; n < take.audio.size(); ++n) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(n) / kRate;
    const double sum = std::sin(50 * turn) + 0.5 * std::sin(150 * turn) + 0.25 * std::sin(250 * turn);
    take.audio[n] = static_cast<float>(scale * static_cast<double>(take.audio[n]) + hum * sum);
  }
  return take;
}

Take TakeMaker::make(int index) const {
  if (hits_.empty()) return noise(index);
  Random random(part_.name + std::to_string(index));
  const Hit* first = &hits_[static_cast<std::size_t>(index) % hits_.size()];
  const Hit* second = first;
  if (random.uniform() < 0.3) {
    std::vector<const Hit*> others;
    for (const Hit& hit : hits_)
      if (hit.drum == first->drum) others.push_back(&hit);
    second = others[random.below(others.size())];
  }
  Take take;
  take.name = part_.name + "_" + std::to_string(index);
  take.recordings = first->name + (second == first ? "" : ", " + second->name);
  if (part_.varied && random.uniform() < 0.6) {
    // Of another stream of random numbers, so that the takes of the other parts stay what they are.
    Random other(part_.name + " varied " + std::to_string(index));
    vary(other, first->shifted[0], second->shifted[0], part_.take_s, take.strokes_s, take.audio);
    return take;
  }
  take.rate = 5 * std::pow(6.0, random.uniform());
  const double range_db = 3 + 21 * random.uniform(), loudest_db = -6 * random.uniform();
  const double noise = gain(-70 + 34 * random.uniform());
  take.audio.resize(static_cast<std::size_t>(part_.take_s * kRate));
  std::vector<Layer> layers;
  for (double time = 0.3; time < part_.take_s - 0.1; time += 1 / take.rate) {
    const Hit& hit = layers.size() % 2 == 0 ? *first : *second;
    const double place = (time + 0.03 / take.rate * (2 * random.uniform() - 1)) * kRate * kShifts;
    const auto quarters = static_cast<std::size_t>(place);
    const std::size_t start = quarters / kShifts, shift = quarters % kShifts;
    const auto scale = static_cast<float>(gain(loudest_db - range_db * random.uniform()));
    const std::vector<float>& sound = hit.shifted[shift];
    for (std::size_t n = 0; n < sound.size() && start + n < take.audio.size(); ++n)
      take.audio[start + n] += scale * sound[n];
    take.strokes_s.push_back(static_cast<double>(start) / kRate + hit.onset_s[shift]);
    layers.push_back({&sound, start, scale, hit.onset_s[shift]});
  }
  for (float& x : take.audio) x += static_cast<float>(noise * random.normal());
  if (audibility_)
    for (const Layer& layer : layers) take.audible.push_back(is_audible(take.audio, layer));
  return take;
}

bool TakeMaker::is_audible(const std::vector<float>& take, const Layer& layer) {
  const long before = 48 * 40, heard = 48 * 10, least = 20;  // samples: 40 ms for the filters, 10 ms; frames
  const auto start = static_cast<long>(layer.start);
  const long onset = start + std::lround(layer.onset_s * kRate), from = onset - before;
  std::vector<double> own, rest;
  for (long n = from; n < onset + heard; ++n) {
    const bool inside = n >= 0 && n < static_cast<long>(take.size());
    const bool sounds = n >= start && n - start < static_cast<long>(layer.sound->size());
    own.push_back(
        sounds ? static_cast<double>(layer.scale * (*layer.sound)[static_cast<std::size_t>(n - start)]) : 0);
    rest.push_back((inside ? static_cast<double>(take[static_cast<std::size_t>(n)]) : 0) - own.back());
  }
  const Frames own_frames = energies(own), rest_frames = energies(rest);
  const auto onset_frame = static_cast<std::size_t>(before / 24);
  for (std::size_t b = 0; b < TACTUS_STROKE_BANDS; ++b) {
    double highest = 0;
    for (std::size_t n = onset_frame - least; n < own_frames.size(); ++n) {
      highest = std::max(highest, rest_frames[n][b]);
      if (n >= onset_frame && own_frames[n][b] >= highest) return true;
    }
  }
  return false;
}

void TakeScore::add(const TakeScore& other) {
  strokes += other.strokes;
  missed += other.missed;
  extra += other.extra;
  audible += other.audible;
  audible_missed += other.audible_missed;
  delays_s.insert(delays_s.end(), other.delays_s.begin(), other.delays_s.end());
}

TakeScore score_take(const Take& take, const std::vector<double>& detections_s) {
  TakeScore score;
  std::size_t next = 0, stroke = 0;
  for (double stroke_s : take.strokes_s) {
    const bool audible = !take.audible.empty() && take.audible[stroke++];
    ++score.strokes;
    score.audible += audible;
    while (next < detections_s.size() && detections_s[next] < stroke_s - 0.0005) ++next, ++score.extra;
    if (next < detections_s.size() && detections_s[next] <= stroke_s + 0.010)
      score.delays_s.push_back(detections_s[next++] - stroke_s);
    else
      ++score.missed, score.audible_missed += audible;
  }
  score.extra += static_cast<int>(detections_s.size() - next);
  return score;
}

}  // namespace tactus::study
