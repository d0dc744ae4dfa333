#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"
#include "tests/support/allocation_count.h"

// The node contract (engine/graph/node.h), for every type that is registered. Nothing here knows a type by
// name.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 1500;
constexpr unsigned kSeeds = 5;

Outputs whole(NodeRunner& runner) { return runner.run(even_cutting(kFrames, kLongestSubBlock)); }

/// Calls `check(case, runner)` for every case of every type; a node that cannot be made fails there.
template <class Check>
void for_every_case(std::vector<NodeCase> (*cases)(const NodeType&), Check check) {
  for (const auto* type : standard_nodes().types) {
    CHECK(missing_example(*type) == "");
    for (const auto& one : cases(*type)) {
      INFO(one.label);
      auto runner = one.runner();
      CHECK(runner.error() == "");
      if (runner.made()) check(one, runner);
    }
  }
}
template <class Check>
void for_ordinary_cases(Check check) {
  for_every_case([](const NodeType& type) { return ordinary_cases(type, kFrames, kSeeds); }, check);
}

bool has_late_inputs(const NodeType& type) {
  return std::any_of(type.inputs.begin(), type.inputs.end(), [](const auto& port) { return port.late; });
}

/// Feeds the same values to `node` with inputs at rest once as stride 0, once as equal samples.
Outputs run_with_strides(const NodeCase& one, Node& node, bool constants_as_samples) {
  std::vector<Samples> expanded;
  for (const auto& port : one.type->inputs) {
    const auto& value = one.inputs.at(port.name);
    const auto* constant = std::get_if<double>(&value);
    expanded.push_back(constant ? Samples(kLongestSubBlock, *constant) : std::get<Samples>(value));
  }
  Outputs outputs(one.type->outputs.size(), Samples(kFrames));
  node.reset();
  for (int from = 0; from < kFrames;) {
    const int frames = std::min(kLongestSubBlock, kFrames - from);
    std::vector<Signal> in;
    std::vector<double*> out;
    for (std::size_t i = 0; i < expanded.size(); ++i) {
      const bool rests = std::holds_alternative<double>(one.inputs.at(one.type->inputs[i].name));
      in.push_back(!rests                 ? Signal{expanded[i].data() + from, 1}
                   : constants_as_samples ? Signal{expanded[i].data(), 1}
                                          : Signal{expanded[i].data(), 0});
    }
    for (auto& output : outputs) out.push_back(output.data() + from);
    node.process({in.data(), out.data(), frames, from});
    from += frames;
  }
  return outputs;
}

/// Allocations inside the node's real-time functions while it runs `one` from a reset on.
std::int64_t allocations(const NodeCase& one, Node& node, bool halves) {
  Outputs outputs(one.type->outputs.size(), Samples(kLongestSubBlock));
  std::vector<double*> out;
  for (auto& output : outputs) out.push_back(output.data());
  std::vector<Signal> in(one.type->inputs.size());
  const auto before = allocation_count();
  node.reset();
  for (int from = 0; from < kFrames;) {
    const int frames = halves ? 1 : std::min(from % kLongestSubBlock + 1, kFrames - from);
    for (std::size_t i = 0; i < in.size(); ++i) {
      const auto& value = one.inputs.at(one.type->inputs[i].name);
      const auto* constant = std::get_if<double>(&value);
      in[i] = constant ? Signal{constant, 0} : Signal{std::get<Samples>(value).data() + from, 1};
    }
    const NodeBlock block{in.data(), out.data(), frames, from};
    if (halves) {
      node.emit(block);
      node.absorb(block);
    } else {
      node.process(block);
    }
    from += frames;
  }
  return allocation_count() - before;
}

std::string first_not_finite(const NodeType& type, const Outputs& outputs) {
  for (std::size_t o = 0; o < outputs.size(); ++o)
    for (std::size_t n = 0; n < outputs[o].size(); ++n)
      if (!std::isfinite(outputs[o][n])) return type.outputs[o].name + " at frame " + std::to_string(n);
  return {};
}

}  // namespace

TEST_CASE("nodes: the cut into blocks changes no bit", "[conformance]") {
  for_ordinary_cases([](const NodeCase&, NodeRunner& runner) {
    const auto reference = whole(runner);
    CHECK(first_difference(reference, runner.run(even_cutting(kFrames, 1))) == "");
    CHECK(first_difference(reference, runner.run(even_cutting(kFrames, 7))) == "");
    CHECK(runner.cutting_matters(kFrames, 2) == "");
  });
}

TEST_CASE("nodes: the cut changes no bit when the engine has run for hours", "[conformance]") {
  for_ordinary_cases([](const NodeCase&, NodeRunner& runner) {
    CHECK(runner.cutting_matters(kFrames, 2, (std::int64_t{1} << 33) + 12345) == "");
  });
}

TEST_CASE("nodes: the number of the first frame changes no bit, also before 2^31, 2^32 and 2^53",
          "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    if (one.type->random) return;  // a function of the frame
    const auto blocks = even_cutting(kFrames, kLongestSubBlock);
    const auto from_zero = runner.run(blocks);
    for (const int power : {31, 32, 53})
      CHECK(first_difference(from_zero, runner.run(blocks, (std::int64_t{1} << power) - 640)) == "");
  });
}

// A control that comes to rest turns from samples into a constant at the edge of a block, so this is a matter
// of cuts too.
TEST_CASE("nodes: an input at rest gives the same bits as a constant and as samples", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    CHECK(first_difference(run_with_strides(one, runner.node(), false),
                           run_with_strides(one, runner.node(), true)) == "");
  });
}

TEST_CASE("nodes: no memory is allocated in process, emit, absorb and reset", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    CHECK(allocations(one, runner.node(), false) == 0);
    if (has_late_inputs(*one.type)) CHECK(allocations(one, runner.node(), true) == 0);
  });
}

TEST_CASE("nodes: reset repeats the output bit for bit", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    const auto fresh = whole(runner);
    CHECK(first_difference(fresh, whole(runner)) == "");
    runner.run(even_cutting(kFrames / 3, 17));
    CHECK(first_difference(fresh, whole(runner)) == "");
    auto another = one.runner();
    CHECK(first_difference(fresh, whole(another)) == "");
  });
}

TEST_CASE("nodes: finite in, finite out", "[conformance]") {
  const auto check = [](const NodeCase& one, NodeRunner& runner) {
    CHECK(first_not_finite(*one.type, whole(runner)) == "");
  };
  for_ordinary_cases(check);
  for_every_case([](const NodeType& type) { return extreme_cases(type, kFrames); }, check);
}

TEST_CASE("nodes: outputs stay in the range that is declared", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    const auto outputs = whole(runner);
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      const auto range =
          one.type->range ? one.type->range(static_cast<int>(o), one.setup()) : one.type->outputs[o].range;
      const auto [least, most] = std::minmax_element(outputs[o].begin(), outputs[o].end());
      const double rounding = 1e-12 * std::max(std::abs(*least), std::abs(*most));
      CHECK(*least >= range.low - rounding);
      CHECK(*most <= range.high + rounding);
    }
  });
}

TEST_CASE("nodes: a change at an input reaches an output after its declared delay, not before",
          "[conformance]") {
  constexpr int kChange = 777;
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    const auto reference = whole(runner);
    for (std::size_t i = 0; i < one.type->inputs.size(); ++i) {
      const auto& port = one.type->inputs[i];
      auto* samples = std::get_if<Samples>(&one.inputs.at(port.name));
      if (samples == nullptr) continue;
      auto changed = one;
      const auto range = typical_range(port);
      const auto other = noise(kFrames, 99, range.low, range.high);
      std::copy(other.begin() + kChange, other.end(),
                std::get<Samples>(changed.inputs[port.name]).begin() + kChange);
      auto changed_runner = changed.runner();
      const auto outputs = whole(changed_runner);
      for (std::size_t o = 0; o < outputs.size(); ++o) {
        const int least = runner.node().delay(static_cast<int>(i), static_cast<int>(o)).least;
        INFO(port.name << " to " << one.type->outputs[o].name << ", at least " << least << " frames");
        CHECK(least >= 0);
        const auto end = std::min(kFrames, kChange + least);
        CHECK(std::equal(outputs[o].begin(), outputs[o].begin() + end, reference[o].begin()));
      }
    }
  });
}

TEST_CASE("nodes: emit and absorb give the bits of process", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    if (!has_late_inputs(*one.type)) return;
    int least = kLongestSubBlock;
    for (std::size_t i = 0; i < one.type->inputs.size(); ++i)
      for (std::size_t o = 0; one.type->inputs[i].late && o < one.type->outputs.size(); ++o)
        least = std::min(least, runner.node().delay(static_cast<int>(i), static_cast<int>(o)).least);
    CHECK(least >= 1);  // else it could not be on a loop
    if (least < 1) return;
    const auto reference = whole(runner);
    CHECK(first_difference(reference, runner.run_halves(even_cutting(kFrames, 1))) == "");
    CHECK(first_difference(reference, runner.run_halves(even_cutting(kFrames, least))) == "");
    CHECK(first_difference(reference, runner.run_halves(random_cutting(kFrames, 3, least))) == "");
  });
}

TEST_CASE("nodes: one without memory answers the same values with the same value", "[conformance]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    if (!one.type->stateless) return;
    const auto forward = whole(runner);
    auto backward_case = one;
    for (auto& [name, value] : backward_case.inputs)
      if (auto* samples = std::get_if<Samples>(&value)) std::reverse(samples->begin(), samples->end());
    auto backward_runner = backward_case.runner();
    auto backward = backward_runner.run(even_cutting(kFrames, 13), 4711);
    for (auto& output : backward) std::reverse(output.begin(), output.end());
    CHECK(first_difference(forward, backward) == "");
  });
}

TEST_CASE("node contract: outputs are 0 while an input that is said to silence them has always been 0",
          "[nodes]") {
  for (const auto* type : standard_nodes().types) {
    for (const auto& [input, output] : type->silencers) {
      INFO(type->name << "." << input);
      REQUIRE(type->input_index(input) >= 0);
      for (auto one : ordinary_cases(*type, kFrames, kSeeds)) {
        INFO(one.label);
        one.inputs[input] = 0.0;
        auto runner = one.runner();
        REQUIRE(runner.made());
        const auto outputs = whole(runner);
        for (std::size_t o = 0; o < outputs.size(); ++o)
          if (output.empty() || type->outputs[o].name == output)
            CHECK(std::ranges::all_of(outputs[o], [](double x) { return x == 0.0; }));
      }
    }
  }
}

TEST_CASE("node contract: a copy goes on as the node that it was copied from, and does not allocate",
          "[nodes]") {
  for_ordinary_cases([](const NodeCase& one, NodeRunner& runner) {
    const auto blocks = even_cutting(kFrames, kLongestSubBlock);
    const auto expected = runner.run(blocks);
    auto other = one.runner();
    CHECK(first_difference(runner.run_copied(blocks, static_cast<int>(blocks.size()) / 2, other.node()),
                           expected) == "");
    const auto before = allocation_count();
    other.node().copy(runner.node());
    CHECK(allocation_count() == before);
  });
}
