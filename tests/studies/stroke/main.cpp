// The benchmark of stroke detectors on takes of single strokes, and the training of the nets of `stroke` for
// scripts/train_stroke. See scripts/study_stroke.
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
#include "tests/studies/onset/random.h"
#include "tests/studies/stroke/takes.h"
#include "tests/studies/stroke/train.h"

namespace {

namespace fs = std::filesystem;
using namespace tactus::study;
using Detector = std::function<std::vector<double>(const std::vector<float>&)>;

int usage() {
  std::fputs(
      "stroke_study recordings                what each part is made of\n"
      "stroke_study train EPOCHS SEEDS FILE FRAMES...   nets of lookaheads of FRAMES: FILE3.0, FILE3.1 ...\n"
      "stroke_study choose NET...             for each net: the bar, second hold [s] and margin of the "
      "fewest\n"
      "                                       errors on the choice kits, these errors in percent, and the "
      "false\n"
      "                                       strokes in noise\n"
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

void save_net(const std::string& where, const tactus_stroke_net& net) {
  std::ofstream file(where);
  file.precision(9);
  file << net.lookahead << ' ' << net.bar << ' ' << net.second_hold_s << ' ' << net.second_margin << '\n';
  const auto write = [&](const double* numbers, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) file << numbers[i] << '\n';
  };
  write(net.band[0], sizeof net.band / sizeof(double));
  write(net.band_bias[0], sizeof net.band_bias / sizeof(double));
  write(net.joint[0], sizeof net.joint / sizeof(double));
  write(net.age[0], sizeof net.age / sizeof(double));
  write(net.joint_bias, TACTUS_STROKE_JOINT);
  write(net.last, TACTUS_STROKE_JOINT);
  write(&net.last_bias, 1);
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

/// 1 near the time for which the net is trained, -1: not used, 0: no stroke.
int label(const Take& take, std::size_t& next, double end_s, double lookahead_s) {
  if (take.strokes_s.empty()) return 0;
  while (next + 1 < take.strokes_s.size() && take.strokes_s[next + 1] <= end_s) ++next;
  const double since = end_s - take.strokes_s[next];
  if (since < 0 || since > 0.012) return 0;
  return since >= lookahead_s - 0.00055 && since <= lookahead_s + 0.001 ? 1 : -1;
}

constexpr int kHold = 20;  // frames

/// Decisions, on which depends what the net sees of the last stroke.
class Decisions {
 public:
  /// Without `bar` those of a good detector: it misses 8 % of the strokes and detects a false one each 2 s.
  /// With it those of the net itself.
  Decisions(const std::string& seed, const double* bar) : random_(seed), bar_(bar) {}

  /// Call at the end of each frame, `since_s` after the last onset.
  void follow(tactus_stroke& state, std::size_t stroke, double since_s, double last_s) {
    if (bar_ ? by_net(state) : by_truth(stroke, since_s, last_s)) tactus_stroke_strike(&state, 1);
  }

 private:
  bool by_truth(std::size_t stroke, double since_s, double last_s) {
    const bool due = stroke != stroke_ && since_s >= last_s;
    if (due) stroke_ = stroke;
    const bool false_one =
        random_.uniform() < 0.5 * TACTUS_STROKE_FRAME_S && (since_s < 0 || since_s > 0.012);
    return (due && random_.uniform() > 0.08) || false_one;
  }
  bool by_net(const tactus_stroke& state) const {
    const int rest = 600;  // frames: 0.3 s, after which tactus_stroke_decide wants more evidence
    return state.frames >= 200 && state.since >= kHold &&
           state.evidence > *bar_ + (state.since > rest ? 3 : 0);
  }

  Random random_;
  const double* bar_;
  std::size_t stroke_ = ~std::size_t{0};
};

std::vector<Take> make_takes(const char* part) {
  const TakeMaker maker(part_named(part));
  std::vector<Take> takes;
  for (int i = 0; i < maker.part().takes; ++i) takes.push_back(maker.make(i));
  return takes;
}

void add_examples(const std::vector<Take>& takes, tactus_stroke_net net, const double* bar,
                  std::vector<Example>& examples) {
  net.bar = 1e9;  // `Decisions` decides
  const double lookahead_s = 0.0005 * (net.lookahead - 1), last_s = lookahead_s + 0.001;
  for (const Take& take : takes) {
    Decisions decisions(take.name, bar);
    Random random(take.name + (bar ? " own" : " used"));
    std::size_t next = 0;
    run(take.audio, net, [&](tactus_stroke& state, double end_s, bool) {
      const int truth = label(take, next, end_s, lookahead_s);
      const bool used = state.frames >= 200 && truth >= 0 && (truth == 1 || random.uniform() < 0.2);
      if (used && state.since >= kHold) {
        Example& example = examples.emplace_back();
        for (int k = 0; k < TACTUS_STROKE_FEATURES; ++k)
          for (int b = 0; b < TACTUS_STROKE_BANDS; ++b)
            example.levels[k][b] = static_cast<float>(state.x[k][b]);
        for (int k = 0; k < TACTUS_STROKE_AGES; ++k) example.after[k] = static_cast<float>(state.after[k]);
        example.stroke = static_cast<float>(truth);
        example.weight = 1;
      }
      if (!take.strokes_s.empty()) decisions.follow(state, next, end_s - take.strokes_s[next], last_s);
    });
  }
}

int train_nets(int epochs, int seeds, const std::string& file, const std::vector<std::string>& lookaheads) {
  const std::vector<Take> takes = make_takes("design"), noise = make_takes("design_noise");
  const double bar = 2, rate = 4e-3;
  for (const std::string& frames : lookaheads) {
    std::vector<Example> examples;
    examples.reserve(4000000);
    add_examples(takes, first_net(std::stoi(frames), 0), nullptr, examples);
    add_examples(noise, first_net(std::stoi(frames), 0), nullptr, examples);
    const std::size_t simulated = examples.size();
    std::fprintf(stderr, "%s frames: %zu examples\n", frames.c_str(), simulated);
    for (int seed = 0; seed < seeds; ++seed) {
      const tactus_stroke_net first = train(first_net(std::stoi(frames), seed), examples, epochs, rate);
      add_examples(takes, first, &bar, examples);
      save_net(file + frames + "." + std::to_string(seed), train(first, examples, epochs / 2, rate / 2));
      examples.resize(simulated);
    }
  }
  return 0;
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

/// Of takes that are made once.
int count_errors(const std::vector<Take>& takes, const tactus_stroke_net& net) {
  TakeScore total;
  for (const Take& take : takes) total.add(score_take(take, detect_stroke(take.audio, net)));
  return total.missed + total.extra;
}

int choose(const std::vector<std::string>& files) {
  const std::vector<Take> takes = make_takes("choice"), noise = make_takes("choice_noise");
  int strokes = 0;
  for (const Take& take : takes) strokes += static_cast<int>(take.strokes_s.size());
  for (const std::string& file : files) {
    tactus_stroke_net net = load_net(file), best = net;
    int least = 1 << 30, least_noisy = 0;
    const auto attempt = [&](double bar, double hold_s, double margin) {
      net.bar = bar, net.second_hold_s = hold_s, net.second_margin = margin;
      const int noisy = count_errors(noise, net), cost = count_errors(takes, net) + 20 * noisy;
      if (cost >= least) return;
      least = cost, least_noisy = noisy, best = net;
    };
    for (double bar : {1.5, 2.0, 2.5, 3.0}) attempt(bar, 0.020, 1);
    const double middle = best.bar;
    for (double bar : {middle - 0.25, middle + 0.25}) attempt(bar, 0.020, 1);
    const double chosen = best.bar;
    for (auto [hold_s, margin] : {std::pair{0.010, 0.0}, {0.024, 2.0}}) attempt(chosen, hold_s, margin);
    std::printf("%s %g %g %g %.3f %d\n", file.c_str(), best.bar, best.second_hold_s, best.second_margin,
                100.0 * (least - 20 * least_noisy) / strokes, least_noisy);
    std::fflush(stdout);
  }
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
  if (command == "train" && words.size() > 4)
    return train_nets(std::stoi(words[1]), std::stoi(words[2]), words[3], {words.begin() + 4, words.end()});
  if (command == "choose" && words.size() > 1) return choose({words.begin() + 1, words.end()});
  if (command == "write" && words.size() == 3) return write_takes(words[1], words[2]);
  if (command == "times" && words.size() == 3) return report_times(words[1], words[2]);
  if (command == "report" && words.size() == 2) return report(words[1]);
  if (command == "takes" && words.size() == 3) return list_takes(words[1], words[2]);
  if (command == "cost" && words.size() == 1) return cost();
  return usage();
}
