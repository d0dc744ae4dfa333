// What a real card plays when the program itself cannot run any more.
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <fstream>

#include "tests/cards/alsa/cable_card.h"
#include "tests/cards/jack/playing.h"

using namespace tactus;
using test::alsa_ways;
using test::CableCard;
using test::kSlowMachine;
using test::OtherProgram;
using test::Playing;
using test::wait_until;

namespace {

constexpr std::uintmax_t kFrameBytes = 4, kSecond = 48000 * kFrameBytes;

const std::string kTone = R"(format = 1
name = "tone"
[nodes]
wave = { type = "sine", frequency = "100 Hz" }
[outputs]
drive = { from = "0.2 * wave" }
)";

/// What another program hears at the other end of the cable, in 16 bit.
struct Listener {
  explicit Listener(const CableCard& card) : other(OtherProgram::records(card, 1, file.string())) {}
  ~Listener() { other.end(); }

  std::uintmax_t bytes() const { return std::filesystem::file_size(file) / kFrameBytes * kFrameBytes; }
  /// The highest sample of the last second.
  int highest() const {
    const auto end = bytes();
    std::ifstream raw{file, std::ios::binary};
    raw.seekg(static_cast<std::streamoff>(end - std::min(end, kSecond)));
    std::vector<std::int16_t> samples(std::min(end, kSecond) / 2);
    raw.read(reinterpret_cast<char*>(samples.data()), std::ssize(samples) * 2);
    int most = 0;
    for (const int sample : samples) most = std::max(most, std::abs(sample));
    return most;
  }
  bool plays() const {
    return wait_until([this] { return bytes() > kSecond && highest() > 6000; }, kSlowMachine);
  }
  /// The highest sample of a second, when what was on its way in a buffer is over.
  int highest_later() const {
    const auto end = bytes() + 3 * kSecond;
    REQUIRE(wait_until([&] { return bytes() >= end; }, kSlowMachine));
    return highest();
  }

  test::TemporaryFolder folder;
  std::filesystem::path file = folder.path() / "heard.raw";
  OtherProgram other;
};

}  // namespace

TEST_CASE("alsa: a program that is killed, aborts, faults or is stopped leaves zeros behind", "[.alsa]") {
  const CableCard card;
  const test::TemporaryFolder folder;
  const auto tone = folder.write("tone.toml", kTone).string();
  for (const auto& way : alsa_ways())
    for (const int signal : {SIGKILL, SIGABRT, SIGSEGV, SIGSTOP}) DYNAMIC_SECTION(way.name << " " << signal) {
        const Listener listener{card};
        const auto device = card.output_of(*way.backend());
        REQUIRE(device);
        Playing play{{tone, "--device", device->id, "--block", "2048", "--arm"}};
        REQUIRE(listener.plays());
        play.process().send(signal);
        CHECK(listener.highest_later() == 0);
        if (signal == SIGSTOP) {
          play.process().send(SIGCONT);
          CHECK(listener.plays());
          play.press("q");
          CHECK(play.ends() == 0);
        } else {
          CHECK(play.ends() == -signal);
        }
      }
}
