#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "backends/loop/loop.h"
#include "latency/measurement.h"

namespace tactus::test {

/// Simulated cards that do not wait for any clock: the first opening is of the first one, and so on.
class Cards final : public Backend {
 public:
  explicit Cards(std::vector<LoopCard> cards) : cards_(std::move(cards)) {
    loop_.add("loop:test", cards_.front());
  }

  std::string name() const override { return loop_.name(); }
  Result<std::vector<Device>> devices() override { return loop_.devices(); }
  Result<std::unique_ptr<Stream>> open(const StreamRequest& request, GuardedBlocks& processor) override {
    loop_.add("loop:test", cards_[std::min(next_++, cards_.size() - 1)]);
    return loop_.open(request, processor);
  }

 private:
  LoopBackend loop_{LoopBackend::Pace::AsFastAsPossible};
  std::vector<LoopCard> cards_;
  std::size_t next_ = 0;
};

inline MeasureSettings on_a_wire(int openings = 1) {
  MeasureSettings settings;
  settings.request.device = "loop:test";
  settings.request.block_frames = 64;
  settings.guard = {DriveGuard::Kind::Audio, {}};
  settings.openings = openings;
  return settings;
}

inline Measurement measured(const std::vector<LoopCard>& cards,
                            const MeasureSettings& settings = on_a_wire()) {
  Cards backend{cards};
  auto measurement = measure(backend, settings);
  REQUIRE(measurement);
  return std::move(*measurement);
}

inline LoopCard named(const std::string& text) {
  const auto card = loop_card(text);
  REQUIRE(card);
  return *card;
}

inline double loudest(const std::vector<double>& samples) {
  double most = 0.0;
  for (const double sample : samples) most = std::max(most, std::abs(sample));
  return most;
}

/// What it says, and that it says what to do.
inline void expect(const Measurement& measurement, Verdict verdict) {
  INFO(measurement.finding.what);
  CHECK(code(measurement.finding.verdict) == std::string{code(verdict)});
  CHECK(measurement.finding.what.size() > 20);
  CHECK(measurement.finding.remedy.size() > 20);
}

}  // namespace tactus::test
