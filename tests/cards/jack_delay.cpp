#include "tests/cards/jack_delay.h"

#include <algorithm>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "tests/support/skip.h"

namespace tactus::test {
namespace {

constexpr int kTries = 5;

/// Of a line like "Inv   1216.250 frames   25.339 ms"; nothing where it hears too little, or doubts itself.
std::optional<double> reading(const std::string& line) {
  const auto unit = line.find(" frames");
  if (unit == std::string::npos || line.find("??") != std::string::npos) return std::nullopt;
  return std::stod(line.substr(line.find_first_of("-0123456789")));
}

}  // namespace

std::unique_ptr<JackDelay> start_jack_delay(SoundServer& server, const std::string& playback,
                                            const std::string& capture) {
  std::unique_ptr<JackDelay> measuring{new JackDelay};
  auto& process = measuring->process_;
  // Its name cannot be chosen, and two clients of one name do not begin at once, on whatever servers.
  for (int turn = 0; turn < kTries; ++turn) {
    process = std::make_unique<ChildProcess>(std::vector<std::string>{"jack_delay"});
    if (process->hear().empty()) continue;
    server.connect("jack_delay:out", playback);
    server.connect(capture, "jack_delay:in");
    return measuring;
  }
  if (process->wait(std::chrono::seconds{1}) != ChildProcess::kCannotRun)
    throw std::runtime_error{"jack_delay does not start; it says:\n" + process->log()};
  skip_part("jack_delay is not installed (Debian: apt-get install jack-delay)");
  return nullptr;
}

JackDelay::~JackDelay() {
  if (process_) process_->terminate();
}

double JackDelay::frames(int readings) {
  std::vector<double> found;
  while (static_cast<int>(found.size()) < readings) {
    const auto line = process_->hear();
    if (line.empty()) throw std::runtime_error{"jack_delay says nothing any more:\n" + process_->log()};
    if (const auto frames = reading(line)) found.push_back(*frames);
  }
  const auto middle = found.begin() + readings / 2;
  std::nth_element(found.begin(), middle, found.end());
  return *middle;
}

}  // namespace tactus::test
