// The backend for data acquisition cards on a driver of a real kernel, comedi_test: its input c reads what
// its output c has now. In the virtual machine: scripts/test_cards.
#include <comedilib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <complex>
#include <csignal>
#include <numbers>
#include <vector>

#include "backends/acquisition_backends.h"
#include "backends/comedi/converter_range.h"
#include "backends/described_devices.h"
#include "backends/paced/paced_stream.h"
#include "engine/core/named.h"
#include "tests/support/child_process.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/wait_until.h"

using namespace tactus;
using namespace std::chrono_literals;

namespace {

const std::string kFile = "/dev/comedi0";
const std::string kDevice = "comedi:" + kFile;
constexpr double kStep = 2.0 / 65535;  // of full scale, in the range of -10 to 10 V
constexpr auto kPatience = 120s;       // the machine is slow

std::unique_ptr<Backend> comedi() { return find_named(acquisition_backends(), "comedi")->make(); }

/// The card as another program has it.
class Witness {
 public:
  Witness() : card_(comedi_open(kFile.c_str())) { REQUIRE(card_ != nullptr); }
  ~Witness() { comedi_close(card_); }
  /// What output `channel` has now.
  unsigned value(unsigned channel = 0) const {
    lsampl_t value = 0;
    REQUIRE(comedi_data_read(card_, 0, channel, 0, AREF_GROUND, &value) == 1);
    return value;
  }
  bool reaches(unsigned value, unsigned channel = 0) const {
    return test::wait_until([&] { return this->value(channel) == value; }, kPatience);
  }
  /// False: it was refused.
  bool write(unsigned channel, unsigned value) const {
    return comedi_data_write(card_, 1, channel, 0, AREF_GROUND, value) == 1;
  }

 private:
  comedi_t* card_;
};

const ConverterRange kRange{-10.0, 10.0, 65535};
const unsigned kZero = kRange.raw(0.0);  // 0 V is between two steps

unsigned raw(double share) { return kRange.raw(share); }

/// All outputs have one level.
class Level final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat& format) override {
    outputs_ = format.out_channels;
    return {};
  }
  void process(const BlockIo& io) noexcept override {
    for (int c = 0; c < outputs_; ++c) io.out[c][0] = level;
  }
  std::atomic<double> level{0.0};

 private:
  int outputs_ = 0;
};

/// u = g (r - x), the input in the frame after the output.
class ClosedLoop final : public BlockProcessor {
 public:
  static constexpr double kGain = 0.5;
  static constexpr int kCycle = 20;

  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    const double x = io.in[0][0];
    const int n = frame;
    if (n < static_cast<int>(inputs.size())) inputs[index(n)] = x;
    io.out[0][0] = kGain * (0.8 * std::cos(2 * std::numbers::pi * n / kCycle) - x);
    ++frame;
  }
  std::atomic<int> frame{0};
  std::vector<double> inputs = std::vector<double>(4000);
};

/// Each frame has another value: all 16 bits in turn. What comes in is that of the frame before.
class Staircase final : public BlockProcessor {
 public:
  Status prepare(const StreamFormat&) override { return {}; }
  void process(const BlockIo& io) noexcept override {
    largest = std::max(largest, std::abs(io.in[0][0] - before_));
    before_ = -1.0 + (frames % 4096) * (2.0 / 4095);
    io.out[0][0] = before_;
    ++frames;
  }
  std::atomic<int> frames{0};
  double largest = 0.0;  ///< error, since the second frame

 private:
  double before_ = 0.0;
};

std::vector<GuardedChannel> open_guards(std::size_t channels) {
  return std::vector<GuardedChannel>(channels, {DriveGuard::Kind::Audio, {.ceiling = 1.0}, {false, false}});
}

StreamRequest request(int inputs, int outputs, double rate_hz = 1000) {
  StreamRequest request;
  request.device = kDevice;
  request.in_channels = inputs;
  request.out_channels = outputs;
  request.sample_rate = Hertz{rate_hz};
  return request;
}

/// Another process, which plays 0.5 at its outputs until it is killed.
pid_t play_in_process(int outputs) {
  const pid_t program = fork();
  if (program != 0) return program;
  Level level;
  level.level = 0.5;
  Guarded guarded{level, open_guards(outputs)};
  auto backend = comedi();
  const auto stream = backend->open(request(0, outputs), guarded);
  if (!stream || !(*stream)->start()) _exit(1);
  while (true) pause();
}

}  // namespace

TEST_CASE("comedi: the card is listed with its channels, ranges and rates", "[.alsa]") {
  const auto backend = comedi();
  const auto devices = backend->devices();
  REQUIRE(devices);
  REQUIRE(devices->size() == 1);
  const auto& card = devices->front();
  CHECK(card.id == kDevice);
  CHECK(card.name.find("comedi:0") != std::string::npos);
  CHECK(card.in_channels == 8);
  CHECK(card.out_channels == 8);
  CHECK(card.in_names[0] == "input 0 (-10 to 10 V)");
  CHECK(card.block_frames == 1);
  CHECK(card.sample_rates.front() == Hertz{1000});
  CHECK(card.sample_rates.back() == Hertz{20'000});
  CHECK_FALSE(card.is_default);

  auto* described = dynamic_cast<DescribedDevices*>(backend.get());
  REQUIRE(described->add(kDevice + ",in_range=1"));
  const auto more = backend->devices();
  REQUIRE(more->size() == 2);
  CHECK(more->back().in_names[0] == "input 0 (-5 to 5 V)");
  CHECK(more->back().out_names[0] == "output 0 (-10 to 10 V)");
  const auto wrong = described->add(kDevice + ",out_range=2");
  REQUIRE_FALSE(wrong);
  CHECK(wrong.error().code == Errc::OutOfRange);
  CHECK(wrong.error().remedy == "choose 0 to 1: 0 is -10 to 10 V, 1 is -5 to 5 V");
}

TEST_CASE("comedi: each input is what the output had one frame before, within half a step", "[.alsa]") {
  Staircase staircase;
  Guarded guarded{staircase, open_guards(1)};
  const auto stream = comedi()->open(request(1, 1, GENERATE(1e3, 3e3)), guarded);
  REQUIRE(stream);
  CHECK((*stream)->granted().output.ports ==
        std::vector<std::string>{"output 0 (-10 to 10 V) in 65536 steps"});
  REQUIRE((*stream)->start());
  REQUIRE(test::wait_until([&] { return staircase.frames > 5000; }, kPatience));
  REQUIRE((*stream)->stop());
  // The first input is 0 V, which is half a step away too.
  CHECK(staircase.largest <= 0.5 * kStep + 1e-7);
  CHECK(Witness{}.value() == kZero);
}

TEST_CASE("comedi: channel maps choose the channels of the card, and no other one is written", "[.alsa]") {
  const Witness witness;
  REQUIRE(witness.write(0, 1000));
  REQUIRE(witness.write(3, 1000));
  Level level;
  level.level = 0.5;
  Guarded guarded{level, open_guards(1)};
  auto wanted = request(0, 1);
  wanted.out_map = {3};
  const auto stream = comedi()->open(wanted, guarded);
  REQUIRE(stream);
  CHECK(witness.value(3) == kZero);  // as soon as it is open
  REQUIRE((*stream)->start());
  CHECK(witness.reaches(raw(0.5), 3));
  CHECK(witness.value(0) == 1000);
  REQUIRE((*stream)->stop());
  CHECK(witness.value(3) == kZero);
  CHECK(witness.value(0) == 1000);
}

TEST_CASE("comedi: no other program writes to outputs that are played", "[.alsa]") {
  const Witness witness;
  Level level;
  level.level = 0.25;
  Guarded guarded{level, open_guards(1)}, second{level, open_guards(1)};
  const auto stream = comedi()->open(request(0, 1), guarded);
  REQUIRE(stream);
  CHECK_FALSE(witness.write(0, 65535));
  CHECK_FALSE(witness.write(5, 65535));
  const auto again = comedi()->open(request(0, 1), second);
  REQUIRE_FALSE(again);
  CHECK(again.error().code == Errc::Device);
  CHECK(again.error().what.find("in use") != std::string::npos);
}

// u[n] = g (r[n] - u[n-D]): with H = X / R of the closed loop and L = H / (1 - H) = g exp(-j w D), D =
// -arg(L) / w.
TEST_CASE("comedi: the phase of the closed loop shows a delay of one frame", "[.alsa]") {
  ClosedLoop loop;
  Guarded guarded{loop, open_guards(1)};
  const auto stream = comedi()->open(request(1, 1), guarded);
  REQUIRE(stream);
  REQUIRE((*stream)->start());
  const auto frames = static_cast<int>(loop.inputs.size());
  REQUIRE(test::wait_until([&] { return loop.frame >= frames; }, kPatience));
  REQUIRE((*stream)->stop());
  using Complex = std::complex<double>;
  const double w = 2 * std::numbers::pi / ClosedLoop::kCycle;
  Complex input = 0.0;
  for (int n = frames / 2; n < frames; ++n) input += loop.inputs[index(n)] * std::polar(4.0 / frames, -w * n);
  const Complex closed = input / 0.8, open = closed / (1.0 - closed);
  // A step is 3e-5 of full scale, and its noise is averaged over 2000 frames.
  CHECK(std::abs(open) == Approx(ClosedLoop::kGain).margin(1e-4));
  CHECK(-std::arg(open) / w == Approx(1.0).margin(1e-3));
}

TEST_CASE("comedi: a program that is killed leaves its outputs at zero", "[.alsa]") {
  const Witness witness;
  const pid_t program = play_in_process(2);
  CHECK(witness.reaches(raw(0.5), 0));
  CHECK(witness.reaches(raw(0.5), 1));
  REQUIRE(kill(program, SIGKILL) == 0);
  REQUIRE(waitpid(program, nullptr, 0) == program);
  CHECK(witness.reaches(kZero, 0));
  CHECK(witness.reaches(kZero, 1));
  CHECK(test::wait_until([&] { return witness.write(0, 1000); }, kPatience));  // the watchdog has ended
  CHECK(witness.value(0) == 1000);
}

TEST_CASE("comedi: a program that is stopped has its outputs at zero, and plays on when it continues",
          "[.alsa]") {
  const Witness witness;
  const pid_t program = play_in_process(1);
  REQUIRE(witness.reaches(raw(0.5)));
  REQUIRE(kill(program, SIGSTOP) == 0);
  CHECK(witness.reaches(kZero));
  REQUIRE(kill(program, SIGCONT) == 0);
  CHECK(witness.reaches(raw(0.5)));
  REQUIRE(kill(program, SIGKILL) == 0);
  REQUIRE(waitpid(program, nullptr, 0) == program);
  CHECK(witness.reaches(kZero));
}

TEST_CASE("comedi: an instrument plays on the card, and leaves zero when it is killed", "[.alsa]") {
  const Witness witness;
  const test::TemporaryFolder folder;
  const auto file = folder.write("level.toml", R"(format = 1
[inputs]
position = { unit = "full scale" }
[controls]
level = { value = 0.2, range = [0, 1] }
[outputs]
motor = { from = "level + 0 * position" }
)");
  test::ChildProcess play{
      {TACTUS_PROGRAM, "play", file.string(), "--device", "comedi:0", "--rate", "1 kHz", "--arm"}};
  // Drives of an unknown actuator have a lower ceiling than 0.2.
  CHECK(test::wait_until([&] { return witness.value() > kZero + 100; }, kPatience));
  INFO(play.log());
  play.kill();
  CHECK(witness.reaches(kZero));
}
