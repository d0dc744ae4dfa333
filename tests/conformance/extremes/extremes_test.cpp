#include <catch2/catch.hpp>

#include "tests/conformance/extremes/expression_case.h"
#include "tests/conformance/extremes/extreme_case.h"
#include "tests/conformance/extremes/field_case.h"

// A part of what scripts/study_extremes runs: the same places, each with a few of its values.

using namespace tactus;
using namespace tactus::test;

namespace {

template <class Case>
void check(const Case& one) {
  const auto [verdict, reason] = judge(one);
  INFO(one.name() << ": " << reason);
  CHECK(verdict != Verdict::Wrong);
}

/// Each subject begins with another value, so that neighbours have different ones.
void check_one_in(int every, const std::vector<ExtremeSubject>& subjects) {
  int number = 0;
  for (const auto& subject : subjects)
    for (const auto& one : extreme_cases(subject, {48e3}))
      if (number++ % every == 0) check(one);
}

template <class Case>
void check_one_in(int every, const std::vector<Case>& cases) {
  for (std::size_t i = 0; i < cases.size(); i += static_cast<std::size_t>(every)) check(cases[i]);
}

}  // namespace

TEST_CASE("extremes: a number of a node is refused with place and remedy, or gives what its equation says",
          "[conformance]") {
  check_one_in(23, node_subjects());
}

TEST_CASE("extremes: so is a number of an element of a network", "[conformance]") {
  check_one_in(139, element_subjects());
}

TEST_CASE("extremes: expressions give the numbers of long double", "[conformance]") {
  check_one_in(7, expression_cases());
}

TEST_CASE("extremes: a number of a scene, graph, rig or profile file is refused or played", "[conformance]") {
  CHECK(missing_sections() == std::vector<std::string>{});
  check_one_in(7, field_cases());
}
