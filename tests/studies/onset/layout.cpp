#include "tests/studies/onset/layout.h"

#include <cmath>
#include <numbers>

#include "tests/studies/onset/random.h"

namespace tactus::study {
namespace {

double gain(double db) { return std::pow(10.0, db / 20); }

struct Stroke {
  double after_s;  ///< the section's start
  double level_db;
};

std::vector<Stroke> strokes(const Plan& plan, double rate, double level_db) {
  std::vector<Stroke> result;
  const int count = plan.pattern == "crescendo" ? 16 : 8;
  for (int k = 0; k < count; ++k) {
    const double time = k / rate;
    if (plan.pattern == "accent_12")
      result.push_back({time, level_db - (k % 2 ? 12 : 0)});
    else if (plan.pattern == "accent_20")
      result.push_back({time, level_db - (k % 2 ? 20 : 0)});
    else if (plan.pattern == "crescendo")
      result.push_back({time, level_db - 30 + 2.0 * k});
    else if (plan.pattern == "flam") {
      result.push_back({time, level_db - 6});
      result.push_back({time + 0.030, level_db});
    } else
      result.push_back({time, level_db});
  }
  return result;
}

void add(Layout& layout, const Plan& plan, const Sample& sample, double time_s, double level_db,
         double rate) {
  const double place = time_s * kRate * kShifts;
  const auto quarters = static_cast<std::size_t>(place);
  const std::size_t start = quarters / kShifts, shift = quarters % kShifts;
  const std::vector<float>& hit = sample.shifted[shift];
  if (layout.audio.size() < start + hit.size()) layout.audio.resize(start + hit.size());
  const auto scale = static_cast<float>(gain(level_db));
  for (std::size_t n = 0; n < hit.size(); ++n) layout.audio[start + n] += scale * hit[n];
  const CleanHit& clean = sample.clean[shift];
  layout.hits.push_back({.time_s = static_cast<double>(start) / kRate + clean.onset,
                         .level_db = level_db,
                         .fast = clean.rise < 0.001,
                         .training = sample.training,
                         .kind = sample.kind,
                         .sample = sample.name,
                         .pattern = plan.pattern,
                         .noise = plan.noise,
                         .rate = rate,
                         .rings = fall_db(hit, kRate, 1 / rate) < 6});
}

void add_noise(std::vector<float>& audio, const std::string& noise, Random& random) {
  if (noise == "none") return;
  const double white = noise == "white_50" ? gain(-50) : gain(-60);
  for (std::size_t n = 0; n < audio.size(); ++n) {
    const double turn = 2 * std::numbers::pi * static_cast<double>(n) / kRate;
    double sum = white * random.normal();
    if (noise == "hum")
      sum += gain(-40) * std::sin(50 * turn) + gain(-46) * std::sin(150 * turn) +
             gain(-52) * std::sin(250 * turn);
    audio[n] += static_cast<float>(sum);
  }
}

}  // namespace

std::vector<Plan> all_plans() {
  std::vector<Plan> plans;
  const std::vector<double> rates = {4, 8, 15, 20, 30}, levels = {0, -10, -20, -30};
  for (const char* noise : {"none", "white_60", "white_50", "hum"}) {
    for (double rate : rates)
      plans.push_back({"steady_" + std::to_string(static_cast<int>(rate)) + "_" + noise,
                       "steady",
                       noise,
                       {rate},
                       levels});
    plans.push_back({std::string("soft_") + noise, "soft", noise, rates, {-40}, -46});
  }
  for (const char* pattern : {"accent_12", "accent_20", "crescendo", "mixed"})
    for (double rate : {8.0, 15.0, 30.0})
      plans.push_back(
          {pattern + ("_" + std::to_string(static_cast<int>(rate))), pattern, "white_60", {rate}, {0, -10}});
  plans.push_back({"flam", "flam", "white_60", {4, 8}, {0, -10, -20}});
  return plans;
}

Layout lay_out(const Plan& plan, const SampleSet& set) {
  Layout layout;
  Random random(plan.name);
  double start = 1.0;
  std::size_t turn = random.below(20);
  for (std::size_t i = 0; i < set.samples.size(); ++i, ++turn) {
    const double rate = plan.rates[turn % plan.rates.size()];
    const double level = plan.levels_db[turn / plan.rates.size() % plan.levels_db.size()];
    for (const Stroke& stroke : strokes(plan, rate, level)) {
      std::size_t drum = i;
      if (plan.pattern == "mixed")  // any other of the same half
        do drum = random.below(set.samples.size());
        while (set.samples[drum].training != set.samples[i].training);
      add(layout, plan, set.samples[drum], start + stroke.after_s + random.uniform() / kRate, stroke.level_db,
          rate);
    }
    start = static_cast<double>(layout.audio.size()) / kRate + 0.3;
  }
  layout.audio.resize(layout.audio.size() + static_cast<std::size_t>(0.3 * kRate));
  add_noise(layout.audio, plan.noise, random);
  return layout;
}

}  // namespace tactus::study
