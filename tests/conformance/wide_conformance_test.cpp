#include <catch2/catch.hpp>
#include <cmath>

#include "engine/nodes/table.h"
#include "tests/conformance/node_cases.h"
#include "tests/support/allocation_count.h"

// The wide forms (Node::vectorised in engine/graph/node.h) of every registered type that has one. Nothing
// here knows a type by name.

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr int kFrames = 700;
/// Of the peak. Two poles near 1 sum a rounding of 2^-53 in every frame twice: N²/2 times it after N frames.
constexpr double kRounding = 0.5 * kFrames * kFrames * 0x1p-53;

/// Cases of one type and one choice of settings, each a lane with inputs of its own.
struct Lanes {
  std::vector<NodeCase> cases;
  int shared = -1;  ///< this input is one signal for all lanes

  const NodeType& type() const { return *cases[0].type; }
  const InputValue& value(std::size_t input, std::size_t lane) const {
    const bool own = lane < cases.size() && static_cast<int>(input) != shared;
    return cases[own ? lane : 0].inputs.at(type().inputs[input].name);
  }
};

/// The wide form of a row of nodes, and its inputs as a schedule hands them over.
class WideRunner {
 public:
  explicit WideRunner(const Lanes& lanes) : lanes_(lanes) {
    for (std::size_t lane = 0; lane < lanes.cases.size(); ++lane) {
      auto one = lanes.cases[lane];
      for (std::size_t i = 0; i < lanes.type().inputs.size(); ++i)
        one.inputs[lanes.type().inputs[i].name] = lanes.value(i, lane);
      scalars_.push_back(std::make_unique<NodeRunner>(one.runner()));
    }
    std::vector<const Node*> nodes;
    for (auto& scalar : scalars_) nodes.push_back(&scalar->node());
    nodes.resize(kVectorWidth, nullptr);
    node_ = nodes[0]->vectorised(nodes);
    for (std::size_t i = 0; i < lanes.type().inputs.size(); ++i) inputs_.push_back(laid_out(i));
  }

  bool made() const { return node_ != nullptr; }
  Node& node() { return *node_; }
  Outputs scalar(std::size_t lane) { return scalars_[lane]->run(even_cutting(kFrames, kLongestSubBlock)); }

  /// Interleaved.
  Outputs run(const std::vector<int>& pieces, bool halves = false) {
    Outputs outputs(lanes_.type().outputs.size(), Samples(kFrames * kVectorWidth));
    node_->reset();
    int from = 0;
    for (const int frames : pieces) {
      auto in = signals(from, false);
      auto early = signals(from, halves);
      std::vector<double*> out;
      for (auto& output : outputs) out.push_back(output.data() + from * kVectorWidth);
      if (halves) {
        node_->emit({early.data(), out.data(), frames, from});
        node_->absorb({in.data(), out.data(), frames, from});
      } else {
        node_->process({in.data(), out.data(), frames, from});
      }
      from += frames;
    }
    return outputs;
  }

  static Samples lane_of(const Samples& wide, std::size_t lane) {
    Samples one;
    for (std::size_t n = lane; n < wide.size(); n += kVectorWidth) one.push_back(wide[n]);
    return one;
  }

 private:
  struct Input {
    Samples samples;
    std::ptrdiff_t stride;
  };

  Input laid_out(std::size_t input) const {
    bool rests = true;
    for (std::size_t lane = 0; lane < kVectorWidth; ++lane)
      rests = rests && std::holds_alternative<double>(lanes_.value(input, lane));
    const bool shared = static_cast<int>(input) == lanes_.shared;
    const std::size_t frames = rests ? 1 : kFrames, width = shared && !rests ? 1 : kVectorWidth;
    Input made{{}, rests ? 0 : static_cast<std::ptrdiff_t>(width)};
    for (std::size_t n = 0; n < frames; ++n)
      for (std::size_t lane = 0; lane < width; ++lane) {
        const auto& value = lanes_.value(input, lane);
        const auto* constant = std::get_if<double>(&value);
        made.samples.push_back(constant ? *constant : std::get<Samples>(value)[n]);
      }
    return made;
  }

  std::vector<Signal> signals(int from, bool without_late) const {
    static const Samples unknown(kLongestSubBlock * kVectorWidth, std::numeric_limits<double>::quiet_NaN());
    std::vector<Signal> signals;
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      signals.push_back(
          without_late && lanes_.type().inputs[i].late
              ? Signal{unknown.data(), kVectorWidth}
              : Signal{inputs_[i].samples.data() + from * inputs_[i].stride, inputs_[i].stride});
    return signals;
  }

  Lanes lanes_;
  std::vector<std::unique_ptr<NodeRunner>> scalars_;
  std::unique_ptr<Node> node_;
  std::vector<Input> inputs_;
};

std::string label(const Lanes& lanes) {
  return lanes.cases[0].label + ", " + std::to_string(lanes.cases.size()) + " lanes, shared input " +
         std::to_string(lanes.shared);
}

/// Every type and choice of settings that runs side by side: all lanes and some, each input shared in turn.
template <class Check>
int for_all_lanes(Check check) {
  int types = 0;
  for (const auto* type : standard_nodes().types) {
    bool wide = false;
    for (const auto& settings : setting_variants(*type)) {
      const auto all = ordinary_cases(*type, kFrames, kVectorWidth);
      Lanes lanes;
      for (const auto& one : all)
        if (one.settings == settings.second && lanes.cases.size() < kVectorWidth) lanes.cases.push_back(one);
      for (lanes.shared = -1; lanes.shared < static_cast<int>(type->inputs.size()); ++lanes.shared) {
        WideRunner runner{lanes};
        if (!runner.made()) break;
        wide = true;
        INFO(label(lanes));
        check(lanes, runner);
      }
      lanes.shared = -1;
      lanes.cases.resize(5);
      if (WideRunner few{lanes}; few.made()) check(lanes, few);
    }
    types += wide;
  }
  return types;
}

}  // namespace

TEST_CASE("wide: each lane gives what its node gives, but for rounding", "[conformance]") {
  const int types = for_all_lanes([](const Lanes& lanes, WideRunner& runner) {
    const auto wide = runner.run(even_cutting(kFrames, kLongestSubBlock));
    for (std::size_t lane = 0; lane < lanes.cases.size(); ++lane) {
      const auto alone = runner.scalar(lane);
      for (std::size_t o = 0; o < alone.size(); ++o) {
        const auto together = WideRunner::lane_of(wide[o], lane);
        double peak = 0, off = 0;
        for (std::size_t n = 0; n < together.size(); ++n) {
          peak = std::max(peak, std::abs(alone[o][n]));
          off = std::max(off, std::abs(together[n] - alone[o][n]));
        }
        INFO("lane " << lane << " output " << o << " peak " << peak);
        CHECK(off <= kRounding * peak);
      }
    }
  });
  CHECK(types >= 10);
}

TEST_CASE("wide: the cutting into blocks changes no bit", "[conformance]") {
  for_all_lanes([](const Lanes&, WideRunner& runner) {
    const auto whole = runner.run(even_cutting(kFrames, kLongestSubBlock));
    CHECK(first_difference(whole, runner.run(even_cutting(kFrames, 1))) == "");
    CHECK(first_difference(whole, runner.run(random_cutting(kFrames, 3))) == "");
    CHECK(first_difference(whole, runner.run(random_cutting(kFrames, 4, 11))) == "");
  });
}

TEST_CASE("wide: halves give what the whole gives, and delays are those of all lanes", "[conformance]") {
  for_all_lanes([](const Lanes& lanes, WideRunner& runner) {
    for (std::size_t i = 0; i < lanes.type().inputs.size(); ++i) {
      if (!lanes.type().inputs[i].late) continue;
      const int input = static_cast<int>(i);
      DelayRange all{1 << 30, 0};
      for (const auto& one : lanes.cases) {
        const auto delay = one.runner().node().delay(input, 0);
        all = {std::min(all.least, delay.least), std::max(all.most, delay.most)};
      }
      CHECK(runner.node().delay(input, 0).least == all.least);
      CHECK(runner.node().delay(input, 0).most == all.most);
      if (all.least < 1) continue;
      const auto whole = runner.run(even_cutting(kFrames, kLongestSubBlock));
      CHECK(first_difference(whole, runner.run(even_cutting(kFrames, std::min(all.least, 64)), true)) == "");
    }
  });
}

TEST_CASE("wide: nothing is allocated while it runs", "[conformance]") {
  for_all_lanes([](const Lanes&, WideRunner& runner) {
    Samples silence(kLongestSubBlock * kVectorWidth);
    std::vector<Samples> outputs(4, silence);
    std::vector<double*> out;
    for (auto& output : outputs) out.push_back(output.data());
    const std::vector<Signal> in(16, Signal{silence.data(), kVectorWidth});
    const auto before = allocation_count();
    runner.node().reset();
    for (int n = 0; n < 10; ++n)
      runner.node().process({in.data(), out.data(), kLongestSubBlock, n * kLongestSubBlock});
    CHECK(allocation_count() == before);
  });
}
