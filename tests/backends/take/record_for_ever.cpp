// Records noise as a sound card would bring it until it is killed, and says on standard output how many
// frames went by, eight bytes after every block.
//   record_for_ever take.wav
#include <chrono>
#include <cstdio>
#include <iostream>
#include <random>
#include <thread>

#include "backends/take/take_recorder.h"

int main(int, char** arguments) {
  using namespace tactus;
  constexpr int kFrames = 64;
  TakeHeader header;
  header.inputs = {"piezo"};
  header.outputs = {"woofer"};
  const auto recorder = TakeRecorder::start(arguments[1], header);
  if (!recorder) return std::cerr << to_string(recorder.error()) << "\n", 1;
  std::vector<double> sensor(kFrames), drive(kFrames);
  const double* in = sensor.data();
  double* out = drive.data();
  std::mt19937 bits{1};
  auto next = std::chrono::steady_clock::now();
  for (std::int64_t frame = 0;; frame += kFrames) {
    for (auto& sample : sensor)
      sample = static_cast<double>(std::uniform_real_distribution<float>{-1.0f, 1.0f}(bits));
    (*recorder)->tap().applied({frame, JournalEntry::Kind::ControlChange, 0, sensor[0]});
    (*recorder)->tap().observe({&in, &out, kFrames}, frame);
    const auto done = frame + kFrames;
    if (std::fwrite(&done, sizeof done, 1, stdout) != 1 || std::fflush(stdout) != 0) return 0;
    std::this_thread::sleep_until(next += std::chrono::nanoseconds{1'000'000'000LL * kFrames / 48000});
  }
}
