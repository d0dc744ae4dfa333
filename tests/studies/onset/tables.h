#pragma once

#include <string>
#include <vector>

#include "tests/studies/onset/score.h"

namespace tactus::study {

/// A hit with what became of it.
struct Outcome {
  TrueHit hit;
  Score score;
};

/// The Markdown that stands in docs/onset_study.md and in the instrument's README.
std::string tables(const std::vector<Outcome>& outcomes);

}  // namespace tactus::study
