#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <filesystem>

#include "engine/core/units.h"
#include "engine/nodes/table.h"
#include "engine/scene/play_scene.h"

using namespace tactus;

namespace {
const std::filesystem::path kInstruments = std::filesystem::path{TACTUS_SOURCE_DIR} / "instruments";

using Settings = std::map<std::string, ControlValue>;

std::vector<double> play(const char* file, Seconds duration, const Settings& set,
                         const char* signal = "plant.place", Seconds delay = 0_s) {
  auto scene = load_scene(kInstruments / file, kInstruments);
  if (!scene) throw std::runtime_error(to_string(scene.error()));
  scene->duration = duration;
  scene->expect.clear();
  SceneOptions options;
  options.set = set;
  options.delay = delay;
  auto built = build_scene(*scene, standard_nodes(), options);
  if (!built) throw std::runtime_error(to_string(built.error()));
  const auto recording = play_scene(*scene, *built, 64);
  if (!recording) throw std::runtime_error(to_string(recording.error()));
  return recording->find(signal)->samples;
}

/// A partial in a quarter of a second around `time_s`, as seen by one who turns with it.
std::complex<double> partial_at(const std::vector<double>& samples, double hertz, double time_s) {
  constexpr int kWindow = 12000;
  const int middle = static_cast<int>(time_s * 48000);
  std::complex<double> sum = 0;
  for (int i = -kWindow / 2; i < kWindow / 2; ++i) {
    const double hann = 1 + std::cos(2 * kPi * i / kWindow);
    const int n = middle + i;
    sum += hann * samples[static_cast<std::size_t>(n)] * std::polar(1.0, -2 * kPi * hertz * n / 48000);
  }
  return sum * (2.0 / kWindow);
}

/// The string of the monochord: 50 pieces of 0.1 g and 12.1 kN/m, felt at the seventh point.
struct Partial {
  int n;
  double lambda() const { return 4 * std::pow(std::sin(n * kPi / 100), 2); }
  double hertz() const {
    return 48000 / kPi * std::asin(std::sqrt(12100 / (1e-4 * 48000.0 * 48000.0) * lambda()) / 2);
  }
  double omega() const { return 2 * kPi * hertz(); }
  double sigma() const { return (0.23e-3 + 3e-3 * lambda()) / 2e-4; }
  double felt() const { return std::pow(std::sin(7 * n * kPi / 50), 2); }
};
constexpr double kStringMass = 5e-3;  // that of all 50 pieces

/// e^(rate t) of a partial, between two times: the real part is its growth, the imaginary one how much faster
/// it turns than `hertz` says.
std::complex<double> rate_of(const std::vector<double>& samples, double hertz, double from_s,
                             double until_s) {
  return std::log(partial_at(samples, hertz, until_s) / partial_at(samples, hertz, from_s)) /
         (until_s - from_s);
}
std::complex<double> rate_of(const std::vector<double>& samples, const Partial& partial, double until_s) {
  return rate_of(samples, partial.hertz(), 0.5, until_s);
}

/// A force that is held for a frame is half a frame late.
constexpr double kHold = 0.5 / 48000;

}  // namespace

TEST_CASE("active string: one mass takes a mass, a damper and a spring that are not there", "[instruments]") {
  const double m = 1e-3, w0 = 2 * kPi * 110, k = m * w0 * w0, r = 4e-3;
  struct Added {
    double mass, damping, stiffness;
  };
  for (const auto& [mass, damping, stiffness] : {Added{0, 0, 0}, Added{0.02e-3, 0, 0}, Added{0, 8e-3, 0},
                                                 Added{0, 0, 50}, Added{-0.02e-3, 4e-3, 50}}) {
    const auto place = play("active_string/one_mass.toml", 1_s,
                            {{"mass", mass}, {"damping", damping}, {"stiffness", stiffness}});
    // Late by t, a spring K takes K t of damping, and a mass M gives M w^2 t. The acceleration is a
    // difference, which is half a frame late itself.
    const double w = std::sqrt((k + stiffness) / (m + mass));
    const double sigma = (r + damping + mass * w * w * 2 * kHold - stiffness * kHold) / (2 * (m + mass));
    const double hertz = std::sqrt(w * w - sigma * sigma) / (2 * kPi);
    const auto off = rate_of(place, hertz, 0.2, 0.7);
    CHECK(off.imag() == Approx(0).margin(5e-4 * 2 * kPi * hertz));
    CHECK(off.real() == Approx(-sigma).epsilon(0.01).margin(0));
  }
}

TEST_CASE("active string: partials move as the shape of the string at the coil says", "[instruments]") {
  const auto alone = play("monochord/plucked.toml", 2_s, {{"damping", 0.0}});
  const auto damped = play("monochord/plucked.toml", 2_s, {{"damping", 0.01}});
  const auto stiffened = play("monochord/plucked.toml", 2_s, {{"damping", 0.0}, {"stiffness", 40.0}});
  const auto loaded = play("monochord/plucked.toml", 2_s, {{"damping", 0.0}, {"mass", 0.02e-3}});
  for (const int n : {1, 2, 3, 4}) {
    const Partial partial{n};
    const double share = partial.felt() / kStringMass;
    const auto before = rate_of(alone, partial, 1.5);
    CAPTURE(n);
    CHECK(before.real() == Approx(-partial.sigma()).epsilon(0.01).margin(0));
    CHECK(before.imag() == Approx(0).margin(1e-4 * partial.omega()));
    CHECK((rate_of(damped, partial, 1.5) - before).real() == Approx(-0.01 * share).epsilon(0.02).margin(0));
    CHECK((rate_of(stiffened, partial, 0.55) - rate_of(alone, partial, 0.55)).imag() ==
          Approx(40 * share / partial.omega()).epsilon(0.02).margin(0));
    CHECK((rate_of(loaded, partial, 0.55) - rate_of(alone, partial, 0.55)).imag() ==
          Approx(-0.02e-3 * share * partial.omega()).epsilon(0.02).margin(0));
  }
}

TEST_CASE("active string: a late damper feeds the partials that it meets upside down", "[instruments]") {
  for (const double delay_s : {0.001, 0.0015, 0.0045, 0.02}) {
    Partial first{1};
    double border = 1e9;
    for (int n = 1; n < 50; ++n) {
      const Partial partial{n};
      const double turned = partial.felt() * std::cos(partial.omega() * (delay_s + kHold)) / kStringMass;
      if (turned < 0 && -partial.sigma() / turned < border) {
        border = -partial.sigma() / turned;
        first = partial;
      }
    }
    CAPTURE(delay_s, first.n, border);
    const auto growth = [&](double damping) {
      return rate_of(
                 play("monochord/plucked.toml", 4_s, {{"damping", damping}}, "plant.place", Seconds{delay_s}),
                 first, 3.5)
          .real();
    };
    CHECK(growth(0.98 * border) < 0);
    CHECK(growth(1.02 * border) > 0);
  }
}

TEST_CASE("active string: the oscillator settles where it gives what the string loses", "[instruments]") {
  const auto place = play("active_string/scene.toml", 5_s, {});
  const Partial tone{1};
  // S (1 - V^2 / L^2) s^2 / (mu L) = sigma.
  const double speed = 0.3 * std::sqrt(1 - tone.sigma() * kStringMass / (0.2 * tone.felt()));
  const double swing = std::abs(partial_at(place, tone.hertz(), 4.8)) * tone.omega();
  CHECK(swing == Approx(speed).epsilon(0.01));
}

TEST_CASE("monochord: bowed it sticks and slips at the pitch of the string", "[instruments]") {
  const auto slip = play("monochord/bowed.toml", 3_s, {}, "plant.slip");
  const auto string = play("monochord/bowed.toml", 3_s, {}, "plant.string");
  const auto holding = static_cast<double>(std::count(slip.begin() + 96000, slip.begin() + 144000, 0.0));
  // It slips for beta = 1/10 of the time in Helmholtz's motion, and a little longer round his corner.
  CHECK(holding / 48000 == Approx(0.85).epsilon(0).margin(0.05));
  const auto alike = [&](int lag) {
    double sum = 0;
    for (std::size_t n = 96000; n < 120000; ++n) sum += string[n] * string[n + static_cast<std::size_t>(lag)];
    return sum;
  };
  int best = 380;
  for (int lag = 380; lag < 500; ++lag)
    if (alike(lag) > alike(best)) best = lag;
  // One frame is 4 cents; a heavy bow flattens by some.
  CHECK(48000.0 / best == Approx(Partial{1}.hertz()).epsilon(0.006));
  CHECK(alike(best) > 0.95 * alike(0));
}
