#pragma once

#include <string>
#include <vector>

#include "tests/studies/onset/samples.h"

namespace tactus::study {

/// The kits are split whole, so that no drum of the report was in the design. Design: the net is trained on
/// them; choice: bars and holds are chosen on them; report: Red Zeppelin; second report: Colombo, which an
/// earlier detector was read on; electronic: kits that are not recordings of an acoustic drum, also for the
/// report. Parts without kits are noise alone, for each
/// of the three: noise of -70 to -36 dBFS through a one-pole low-pass at 100 Hz to 20 kHz, half of it with
/// hum of 50, 150 and 250 Hz.
struct Part {
  std::string name;
  std::vector<std::string> kits;
  int takes = 0;
  double take_s = 0;
  bool varied = false;  ///< takes as a microphone on another drum may pick them up: see vary.h
};

const std::vector<Part>& all_parts();

/// A recording laid out from single strokes, with the time of each.
struct Take {
  std::string name;
  std::string recordings;  ///< one, or two that alternate
  double rate = 0;         ///< strokes a second
  std::vector<double> strokes_s;
  std::vector<bool> audible;  ///< of each stroke; empty if not measured
  std::vector<float> audio;   ///< 48 kHz
};

/// Hits of the part's kits: snare, tom, rim or stick, hand drum, wood or bell. Left out, by a rule on the
/// clean hit: 30 % of the peak later than 5 ms after the onset, the peak later than 20 ms, a second stroke.
class TakeMaker {
 public:
  /// `audibility`: measures which strokes are audible. A stroke is audible if in one of the eight bands of
  /// the node `stroke` its own energy in some frame of 0.5 ms of its first 10 ms is at least the highest that
  /// all the rest (earlier strokes and noise) has in that band from 10 ms before the onset to that frame.
  explicit TakeMaker(Part part, bool audibility = false);

  const Part& part() const { return part_; }
  const std::vector<std::string>& names() const { return names_; }

  /// Take `index` of the part: the same bits each time. The recordings one after the other (in 30 % of the
  /// takes in turn with another one of the same drum) at 5 to 30 strokes a second, log-uniform, the times +-3
  /// % of the interval; each stroke 0 to a range of 3 to 24 dB below the loudest, which is 0 to 6 dB below
  /// full scale; white noise of -70 to -36 dBFS.
  Take make(int index) const;

 private:
  struct Hit {
    std::string name, drum;
    std::vector<std::vector<float>> shifted;
    std::vector<double> onset_s;
  };
  /// A stroke of a take.
  struct Layer {
    const std::vector<float>* sound;
    std::size_t start;
    float scale;
    double onset_s;
  };
  Take noise(int index) const;
  static bool is_audible(const std::vector<float>& take, const Layer& layer);

  Part part_;
  bool audibility_;
  std::vector<Hit> hits_;
  std::vector<std::string> names_;
};

/// What a detector does on takes.
struct TakeScore {
  int strokes = 0, missed = 0, extra = 0;
  int audible = 0, audible_missed = 0;  ///< of these, if it was measured
  std::vector<double> delays_s;

  void add(const TakeScore& other);
};

/// A stroke is detected if a detection lies between 0.5 ms before and 10 ms after its onset; a detection
/// belongs to one stroke; every other detection is false.
TakeScore score_take(const Take& take, const std::vector<double>& detections_s);

}  // namespace tactus::study
