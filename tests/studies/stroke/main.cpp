// The benchmark of stroke detectors on takes of single strokes. See scripts/study_stroke.
#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>

#include "engine/dsp/envelopes/onset_kernel.h"
#include "engine/dsp/envelopes/stroke.h"
#include "tests/studies/stroke/takes.h"

namespace {

namespace fs = std::filesystem;
using namespace tactus::study;
using Detector = std::function<std::vector<double>(const std::vector<float>&)>;

int usage() {
  std::fputs(
      "stroke_study recordings                what each part is made of\n"
      "stroke_study write PART DIR            takes as DIR/NAME.wav\n"
      "stroke_study times PART DIR            scores DIR/NAME.txt, the times that another detector printed\n"
      "stroke_study report PART               the detectors of the engine: rows of Markdown\n"
      "stroke_study takes PART NET            the errors of each take\n"
      "stroke_study cost                      time of a second of sound: rows of Markdown\n"
      "NET: 0 to 3, a net of the engine, or a file of numbers in the order of tactus_stroke_net\n",
      stderr);
  return 2;
}

const Part& part_named(const std::string& name) {
  for (const Part& part : all_parts())
    if (part.name == name) return part;
  std::fprintf(stderr, "no part '%s'\n", name.c_str());
  std::exit(2);
}

/// The numbers of a net, all tactus_real but the first.
tactus_stroke_net load_net(const std::string& where) {
  if (where.size() == 1) return tactus_stroke_nets[std::stoi(where)];
  tactus_stroke_net net{};
  std::ifstream file(where);
  file >> net.lookahead >> net.bar >> net.second_hold_s >> net.second_margin;
  const auto read = [&](double* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) file >> numbers[i];
  };
  read(net.band[0], sizeof net.band / sizeof(double));
  read(net.band_bias[0], sizeof net.band_bias / sizeof(double));
  read(net.joint[0], sizeof net.joint / sizeof(double));
  read(net.age[0], sizeof net.age / sizeof(double));
  read(net.joint_bias, TACTUS_STROKE_JOINT);
  read(net.last, TACTUS_STROKE_JOINT);
  file >> net.last_bias;
  if (!file) {
    std::fprintf(stderr, "%s: not a net\n", where.c_str());
    std::exit(2);
  }
  return net;
}

/// Calls `frame(state, end_s, stroke)` at the end of each frame of 0.5 ms. `reference`: with one, for its
/// cost.
template <class Frame>
void run(const std::vector<float>& audio, const tactus_stroke_net& net, const Frame& frame,
         bool reference = false) {
  tactus_stroke state{};
  tactus_stroke_start(&state, kRate, &net);
  const std::vector<double> in(audio.begin(), audio.end());
  for (std::size_t n = 0; n < in.size();) {
    const int count = tactus_stroke_samples_left(&state, static_cast<int>(in.size() - n));
    const int stroke = tactus::follow_stroke(state, &in[n], reference ? &in[n] : nullptr, count, 0, 0.010);
    n += static_cast<std::size_t>(count);
    if (state.samples == 0) frame(state, static_cast<double>(n - 1) / kRate, stroke != 0);
  }
}

int write_takes(const std::string& part, const fs::path& folder) {
  const TakeMaker maker(part_named(part));
  for (int i = 0; i < maker.part().takes; ++i) {
    const Take take = maker.make(i);
    SF_INFO info{};
    info.samplerate = static_cast<int>(kRate);
    info.channels = 1;
    info.format = SF_FORMAT_WAV | SF_FORMAT_FLOAT;
    SNDFILE* file = sf_open((folder / (take.name + ".wav")).c_str(), SFM_WRITE, &info);
    if (!file) return 3;
    sf_writef_float(file, take.audio.data(), static_cast<sf_count_t>(take.audio.size()));
    sf_close(file);
  }
  return 0;
}

void print_row(const std::string& name, TakeScore score) {
  std::sort(score.delays_s.begin(), score.delays_s.end());
  const auto at = [&](double share) {
    const auto last = static_cast<double>(score.delays_s.size()) - 1;
    return last < 0 ? 0 : 1e3 * score.delays_s[static_cast<std::size_t>(share * last + 0.5)];
  };
  const int errors = score.missed + score.extra;
  const double share = static_cast<double>(errors) / std::max(1, score.strokes);
  const double audible = static_cast<double>(score.audible_missed + score.extra) / std::max(1, score.audible);
  std::printf("| %s | %d | %d | %d | %.1f | %.1f %% | %.1f | %.2f | %.2f | %.1f |\n", name.c_str(),
              score.strokes, score.missed, score.extra, 827 * share, 100 * share, 827 * audible, at(0.5),
              at(0.95), at(1));
}

int report_times(const std::string& part, const fs::path& folder) {
  const TakeMaker maker(part_named(part), true);
  TakeScore total;
  for (int i = 0; i < maker.part().takes; ++i) {
    Take take = maker.make(i);
    std::ifstream file(folder / (take.name + ".txt"));
    std::vector<double> times;
    for (double time = 0; file >> time;)
      if (time > 0.1) times.push_back(time);  // aubioonset reports the start of the file
    total.add(score_take(take, times));
  }
  print_row(folder.filename().string(), total);
  return 0;
}

std::vector<double> detect_onset(const std::vector<float>& audio) {
  tactus_onset state{};
  tactus_onset_start(&state, kRate, 30, 0.020, 0.028);
  std::vector<double> times;
  for (std::size_t n = 0; n < audio.size(); ++n)
    if (tactus_onset_step(&state, static_cast<double>(audio[n]), 0.01995262314968880, 0.015, 1.41253754462275,
                          7) != 0)
      times.push_back(static_cast<double>(n) / kRate);
  return times;
}

std::vector<double> detect_stroke(const std::vector<float>& audio, const tactus_stroke_net& net,
                                  bool reference = false) {
  std::vector<double> times;
  run(
      audio, net,
      [&](const tactus_stroke&, double end_s, bool stroke) {
        if (stroke) times.push_back(end_s);
      },
      reference);
  return times;
}

const char* const kNets[] = {"0.5 ms", "1 ms", "2 ms", "3 ms"};

int report(const std::string& name) {
  const TakeMaker maker(part_named(name), true);
  TakeScore scores[5];
  for (int i = 0; i < maker.part().takes; ++i) {
    const Take take = maker.make(i);
    scores[0].add(score_take(take, detect_onset(take.audio)));
    for (int k = 0; k < 4; ++k)
      scores[k + 1].add(score_take(take, detect_stroke(take.audio, tactus_stroke_nets[k])));
  }
  if (scores[0].strokes > 0)
    std::printf("| audible: %.1f %% | | | | | | | | | |\n", 100.0 * scores[0].audible / scores[0].strokes);
  print_row("`onset`", scores[0]);
  for (int k = 0; k < 4; ++k) print_row(std::string("`stroke`, ") + kNets[k], scores[k + 1]);
  return 0;
}

/// Errors of each take, to see where a detector fails.
int list_takes(const std::string& name, const std::string& where) {
  const TakeMaker maker(part_named(name));
  const tactus_stroke_net net = load_net(where);
  for (int i = 0; i < maker.part().takes; ++i) {
    const Take take = maker.make(i);
    TakeScore score = score_take(take, detect_stroke(take.audio, net));
    std::sort(score.delays_s.begin(), score.delays_s.end());
    const double median = score.delays_s.empty() ? 0 : score.delays_s[score.delays_s.size() / 2];
    std::printf("%s: %.1f a second, %d strokes, %d missed, %d false, median delay %.2f ms: %s\n",
                take.name.c_str(), take.rate, score.strokes, score.missed, score.extra, 1e3 * median,
                take.recordings.c_str());
  }
  return 0;
}

/// Processor time, the least of several runs: others use the machine too.
template <class Detect>
void print_cost(const char* name, const std::vector<float>& audio, const Detect& detect) {
  double least_s = 1e9;
  for (int run = 0; run < 100; ++run) {
    const std::clock_t start = std::clock();
    if (detect(audio).size() > audio.size()) std::abort();  // so that nothing is optimised away
    least_s = std::min(least_s, static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::printf("| %s | %.3f %% |\n", name, 100 * least_s / (static_cast<double>(audio.size()) / kRate));
}

int cost() {
  Part part = part_named("choice");
  std::vector<float> audio = TakeMaker(part).make(0).audio;
  print_cost("`onset`", audio, detect_onset);
  for (int k = 0; k < 4; ++k)
    print_cost((std::string("`stroke`, ") + kNets[k]).c_str(), audio,
               [&](const std::vector<float>& in) { return detect_stroke(in, tactus_stroke_nets[k]); });
  print_cost("`stroke`, 1 ms, with a reference", audio,
             [](const std::vector<float>& in) { return detect_stroke(in, tactus_stroke_nets[1], true); });
  return 0;
}

int recordings() {
  for (const Part& part : all_parts()) {
    const TakeMaker maker(part);
    int strokes = 0;
    for (int i = 0; i < part.takes; ++i) strokes += static_cast<int>(maker.make(i).strokes_s.size());
    std::printf("%s: %zu recordings, %d takes, %d strokes\n", part.name.c_str(), maker.names().size(),
                part.takes, strokes);
    for (const std::string& name : maker.names()) std::printf("  %s\n", name.c_str());
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  const std::string command = words.empty() ? "" : words[0];
  if (command == "recordings" && words.size() == 1) return recordings();
  if (command == "write" && words.size() == 3) return write_takes(words[1], words[2]);
  if (command == "times" && words.size() == 3) return report_times(words[1], words[2]);
  if (command == "report" && words.size() == 2) return report(words[1]);
  if (command == "takes" && words.size() == 3) return list_takes(words[1], words[2]);
  if (command == "cost" && words.size() == 1) return cost();
  return usage();
}
