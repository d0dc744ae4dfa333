#include "tests/studies/long_run/subjects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <filesystem>
#include <numbers>
#include <stdexcept>

#include "engine/core/median.h"
#include "engine/core/realtime.h"
#include "engine/dsp/pitch/pitch_detector.h"
#include "engine/guard/guarded.h"
#include "engine/nodes/table.h"
#include "engine/physics/network.h"
#include "engine/scene/build_scene.h"
#include "engine/scene/closed_loop.h"
#include "engine/scene/guard_report.h"
#include "tests/support/graphs/graph_runner.h"

namespace tactus::study {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kBlock = 64;

bool is_denormal(double x) { return x != 0 && std::abs(x) < std::numeric_limits<double>::min(); }

// ---- Scenes ----

/// A scene in a closed loop; keeps one signal of its windows. Gestures stay from `held_s` on as they are
/// then.
class ScenePlay : public Subject {
 public:
  ScenePlay(const std::string& file, std::string watched, double held_s) : watched_(std::move(watched)) {
    const std::filesystem::path root = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";
    auto scene = load_scene(root / file, root);
    if (!scene) throw std::runtime_error(to_string(scene.error()));
    scene_ = std::move(*scene);
    for (auto& gesture : scene_.gestures)
      std::erase_if(gesture.points, [&](const auto& point) { return point.time_s > held_s; });
    auto built = build_scene(scene_, standard_nodes());
    if (!built) throw std::runtime_error(to_string(built.error()));
    built_ = std::make_unique<BuiltScene>(std::move(*built));
    const auto& plan = built_->instrument->plan();
    guarded_ = std::make_unique<Guarded>(*built_->instrument, guarded_channels(plan, scene_.drives));
    loop_ = std::make_unique<ClosedLoop>(*guarded_, *built_->plant, built_->instrument->out_channels(),
                                         built_->delay_frames, scene_.converters);
    if (const auto status = loop_->prepare(scene_.rate, kBlock); !status)
      throw std::runtime_error(to_string(status.error()));
    guarded_->skip_soft_start();
    find_watched();
  }

  double rate() const override { return scene_.rate.value; }
  void advance(std::int64_t frames) override {
    for (; frames > 0; frames -= kPart) loop_->run(static_cast<int>(std::min(frames, kPart)));
  }

 protected:
  std::vector<double> window(double seconds) {
    std::vector<double> samples;
    loop_->run(static_cast<int>(seconds * rate()), [&](const ClosedLoop::Block& io) {
      const double* from = drive_ >= 0 ? io.drives.begin()[drive_] : player_->tap(tap_);
      samples.insert(samples.end(), from, from + io.frames);
    });
    return samples;
  }
  Row faults() const {
    std::int64_t count = 0;
    for (const auto* player : {built_->instrument.get(), built_->plant.get()}) {
      count += player->bad_input_samples();
      for (const auto& fault : player->faults()) count += fault.count;
    }
    return {"faults", "0", std::to_string(count), "0", count == 0};
  }

 private:
  static constexpr std::int64_t kPart = 1 << 20;

  void find_watched() {
    const auto find = [&](const auto& taps, Player& player) {
      for (std::size_t i = 0; i < taps.size(); ++i)
        if (player_ == nullptr && taps[i].name.starts_with(watched_))
          player_ = &player, tap_ = static_cast<int>(i);
    };
    find(built_->plant_taps, *built_->plant);
    find(built_->instrument_taps, *built_->instrument);
    const auto names = output_names(built_->instrument->plan());
    for (std::size_t i = 0; i < names.size(); ++i)
      if ("instrument." + names[i] == watched_) drive_ = static_cast<int>(i);
    if (player_ == nullptr && drive_ < 0) throw std::runtime_error("no signal " + watched_);
  }

  std::string watched_;
  SceneSpec scene_;
  std::unique_ptr<BuiltScene> built_;
  std::unique_ptr<Guarded> guarded_;
  std::unique_ptr<ClosedLoop> loop_;
  Player* player_ = nullptr;
  int tap_ = 0, drive_ = -1;
};

/// Strikes a second, over a minute.
class Drum final : public ScenePlay {
 public:
  Drum() : ScenePlay("haptic_drum/scene.toml", "instrument.hit", 1) {}
  void look() override {
    constexpr double kSeconds = 60;
    double hits = 0;
    for (const double hit : window(kSeconds)) hits += hit >= 0.5;
    rates_.push_back(hits / kSeconds);
  }
  std::vector<Row> rows() const override {
    const double first = rates_.front(), last = rates_.back();
    return {
        {"strikes per second, mean of a minute", fmt::format("{:.3f}", first), fmt::format("{:.3f}", last),
         "the same within a strike a minute", std::abs(last - first) <= 1.0 / 60 + 1e-9},
        faults()};
  }

 private:
  std::vector<double> rates_;
};

/// The pitch of a bowed string.
class Cellomobo final : public ScenePlay {
 public:
  Cellomobo() : ScenePlay("cellomobo/open_string.toml", "instrument.sound", 1) {}
  void look() override {
    std::vector<double> found;
    for (const auto& point : track_pitch(window(4), Hertz{rate()}, 40_Hz, 2_kHz))
      found.push_back(point.hertz);
    pitches_.push_back(median(std::move(found)));
  }
  std::vector<Row> rows() const override {
    const double first = pitches_.front(), last = pitches_.back(), apart = cents(last, first);
    return {{"pitch", fmt::format("{:.4f} Hz", first), fmt::format("{:.4f} Hz ({:+.3f} cents)", last, apart),
             "within 0.1 cent, the detector's error", std::abs(apart) <= 0.1},
            faults()};
  }

 private:
  std::vector<double> pitches_;
};

// ---- Networks ----

/// A chain between two walls in its first mode, or one mass on a spring, without losses:  omega = 2 sqrt(k/m)
/// sin(pi / (2 (masses + 1))), and what a solver makes of it.
class Chain final : public Subject {
 public:
  /// `turns`: omega / rate of the mode.
  Chain(Solver solver, int masses, double rate, double turns) : solver_(solver), rate_(rate) {
    constexpr double kMass = 1e-3;
    const double shape = std::numbers::pi / (masses + 1);
    omega_ = turns * rate;
    const double root = omega_ / (2 * std::sin(shape / 2));
    const double stiffness = kMass * root * root;
    NetworkElements elements;
    elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
    for (int i = 1; i <= masses; ++i)
      elements.points.push_back({.mass = kMass, .position = 1e-3 * std::sin(i * shape), .input = {}});
    elements.points.push_back({.kind = Point::Kind::Ground, .input = {}});
    for (int i = 0; i <= masses; ++i) elements.springs.push_back({i, i + 1, stiffness});
    watched_ = (masses + 1) / 2;
    auto network = Network::make(elements, 0, Hertz{rate}, solver, 1);
    if (!network) throw std::runtime_error(to_string(network.error()));
    network_ = std::make_unique<Network>(std::move(*network));
    state_ = network_->initial_state();
    amplitude_ = network_->position(state_, watched_);
    energy_ = network_->energy(state_);
  }

  double rate() const override { return rate_; }
  void advance(std::int64_t frames) override {
    const NoDenormals no_denormals;
    for (std::int64_t n = 0; n < frames; ++n) network_->step(state_, nullptr);
    frame_ += frames;
  }
  /// Amplitude and phase by least squares over eight periods, and the largest change of energy.
  void look() override {
    const NoDenormals no_denormals;
    const long double angle = angle_of_frame();
    const int frames = static_cast<int>(std::ceil(kTurn / static_cast<double>(angle))) * 8;
    double cc = 0, cs = 0, ss = 0, xc = 0, xs = 0, most = 0;
    for (int n = 0; n < frames; ++n, ++frame_) {
      // Since the start, in long double: 1e9 frames.
      const auto turned = static_cast<double>(
          std::remainder(angle * static_cast<long double>(frame_), 2 * std::numbers::pi_v<long double>));
      const double c = std::cos(turned), s = std::sin(turned), x = network_->position(state_, watched_);
      cc += c * c, cs += c * s, ss += s * s, xc += x * c, xs += x * s;
      most = std::max(most, std::abs(network_->energy(state_) / energy_ - 1));
      network_->step(state_, nullptr);
    }
    const double below = cc * ss - cs * cs;
    const std::complex<double> fitted{(xc * ss - xs * cs) / below, (xs * cc - xc * cs) / below};
    looks_.push_back({std::abs(fitted) / amplitude_, -std::arg(fitted), most});
  }
  std::vector<Row> rows() const override {
    const double frames = static_cast<double>(frame_), turns = omega_ / rate_ * frames / kTurn;
    const auto &first = looks_.front(), &last = looks_.back();
    const double phase = std::remainder(last.phase - first.phase, kTurn);
    // Each step rounds some four numbers by 1.1e-16; if no rounding cancels another, they add up.
    const double bound = 4 * 1.1e-16 * frames + 1e-9;
    return {{"energy, beside that at the start", fmt::format("{:.1e}", first.energy),
             fmt::format("{:.1e}", last.energy), fmt::format("below {:.0e}, all roundings in line", bound),
             last.energy < first.energy + bound},
            {"amplitude", fmt::format("{:.9f}", first.amplitude), fmt::format("{:.9f}", last.amplitude),
             fmt::format("within {:.0e}", bound), std::abs(last.amplitude - first.amplitude) < bound},
            {"phase beside that of the difference equation", "0",
             fmt::format("{:+.1e} rad after {:.3g} turns", phase, turns),
             fmt::format("within {:.0e} of a turn each turn", kFrequency),
             std::abs(phase) < kTurn * kFrequency * turns + bound}};
  }

 private:
  /// The coefficient of the difference equation is rounded: a relative error of the frequency of some
  /// 1e-16 / (omega / rate)^2.
  static constexpr double kFrequency = 1e-13;

  /// Angle of a frame: what the difference equation makes of omega. Passive steps are explicit where these
  /// are stable.
  long double angle_of_frame() const {
    const long double w = omega_ / static_cast<long double>(rate_);
    switch (solver_) {
      case Solver::Explicit:
      case Solver::Passive:
        return 2 * std::asin(w / 2);
      case Solver::Implicit:
        return 2 * std::atan(w / 2);
      default:
        return w;
    }
  }

  Solver solver_;
  double rate_, omega_ = 0, amplitude_ = 0, energy_ = 0;
  int watched_ = 1;
  std::unique_ptr<Network> network_;
  NetworkState state_;
  std::int64_t frame_ = 0;
  struct Look {
    double amplitude, phase, energy;
  };
  std::vector<Look> looks_;
};

// ---- Graphs ----

/// A graph that plays on its own; `in` is 1 in the first frame.
class GraphPlay : public Subject {
 public:
  GraphPlay(const std::string& text, double rate) : rate_(rate) {
    CompileOptions options;
    options.sample_rate = Hertz{rate};
    auto plan = compile(parse_graph_leniently(text, "long_run.toml"), standard_nodes(), options);
    if (!plan) throw std::runtime_error(to_string(plan.error()));
    player_ = std::make_unique<Player>(std::move(*plan));
    outputs_.assign(static_cast<std::size_t>(player_->out_channels()), std::vector<double>(kBlock));
    if (const auto status = player_->prepare({Hertz{rate}, 1, player_->out_channels(), kBlock}); !status)
      throw std::runtime_error(to_string(status.error()));
  }
  double rate() const override { return rate_; }
  void advance(std::int64_t frames) override {
    for (; frames > 0; frames -= kBlock) block(static_cast<int>(std::min<std::int64_t>(frames, kBlock)));
  }

 protected:
  void block(int frames) {
    const NoDenormals no_denormals;
    std::array<double, kBlock> in{};
    in[0] = frame_ == 0 ? 1 : 0;
    const double* from[] = {in.data()};
    std::vector<double*> to;
    for (auto& output : outputs_) to.push_back(output.data());
    player_->process({from, to.data(), frames});
    frame_ += frames;
  }
  /// A second of all outputs.
  std::vector<std::vector<double>> window() {
    std::vector<std::vector<double>> samples(outputs_.size());
    for (int n = 0; n < static_cast<int>(rate_); n += kBlock) {
      block(kBlock);
      for (std::size_t o = 0; o < samples.size(); ++o)
        samples[o].insert(samples[o].end(), outputs_[o].begin(), outputs_[o].end());
    }
    return samples;
  }
  Row faults() const {
    return {"faults", "0", std::to_string(player_->faults().size()), "0", player_->faults().empty()};
  }

  double rate_;
  std::unique_ptr<Player> player_;
  std::vector<std::vector<double>> outputs_;
  std::int64_t frame_ = 0;
};

/// Tones of whole hertz: each is found by itself in a window of a second.
class Tones : public GraphPlay {
 public:
  Tones(const std::string& text, std::vector<double> hertz, double start, double decay_s)
      : GraphPlay(text, 48e3), hertz_(std::move(hertz)), start_(start), decay_s_(decay_s) {}
  void look() override {
    const auto from = frame_;
    const auto samples = window()[0];
    std::vector<std::complex<double>> found;
    for (const double f : hertz_) {
      std::complex<double> sum = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(rate_); ++n) {
        const auto since =
            std::fmod(f * static_cast<double>(from + static_cast<std::int64_t>(n)), rate_) / rate_;
        const double gone = static_cast<double>(from + static_cast<std::int64_t>(n)) / rate_;
        const double level = decay_s_ > 0 ? std::exp(3 * std::numbers::ln10 * gone / decay_s_) : 1;
        sum += level * samples[n] * std::polar(1.0, -kTurn * since);
      }
      found.push_back(sum * std::complex<double>{0, 2 / rate_});
    }
    looks_.push_back(found);
  }
  std::vector<Row> rows() const override {
    double phase[2] = {}, level[2] = {};
    for (int k = 0; k < 2; ++k)
      for (const auto& x : k == 0 ? looks_.front() : looks_.back()) {
        phase[k] = std::max(phase[k], std::abs(std::arg(x)));
        level[k] = std::max(level[k], std::abs(std::abs(x) / start_ - 1));
      }
    const double frames = static_cast<double>(frame_);
    const double bound = 1.2e-16 * kTurn * frames + 1e-9;
    return {
        {"phase beside the equation, the worst tone", fmt::format("{:.1e} rad", phase[0]),
         fmt::format("{:.1e} rad", phase[1]), fmt::format("below {:.0e} rad, all roundings in line", bound),
         phase[1] < bound},
        {"level beside the equation, the worst tone", fmt::format("{:.1e}", level[0]),
         fmt::format("{:.1e}", level[1]), fmt::format("below {:.0e}", bound), level[1] < bound + level[0]},
        faults()};
  }

 private:
  std::vector<double> hertz_;
  double start_, decay_s_;
  std::vector<std::vector<std::complex<double>>> looks_;
};

/// What rings once and is silent afterwards: nothing that is not 0 may be denormal.
class Silence final : public GraphPlay {
 public:
  static constexpr const char* kText = R"(format = 1
[inputs]
in = {}
[nodes]
one_pole = { type = "one_pole", in = "in", cutoff = "20 Hz" }
low = { type = "low_pass", in = "in", cutoff = "100 Hz", q = 5 }
band = { type = "band_pass", in = "in", frequency = "1 kHz", q = 50 }
dc = { type = "dc_blocker", in = "in" }
modes = { type = "modal", in = "in", frequency = "220 Hz", series = "bar", modes = 12, decay = "4 s" }
string = { type = "string", in = "in", pitch = "110 Hz", gain = 0.999, loss = 0.01 }
fade = { type = "envelope", in = "in", release = "1 s" }
pulse = { type = "decay", trigger = "in", time = "1 s" }
loop = { type = "delay", in = "in + 0.99 * loop", time = "7.3 ms" }
[networks.body]
ball = { type = "oscillator", mass = "20 g", frequency = "440 Hz", damping_ratio = 0.001 }
knock = { type = "force", on = "ball", force = "in * 1 N" }
[outputs]
a = { from = "one_pole.low" }
b = { from = "low" }
c = { from = "band" }
d = { from = "dc" }
e = { from = "modes" }
f = { from = "string" }
g = { from = "fade" }
h = { from = "pulse" }
i = { from = "loop" }
j = { from = "body.ball.position / 1 m" }
)";
  Silence() : GraphPlay(kText, 48e3) {}
  void look() override {
    double most = 0;
    denormal_ = 0;
    for (const auto& output : window())
      for (const double x : output) most = std::max(most, std::abs(x)), denormal_ += is_denormal(x);
    levels_.push_back(most);
  }
  /// A step of a decay changes a value by a share of it, which is flushed to 0 below 2e-308; from there on it
  /// stays. The slowest here takes 1e-5 of it.
  std::vector<Row> rows() const override {
    return {{"largest sample", fmt::format("{:.1e}", levels_.front()), fmt::format("{:.1e}", levels_.back()),
             "below 1e-300, where a step of a decay is flushed to 0", levels_.back() < 1e-300},
            {"denormal samples", "", std::to_string(denormal_), "0", denormal_ == 0},
            faults()};
  }

 private:
  std::vector<double> levels_;
  int denormal_ = 0;
};

std::string modal_text(const std::vector<double>& hertz) {
  std::string list;
  for (const double f : hertz) list += (list.empty() ? "" : ", ") + fmt::format("\"{} Hz\"", f);
  return "format = 1\n[inputs]\nin = {}\n[nodes]\nm = { type = \"modal\", in = \"in\", frequencies = [" +
         list + "], decay = \"10000 s\", decay_slope = 0 }\n[outputs]\ny = { from = \"m\" }\n";
}

template <class Made, class... Arguments>
std::function<std::unique_ptr<Subject>()> making(Arguments... arguments) {
  return [=] { return std::make_unique<Made>(arguments...); };
}

}  // namespace

const std::vector<Entry>& subjects() {
  static const std::vector<double> kModes = {55, 110, 277, 440, 1000, 3001, 7919, 15000};
  static const std::vector<Entry> all = {
      {"drum", "haptic drum, a roll", making<Drum>()},
      {"cellomobo", "Cellomobo, the open string bowed", making<Cellomobo>()},
      {"chain_passive", "chain of 1,000 masses without losses, passive, 8 kHz",
       making<Chain>(Solver::Passive, 1000, 8e3, 0.0025)},
      {"mass_explicit", "a mass on a spring, explicit", making<Chain>(Solver::Explicit, 1, 48e3, 0.1)},
      {"mass_passive", "a mass on a spring, passive", making<Chain>(Solver::Passive, 1, 48e3, 0.1)},
      {"mass_implicit", "a mass on a spring, implicit", making<Chain>(Solver::Implicit, 1, 48e3, 0.1)},
      {"mass_exact", "a mass on a spring, exact", making<Chain>(Solver::Exact, 1, 48e3, 0.1)},
      {"modal", "8 modes that fall by 60 dB in 10,000 s",
       making<Tones>(modal_text(kModes), kModes, 1.0, 1e4)},
      {"sine", "a sine",
       making<Tones>(
           std::string{
               "format = 1\n[inputs]\nin = {}\n[nodes]\ns = { type = \"sine\", frequency = \"441 Hz\" }\n"
               "[outputs]\ny = { from = \"s\" }\n"},
           std::vector<double>{441}, 1.0, 0.0)},
      {"silence", "filters, modes, string, delays and a network after a click", making<Silence>()},
  };
  return all;
}

}  // namespace tactus::study
