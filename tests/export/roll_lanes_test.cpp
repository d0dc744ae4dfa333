#include "export/roll_lanes.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>

using namespace tactus;

namespace {

constexpr int kLanes = 8;

/// What is left of a statement for each lane, the last lane first; "$" is the number of the lane.
std::string rolled(const std::string& statement) {
  CProgram program;
  for (int lane = kLanes - 1; lane >= 0; --lane) {
    program.members.push_back({fmt::format("tactus_real m_{}", lane), {}, sizeof(double)});
    auto text = statement;
    for (auto at = text.find('$'); at != std::string::npos; at = text.find('$'))
      text.replace(at, 1, std::to_string(lane));
    program.frame.push_back({text});
  }
  roll_lanes(program);
  REQUIRE(program.frame.size() == 1);
  CHECK(program.frame[0].lanes == kLanes);
  return program.frame[0].text;
}

}  // namespace

TEST_CASE("roll lanes: lanes that come in falling order run in rising order", "[export]") {
  CHECK(rolled("s->m_$ = in[$];") == "s->m[lane] = in[lane];");
}

TEST_CASE("roll lanes: what they have in common is used in the order that it was written in", "[export]") {
  CHECK(rolled("s->m_$ = tactus_next(&s->noise, $);") == "s->m[lane] = tactus_next(&s->noise, 7 - lane);");
}
