#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "backends/backend.h"
#include "engine/runtime/player.h"

namespace tactus::test {

/// A backend for the conformance suite, what it stands on, and a request that it must grant.
struct Subject {
  static constexpr int kFrames = 500;  ///< that a run has, where it comes to an end by itself

  std::vector<std::shared_ptr<void>> stands_on;  ///< gone after the backend, the last one first
  std::unique_ptr<Backend> backend;
  StreamRequest request;  ///< two inputs, one output
  std::shared_ptr<std::vector<double>> heard =
      {};             ///< by what the first output moves, where that can be known
  bool live = false;  ///< runs by a clock until it is stopped

  Subject() = default;
  Subject(Subject&&) = default;
  ~Subject() {
    backend.reset();
    while (!stands_on.empty()) stands_on.pop_back();
  }
};

Subject offline_subject();
Subject simulated_subject();
Subject loop_subject();

/// Makes a fresh one; empty: there is none here, and the output says why.
using MakeSubject = std::function<std::optional<Subject>()>;
/// Those that this program of tests has. A new backend is a line in one of them.
std::vector<MakeSubject> every_backend();

}  // namespace tactus::test
