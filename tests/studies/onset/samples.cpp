#include "tests/studies/onset/samples.h"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <numeric>
#include <regex>

namespace tactus::study {
namespace {

namespace fs = std::filesystem;

struct Rule {
  const char* kind;
  const char* path;  ///< regular expression on the path below /usr/share
};

// Drums that one stroke of a stick, beater or hand makes sound, from kits that say they are recordings. Left
// out as kinds: electronic and beat-box kits, cymbals and open hats, and what is many strokes by nature
// (claps, shakers, tambourines, snare rolls, hats closed by foot).
const std::vector<Rule> kAcoustic = {
    {"snare",
     R"(BJA_Pacific/SN4?_|Colombo.*/snare|Forzee.*/Snare(Off)?-|Millo-.*/snare|MultiLayered2/[jr]snare|MultiLayered3/(sd|sr)_|Black Pearl.*/PearlSnare|samples/drum_snare)"},
    {"tom",
     R"(BJA_Pacific/TM2?_|Colombo.*/tom|Forzee.*/Tom|Millo-.*/tom|MultiLayered2/(floor)?tom|MultiLayered3/(ft|t1|t2)_|Black Pearl.*/PearlTom|samples/drum_tom)"},
    {"kick",
     R"(BJA_Pacific/BD_|Colombo.*/bassdrum|Forzee.*/Kick|Millo-.*/bd|MultiLayered[23]/bd|Black Pearl.*/PearlKick|samples/drum_(heavy_kick|bass))"},
    {"rim, stick",
     R"(Colombo.*/stick|Forzee.*/(RimClick|Stick|Snare(Off)?Rim)|Millo-.*/stick|MultiLayered2/rim|MultiLayered3/rs_|Black Pearl.*/PearlSideStick)"},
    {"closed hat",
     R"(BJA_Pacific/HH_|Colombo.*/hihat-closed|Forzee.*/HiHatClosed|Millo-.*/closehihat|MultiLayered2/hhclosed|MultiLayered3/hh_0|Black Pearl.*/SabianHatClosed|samples/drum_cymbal_closed)"},
    {"hand drum",
     R"(Gimme.*/(Bongo|Cajon)|circAfrique.*/(Djembe|Kenkeni1_Head|Sangban1_Head|Dununba1_Head)|samples/tabla_)"},
    {"wood, bell",
     R"(Gimme.*/(WoodBlock|Clave|Cowbell)|Forzee.*/Agogo|Black Pearl.*/Cowbell|circAfrique.*Bell|samples/drum_cowbell)"},
};

const std::vector<Rule> kElectronic = {
    {"snare", R"(VariBreaks/VP Snare|ElectricEmpire.*/EE_Snare|HardElectro1/PowR_SN|Audiophob/.*snare)"},
    {"tom", R"(VariBreaks/VP (Tom|Drum)|ElectricEmpire.*/EE_(Conga|Drum)|Audiophob/.*tom)"},
    {"rim, stick", R"(VariBreaks/VP Click|ElectricEmpire.*/EE_Click)"},
};

struct Recording {
  std::vector<float> mono;
  int rate = 0;
};

Recording read(const fs::path& file) {
  SF_INFO info{};
  SNDFILE* sound = sf_open(file.c_str(), SFM_READ, &info);
  if (!sound) return {};
  std::vector<float> all(static_cast<std::size_t>(info.frames * info.channels));
  sf_readf_float(sound, all.data(), info.frames);
  sf_close(sound);
  Recording result{std::vector<float>(static_cast<std::size_t>(info.frames)), info.samplerate};
  const auto channels = static_cast<std::size_t>(info.channels);
  for (std::size_t n = 0; n < all.size(); ++n)
    result.mono[n / channels] += all[n] / static_cast<float>(channels);
  return result;
}

/// Band-limited interpolation from a whole number of frames a second: sinc under a Hann window of 16 zero
/// crossings on each side, one row of taps for each of the places between input frames that occur.
class Interpolator {
 public:
  Interpolator(int rate, double shift_frames)
      : step_(rate), wide_(std::max(1.0, rate / kRate)), half_(static_cast<int>(std::ceil(kHalf * wide_))) {
    const int places = static_cast<int>(kRate) / std::gcd(rate, static_cast<int>(kRate));
    for (int n = 0; n < places; ++n) {
      const double centre = (n - shift_frames) * rate / kRate;
      std::vector<float> taps;
      for (int k = -half_; k <= half_; ++k)
        taps.push_back(static_cast<float>(kernel((std::floor(centre) + k - centre) / wide_) / wide_));
      taps_.push_back(std::move(taps));
    }
    shift_ = shift_frames;
  }

  float at(const std::vector<float>& in, std::size_t n) const {
    const double centre = (static_cast<double>(n) - shift_) * step_ / kRate;
    const auto first = static_cast<long>(std::floor(centre)) - half_;
    const std::vector<float>& taps = taps_[n % taps_.size()];
    const auto from = static_cast<std::size_t>(std::max(0L, -first));
    float sum = 0;
    for (std::size_t k = from;
         k < taps.size() && static_cast<std::size_t>(first + static_cast<long>(k)) < in.size(); ++k)
      sum += taps[k] * in[static_cast<std::size_t>(first + static_cast<long>(k))];
    return sum;
  }

 private:
  static constexpr int kHalf = 16;

  static double kernel(double crossings) {
    if (std::abs(crossings) >= kHalf) return 0;
    const double angle = std::numbers::pi * crossings;
    return (angle == 0 ? 1 : std::sin(angle) / angle) * (0.5 + 0.5 * std::cos(angle / kHalf));
  }

  int step_;
  double wide_, shift_ = 0;
  int half_;
  std::vector<std::vector<float>> taps_;
};

std::vector<float> resampled(const std::vector<float>& in, int rate, double shift_frames) {
  static std::map<std::pair<int, double>, Interpolator> interpolators;
  const auto& interpolator =
      interpolators.try_emplace({rate, shift_frames}, rate, shift_frames).first->second;
  std::vector<float> out(
      static_cast<std::size_t>(std::min(static_cast<double>(in.size()) * kRate / rate, 0.7 * kRate)));
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = interpolator.at(in, n);
  return out;
}

void finish(std::vector<float>& hit) {
  float highest = 0;
  for (float x : hit) highest = std::max(highest, std::abs(x));
  const auto fade = std::min<std::size_t>(hit.size(), 960);  // 20 ms: a cut tail would click
  for (std::size_t n = 0; n < hit.size(); ++n) {
    const std::size_t left = hit.size() - n;
    hit[n] *= (left < fade ? static_cast<float>(left) / static_cast<float>(fade) : 1.0f) / highest;
  }
}

/// Adds the recording, unless a rule excludes it; whether it was added.
bool add_sample(SampleSet& set, const fs::path& file, const std::string& name, const std::string& kind,
                bool training) {
  const Recording recording = read(file);
  if (static_cast<double>(recording.mono.size()) < 0.03 * recording.rate) {
    set.excluded.push_back(name + ": shorter than 30 ms");
    return false;
  }
  Sample sample{name, kind, training, {}, {}};
  const std::vector<float> hit = trimmed(recording.mono);
  for (int shift = 0; shift < kShifts; ++shift) {
    auto& shifted = sample.shifted[static_cast<std::size_t>(shift)];
    shifted = resampled(hit, recording.rate, static_cast<double>(shift) / kShifts);
    finish(shifted);
    sample.clean[static_cast<std::size_t>(shift)] = measure(shifted, kRate);
  }
  if (sample.clean[0].several_strokes) {
    set.excluded.push_back(name + ": several strokes, or still rising after 20 ms");
    return false;
  }
  set.samples.push_back(std::move(sample));
  return true;
}

}  // namespace

SampleSet load_kit(const std::string& folder) {
  SampleSet set;
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(folder, none))
    if (!entry.is_directory()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files)
    add_sample(set, file, fs::path(folder).filename().string() + "/" + file.stem().string(),
               file.parent_path().filename().string(), false);
  return set;
}

SampleSet load_samples(Recordings recordings, const std::vector<std::string>& kits) {
  SampleSet set;
  std::vector<fs::path> files;
  for (const char* folder : {"/usr/share/hydrogen/data/drumkits", "/usr/share/sonic-pi/samples"}) {
    std::error_code none;
    for (const auto& entry : fs::recursive_directory_iterator(folder, none)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  for (const Rule& rule : recordings == Recordings::Electronic ? kElectronic : kAcoustic) {
    const std::regex pattern(rule.path);
    bool training = false;
    for (const fs::path& file : files) {
      if (!std::regex_search(file.string(), pattern)) continue;
      const std::string kit = file.parent_path().filename().string(), name = kit + "/" + file.stem().string();
      if (!kits.empty() && std::count(kits.begin(), kits.end(), kit) == 0) continue;
      if (add_sample(set, file, name, rule.kind, training)) training = !training;
    }
  }
  return set;
}

}  // namespace tactus::study
