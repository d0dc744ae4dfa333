#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/watched_stream.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

// Cards without 32-bit float: another program has the other end of the cable open in 16 bit, so that this end
// has no other format either.

using namespace tactus;
using test::alsa_ways;
using test::CableCard;
using test::GuardedProbe;
using test::kSlowMachine;
using test::NoiseProbe;
using test::OtherProgram;

namespace {

constexpr double kStep = 1.0 / 32768;
/// The libraries scale by 32767 to 32768 and round, half a step each.
constexpr double kTolerance = 1.5 * kStep;
constexpr int kCompared = 2000;  // [frames]

using Stereo = std::vector<std::int16_t>;

Stereo read_raw(const std::string& file) {
  std::ifstream in{file, std::ios::binary};
  const std::string bytes{std::istreambuf_iterator<char>{in}, {}};
  Stereo samples(bytes.size() / 2);
  std::memcpy(samples.data(), bytes.data(), 2 * samples.size());
  return samples;
}

/// True: somewhere in `heard` are the first frames of the noise, within the tolerance.
bool has_noise(const std::vector<double>& heard) {
  for (std::size_t at = 0; at + kCompared <= heard.size(); ++at) {
    int n = 0;
    while (n < kCompared &&
           std::abs(heard[at + static_cast<std::size_t>(n)] - NoiseProbe::noise(0, n)) <= kTolerance)
      ++n;
    if (n == kCompared) return true;
  }
  return false;
}

std::vector<double> first_channel(const Stereo& samples) {
  std::vector<double> heard;
  for (std::size_t n = 0; n + 1 < samples.size(); n += 2) heard.push_back(samples[n] * kStep);
  return heard;
}

/// One side of the card alone.
StreamRequest one_way(Backend& backend, const CableCard& card, int inputs, int outputs) {
  const auto device = card.output_of(backend);
  REQUIRE(device);
  StreamRequest request;
  request.device = device->id;
  request.sample_rate = 48_kHz;
  request.block_frames = 2048;
  request.in_channels = inputs;
  request.out_channels = outputs;
  return request;
}

}  // namespace

TEST_CASE("alsa: a card of 16 bit plays what it is given, rounded, and silence as zeros", "[.alsa]") {
  const CableCard card;
  const test::TemporaryFolder folder;
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    const auto file = (folder.path() / "recorded.raw").string();
    auto other = OtherProgram::records(card, 1, file);
    const auto backend = way.backend();
    GuardedProbe probe{1};
    auto stream = backend->open(one_way(*backend, card, 0, 1), probe.guarded);
    if (!stream) FAIL(to_string(stream.error()));
    probe.guarded.skip_soft_start();
    REQUIRE((*stream)->start());
    REQUIRE(test::wait_until([&] { return probe.probe.frames() > 48000; }, kSlowMachine));
    CHECK((*stream)->stop());
    other.end();
    const auto samples = read_raw(file);
    CHECK(has_noise(first_channel(samples)));
    // The second channel plays nothing.
    for (std::size_t n = 1; n < samples.size(); n += 2) REQUIRE(samples[n] == 0);
  }
}

TEST_CASE("alsa: what a card of 16 bit records is exact to a step", "[.alsa]") {
  const CableCard card;
  const test::TemporaryFolder folder;
  const auto file = (folder.path() / "played.raw").string();
  Stereo played;
  for (int turn = 0; turn < 60; ++turn)  // the noise, again and again: whenever the recording begins
    for (int n = 0; n < 48000; ++n)
      for (int channel = 0; channel < 2; ++channel)
        played.push_back(static_cast<std::int16_t>(std::lround(NoiseProbe::noise(0, n) * 32768)));
  std::ofstream{file, std::ios::binary}.write(reinterpret_cast<const char*>(played.data()),
                                              std::ssize(played) * 2);
  for (const auto& way : alsa_ways()) {
    CAPTURE(way.name);
    auto other = OtherProgram::plays(card, 1, file);
    const auto backend = way.backend();
    GuardedProbe probe{0, 100000};
    auto stream = backend->open(one_way(*backend, card, 1, 0), probe.guarded);
    if (!stream) FAIL(to_string(stream.error()));
    REQUIRE((*stream)->start());
    REQUIRE(test::wait_until([&] { return probe.probe.full(); }, kSlowMachine));
    CHECK((*stream)->stop());
    CHECK(has_noise(probe.probe.heard(0)));
    other.end();
  }
}
