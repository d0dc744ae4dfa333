#pragma once

#include <catch2/catch.hpp>
#include <memory>
#include <stdexcept>
#include <utility>

#include "backends/reconnecting_stream.h"
#include "tests/support/noise_probe.h"
#include "tests/support/wait_until.h"

namespace tactus::test {

/// A stream that plays the noise probe and is ticked while the test waits, as an app does it.
struct WatchedStream {
  WatchedStream(std::unique_ptr<Backend> from, const StreamRequest& request, int kept_frames,
                std::chrono::milliseconds longest_wait)
      : backend(std::move(from)), probe(1, kept_frames), patience(longest_wait) {
    auto opened = ReconnectingStream::open(*backend, request, probe.guarded);
    if (!opened) throw std::runtime_error{to_string(opened.error())};
    stream = std::move(*opened);
    probe.guarded.skip_soft_start();
    REQUIRE(stream->start());
    REQUIRE(plays_on());
  }
  template <class Condition>
  bool until(Condition holds) {
    return wait_until(
        [&] {
          stream->tick();
          return holds();
        },
        patience);
  }
  bool until(StreamState state) {
    return until([&] { return stream->state() == state; });
  }
  bool plays_on() {
    const auto before = stream->health().frames;
    return until([&] { return stream->state() == StreamState::Running && stream->health().frames > before; });
  }
  bool comes_back(int returns) {
    return until([&] { return stream->returns() == returns; }) && plays_on();
  }

  std::unique_ptr<Backend> backend;
  GuardedProbe probe;
  std::unique_ptr<ReconnectingStream> stream;
  std::chrono::milliseconds patience;
};

}  // namespace tactus::test
