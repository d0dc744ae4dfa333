#pragma once

// Thread: [realtime] what engine/graph/node.h says so; constructors [control].

#include <algorithm>
#include <array>
#include <complex>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "engine/nodes/declare.h"
#include "engine/nodes/process.h"

namespace tactus {

/// out[n] = value(in_0[n], in_1[n], …), where the first `Moving` inputs are signals and the compiler can see
/// that the others are constant.
template <std::size_t Moving, class Value, std::size_t... Input>
[[gnu::always_inline]] inline void run_moving(const NodeBlock& block, Value& value,
                                              std::index_sequence<Input...>) noexcept {
  const std::array in{block.in[Input].data...};
  const std::array constant{in[Input][0]...};
  double* const out = block.out[0];
  for (int n = 0, frames = block.frames; n < frames; ++n)
    out[n] = value((Input < Moving ? in[Input][n] : constant[Input])...);
}

template <std::size_t Inputs>
bool only_first_move(const NodeBlock& block, std::size_t moving) noexcept {
  for (std::size_t k = 0; k < Inputs; ++k)
    if (block.in[k].constant() == (k < moving)) return false;
  return true;
}

/// Where only the first one or two inputs move; false: it did nothing.
template <std::size_t Inputs, class Value>
[[gnu::always_inline]] inline bool run_first_moving(const NodeBlock& block, Value value) noexcept {
  constexpr auto kInputs = std::make_index_sequence<Inputs>{};
  if (only_first_move<Inputs>(block, 1)) return run_moving<1>(block, value, kInputs), true;
  if constexpr (Inputs > 1)
    if (only_first_move<Inputs>(block, 2)) return run_moving<2>(block, value, kInputs), true;
  return false;
}

/// Any inputs may move.
template <std::size_t Inputs, class Value>
[[gnu::always_inline]] inline void run_any(const NodeBlock& block, Value value) noexcept {
  [&]<std::size_t... Input>(std::index_sequence<Input...>) {
    const std::array in{block.in[Input]...};
    double* const out = block.out[0];
    for (int n = 0, frames = block.frames; n < frames; ++n) out[n] = value(in[Input][n]...);
  }
  (std::make_index_sequence<Inputs>{});
}

/// One output, a function of the inputs of its frame (and of what `value` refers to).
template <std::size_t Inputs, class Value>
[[gnu::always_inline]] inline void run_frames(const NodeBlock& block, Value value) noexcept {
  if (!run_first_moving<Inputs>(block, value)) run_any<Inputs>(block, value);
}

/// The same for a block of one frame.
template <std::size_t Inputs, class Value>
[[gnu::always_inline]] inline void run_single_frame(const NodeBlock& block, Value value) noexcept {
  [&]<std::size_t... Input>(std::index_sequence<Input...>) {
    *block.out[0] = value(*block.in[Input].data...);
  }
  (std::make_index_sequence<Inputs>{});
}

inline double rate_of(const NodeSetup& setup) { return setup.sample_rate.value; }
inline double frame_s_of(const NodeSetup& setup) { return 1 / setup.sample_rate.value; }

template <class State, class... Numbers>
State state_of(double (*)(State*, Numbers...));

/// A node of one output whose kernel, `Step`, goes frame by frame: it is given the state, all zero at the
/// start, `Inputs` inputs in the order of their declaration and, if it takes one more number, `Further`.
template <auto Step, std::size_t Inputs, auto Further = rate_of>
class KernelNode : public Node {
 public:
  explicit KernelNode(const NodeSetup& setup) : further_(Further(setup)) {}

  void process(const NodeBlock& block) noexcept override {
    if (block.frames > 1) return process_frames(block);
    run_single_frame<Inputs>(block, [this](auto... in) { return step(state_, further_, in...); });
  }
  void reset() noexcept override { state_ = {}; }
  void copy(const Node& other) noexcept override { assign(*this, other); }

 protected:
  using State = decltype(state_of(Step));

  double further_;
  State state_{};

 private:
  template <class... In>
  static double step(State& state, double further, In... in) noexcept {
    if constexpr (std::is_invocable_v<decltype(Step), State*, In...>)
      return Step(&state, in...);
    else
      return Step(&state, in..., further);
  }

  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_frames(const NodeBlock& block) noexcept {
    State state = state_;  // in registers: the output could overlap a member
    const auto from = [further = further_](State& s) {
      return [&s, further](auto... in) { return step(s, further, in...); };
    };
    const bool done = run_first_moving<Inputs>(block, from(state));
    // Much state stays in memory where much moves: there are not enough registers.
    if (!done && sizeof(State) > kMostInRegisters) return run_any<Inputs>(block, from(state_));
    if (!done) run_any<Inputs>(block, from(state));
    state_ = state;
  }

  static constexpr std::size_t kMostInRegisters = 32;  ///< bytes
};

/// A node of one output that goes frame by frame: `step` is given the state, which begins as State{}, and the
/// inputs in the order of their declaration.
template <std::size_t Inputs, class State, class Step>
Result<std::unique_ptr<Node>> make_step_node(Step step) {
  class StepNode final : public Node {
   public:
    explicit StepNode(Step&& taken) : step_(std::move(taken)) {}
    void process(const NodeBlock& block) noexcept override {
      run_frames<Inputs>(block, [this](auto... in) { return step_(state_, in...); });
    }
    void reset() noexcept override { state_ = {}; }
    void copy(const Node& other) noexcept override {
      if (const auto* same = dynamic_cast<const StepNode*>(&other)) state_ = same->state_;
    }

   private:
    Step step_;
    State state_{};
  };
  return std::make_unique<StepNode>(std::move(step));
}

/// A node without memory: one output, a function of the inputs of the same frame, or eight of them in one
/// vector register. A Function may depend on the settings, which all lanes have in common, and on nothing
/// else.
/// `Function` has `static constexpr int kInputs`, `double value(in) const` and `double slope(input, in)
/// const`, where `in` are the inputs' values in declaration order (`value` may take Lanes as well); `slope`
/// is the derivative by one of them, which is the response.
template <class Function, int Width = 1>
class ElementwiseNode final : public Node {
 public:
  explicit ElementwiseNode(Function function) : function_(std::move(function)) {}

  void process(const NodeBlock& block) noexcept override {
    if (Width > 1 || block.frames > 1) return process_frames(block);
    run_single_frame<kInputs>(block, [this](auto... in) { return this->value(in...); });
  }
  void reset() noexcept override {}

  std::unique_ptr<Node> vectorised(std::span<const Node* const>) const override {
    return std::make_unique<ElementwiseNode<Function, kVectorWidth>>(function_);
  }

  std::optional<std::complex<double>> response(int input, int, std::complex<double>,
                                               std::span<const double> at) const override {
    return function_.slope(input, at.data());
  }

 private:
  static constexpr auto kInputs = static_cast<std::size_t>(Function::kInputs);
  static constexpr bool kTakesLanes = requires(const Function& function, const Lanes* all) {
    function.value(all);
  };

  // Not inlined: the setup for many frames would delay a single one.
  [[gnu::noinline]] void process_frames(const NodeBlock& block) const noexcept {
    if constexpr (Width == 1) {
      if constexpr (kTakesLanes)
        if (block.frames % kVectorWidth == 0 && only_first_move<kInputs>(block, 1)) return run_vectors(block);
      run_frames<kInputs>(block, [this](auto... in) { return this->value(in...); });
    } else {
      std::array<Signal, kInputs> signals;
      std::copy_n(block.in, kInputs, signals.begin());
      const bool rows =
          std::none_of(signals.begin(), signals.end(), [](const Signal& in) { return in.stride == 1; });
      rows ? run_lanes(signals, block,
                       [](const Signal& in, int n) { return Lanes::load(in.data + n * in.stride); })
           : run_lanes(signals, block, [](const Signal& in, int n) { return VectorSignal{in}[n]; });
    }
  }
  /// `lanes_at(signal, frame)`: all lanes of a frame.
  template <class LanesAt>
  void run_lanes(const std::array<Signal, kInputs>& signals, const NodeBlock& block,
                 LanesAt lanes_at) const noexcept {
    std::array<Lanes, kInputs> in;
    double* out = block.out[0];
    for (int n = 0, frames = block.frames; n < frames; ++n, out += Width) {
      for (std::size_t k = 0; k < kInputs; ++k) in[k] = lanes_at(signals[k], n);
      lanes(in).store(out);
    }
  }
  /// Where only the first input moves.
  void run_vectors(const NodeBlock& block) const noexcept {
    std::array<Lanes, kInputs> in;
    for (std::size_t k = 1; k < kInputs; ++k) in[k] = Lanes::broadcast(*block.in[k].data);
    const double* from = block.in[0].data;
    double* to = block.out[0];
    for (const double* const end = from + block.frames; from != end;
         from += kVectorWidth, to += kVectorWidth) {
      in[0] = Lanes::load(from);
      function_.value(in.data()).store(to);
    }
  }
  template <class... In>
  double value(In... in) const noexcept {
    const double values[] = {in...};
    return function_.value(values);
  }
  Lanes lanes(const std::array<Lanes, kInputs>& in) const noexcept {
    if constexpr (kTakesLanes) {
      return function_.value(in.data());
    } else {
      std::array<std::array<double, kVectorWidth>, kInputs> rows;
      for (std::size_t k = 0; k < kInputs; ++k) in[k].store(rows[k].data());
      std::array<double, kVectorWidth> result;
      for (std::size_t lane = 0; lane < kVectorWidth; ++lane) {
        std::array<double, kInputs> values;
        for (std::size_t k = 0; k < kInputs; ++k) values[k] = rows[k][lane];
        result[lane] = function_.value(values.data());
      }
      return Lanes::load(result.data());
    }
  }

  Function function_;
};

/// `make` of a node type whose function has no settings.
template <class Function>
Result<std::unique_ptr<Node>> make_elementwise(const NodeSetup&) {
  return std::make_unique<ElementwiseNode<Function>>(Function{});
}

}  // namespace tactus
