#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "backends/backend.h"

namespace tactus::test {

/// A backend for the conformance suite, what it stands on, and a request that it must grant.
struct Subject {
  std::vector<std::shared_ptr<void>> stands_on;  ///< gone after the backend, the last one first
  std::unique_ptr<Backend> backend;
  StreamRequest request;  ///< two inputs, one output

  Subject() = default;
  Subject(Subject&&) = default;
  ~Subject() {
    backend.reset();
    while (!stands_on.empty()) stands_on.pop_back();
  }
};

Subject loop_subject();

/// Makes a fresh one; empty: there is none here, and the output says why.
using MakeSubject = std::function<std::optional<Subject>()>;
/// Those that this program of tests has. A new backend is a line in one of them.
std::vector<MakeSubject> every_backend();

}  // namespace tactus::test
