// Lays out rolls of recorded hits, detects them, compares. See scripts/study_onset.
#include <sndfile.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>

#include "engine/dsp/envelopes/onset_kernel.h"
#include "tests/studies/onset/tables.h"

namespace tactus::study {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TrueHit, time_s, level_db, fast, training, kind, sample, pattern, noise,
                                   rate, rings)
}  // namespace tactus::study

namespace {

namespace fs = std::filesystem;
using namespace tactus::study;
using nlohmann::json;

int usage() {
  std::fputs(
      "onset_study plans              names of all files of the study, and their thresholds in dB\n"
      "onset_study samples            what is used, what is left out and why\n"
      "onset_study layout NAME DIR    writes DIR/NAME.wav and DIR/NAME.truth.json\n"
      "onset_study detect NAME DIR    writes DIR/NAME.events.json with the detector alone\n"
      "onset_study score DIR          compares all truth and events in DIR: Markdown\n",
      stderr);
  return 2;
}

const Plan* find_plan(const std::vector<Plan>& plans, const std::string& name) {
  for (const Plan& plan : plans)
    if (plan.name == name) return &plan;
  return nullptr;
}

int list_plans() {
  for (const Plan& plan : all_plans()) std::printf("%s %g\n", plan.name.c_str(), plan.threshold_db);
  return 0;
}

int list_samples() {
  const SampleSet set = load_samples();
  for (const Sample& sample : set.samples)
    std::printf("%s: %s, rises in %.2f ms\n", sample.name.c_str(), sample.kind.c_str(),
                1e3 * sample.clean[0].rise);
  for (const std::string& reason : set.excluded) std::printf("left out: %s\n", reason.c_str());
  std::printf("%zu used, %zu left out\n", set.samples.size(), set.excluded.size());
  return 0;
}

int lay_out_file(const Plan& plan, const fs::path& folder) {
  const Layout layout = lay_out(plan, load_samples());
  SF_INFO info{};
  info.samplerate = static_cast<int>(kRate);
  info.channels = 1;
  info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
  SNDFILE* file = sf_open((folder / (plan.name + ".wav")).c_str(), SFM_WRITE, &info);
  if (!file) return 3;
  sf_writef_float(file, layout.audio.data(), static_cast<sf_count_t>(layout.audio.size()));
  sf_close(file);
  std::ofstream(folder / (plan.name + ".truth.json")) << json{{"hits", layout.hits}} << '\n';
  return 0;
}

int detect_file(const Plan& plan, const fs::path& folder) {
  SF_INFO info{};
  SNDFILE* file = sf_open((folder / (plan.name + ".wav")).c_str(), SFM_READ, &info);
  if (!file) return 3;
  std::vector<double> audio(static_cast<std::size_t>(info.frames));
  sf_readf_double(file, audio.data(), info.frames);
  sf_close(file);
  tactus_onset onset{};
  tactus_onset_start(&onset, info.samplerate, 30, 0.020, 0.028);
  const double threshold = std::pow(10.0, plan.threshold_db / 20);
  json events = json::array();
  for (std::size_t n = 0; n < audio.size(); ++n)
    if (tactus_onset_step(&onset, audio[n], threshold, 0.015, 1.41, 7) != 0)
      events.push_back({{"time_s", static_cast<double>(n) / info.samplerate},
                        {"node", "hit"},
                        {"level_db", 20 * std::log10(onset.level)}});
  std::ofstream(folder / (plan.name + ".events.json")) << json{{"events", events}} << '\n';
  return 0;
}

int score_folder(const fs::path& folder) {
  std::vector<Outcome> outcomes;
  for (const Plan& plan : all_plans()) {
    std::ifstream truth(folder / (plan.name + ".truth.json")), events(folder / (plan.name + ".events.json"));
    if (!truth || !events) {
      std::fprintf(stderr, "%s: no truth or no events\n", plan.name.c_str());
      return 3;
    }
    const auto hits = json::parse(truth).at("hits").get<std::vector<TrueHit>>();
    std::vector<double> detections_s;
    const json document = json::parse(events);
    for (const json& event : document.at("events"))
      if (event.at("node") == "hit") detections_s.push_back(event.at("time_s"));
    const std::vector<Score> scores = match(hits, detections_s);
    for (std::size_t i = 0; i < hits.size(); ++i) outcomes.push_back({hits[i], scores[i]});
  }
  std::cout << tables(outcomes);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string command = words.empty() ? "" : words[0];
  if (command == "plans" && words.size() == 1) return list_plans();
  if (command == "samples" && words.size() == 1) return list_samples();
  if (command == "score" && words.size() == 2) return score_folder(words[1]);
  if (words.size() != 3) return usage();
  const std::vector<Plan> plans = all_plans();
  const Plan* plan = find_plan(plans, words[1]);
  if (plan && command == "layout") return lay_out_file(*plan, words[2]);
  if (plan && command == "detect") return detect_file(*plan, words[2]);
  return usage();
}
