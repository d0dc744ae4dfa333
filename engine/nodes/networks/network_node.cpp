#include "engine/nodes/networks/network_node.h"

#include <algorithm>
#include <utility>

#include "engine/core/index.h"
#include "engine/nodes/networks/network_builder.h"
#include "engine/nodes/networks/solver_names.h"

namespace tactus {
namespace {

class NetworkNode final : public Node, public NetworkView {
 public:
  NetworkNode(NetworkRecipe recipe, Network network, std::vector<NetworkReading> readings,
              const NodeType& type)
      : fingerprint_(type.fingerprint),
        recipe_(std::move(recipe)),
        network_(std::move(network)),
        state_(network_.initial_state()),
        readings_(std::move(readings)),
        signal_ports_(recipe_.signal_ports),
        now_(signal_ports_.size()),
        read_(readings_.size()),
        late_(type.inputs.size()) {
    for (const int port : signal_ports_) late_[index(port)] = true;
  }

  void process(const NodeBlock& block) noexcept override {
    const std::size_t count = find_read(block);
    for (int frame = 0; frame < block.frames; ++frame) {
      write(block, frame, count);
      step(block, frame);
    }
  }
  void emit(const NodeBlock& block) noexcept override { write(block, 0, find_read(block)); }
  void absorb(const NodeBlock& block) noexcept override { step(block, 0); }
  void reset() noexcept override { network_.reset(state_); }

  void adopt(Node& before) noexcept override {
    const auto* other = dynamic_cast<const NetworkNode*>(&before);
    if (other != nullptr && other->fingerprint_ == fingerprint_) network_.adopt(state_, other->state_);
  }

  std::string about() const override {
    const auto& choice = network_.choice();
    return choice ? "solver " + explain_choice(*choice) : std::string{};
  }

  DelayRange delay(int input, int) const override {
    return late_[index(input)] ? DelayRange{1, 1} : DelayRange{};
  }

  const NetworkRecipe& recipe() const override { return recipe_; }
  double energy() const override { return network_.energy(state_); }
  double position(int point) const override { return network_.position(state_, point); }
  double shown(const Network& network, const NetworkState& state, int output) const override {
    const auto& reading = readings_[index(output)];
    return reading.read(network, state, reading.parts);
  }

 private:
  /// Puts the outputs that somebody reads to the front of `read_`.
  std::size_t find_read(const NodeBlock& block) noexcept {
    std::size_t count = 0;
    for (std::size_t i = 0; i < readings_.size(); ++i)
      if (block.out[i] != nullptr) read_[count++] = i;
    return count;
  }

  void write(const NodeBlock& block, int frame, std::size_t count) const noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      const auto& reading = readings_[read_[i]];
      block.out[read_[i]][frame] = reading.read(network_, state_, reading.parts);
    }
  }

  void step(const NodeBlock& block, int frame) noexcept {
    for (std::size_t i = 0; i < now_.size(); ++i) now_[i] = block.in[signal_ports_[i]][frame];
    network_.step(state_, now_.data());
  }

  std::uint64_t fingerprint_;  ///< which elements, joined how
  NetworkRecipe recipe_;
  Network network_;
  NetworkState state_;
  std::vector<NetworkReading> readings_;
  std::vector<int> signal_ports_;
  std::vector<double> now_;
  std::vector<std::size_t> read_;
  std::vector<bool> late_;
};

}  // namespace

Result<std::unique_ptr<Node>> make_network_node(const NetworkLayout& layout, const NodeSetup& setup) {
  std::size_t points = 0;
  for (const auto& element : layout.elements) points += index(element.points());
  // A point, its springs and what a solver keeps for them; before they are made.
  if (const auto fits = setup.take_memory(64 * points); !fits) return tl::unexpected(fits.error());
  NetworkBuilder builder(layout, setup);
  const auto couplings =
      builder.elements.contacts.size() + builder.elements.bonds.size() + builder.elements.frictions.size();
  const auto each =
      layout.solver == Solver::Explicit ? builder.elements.frictions.size() : points + 2 * couplings;
  if (const auto fits = setup.take_memory(couplings * each); !fits) return tl::unexpected(fits.error());
  NetworkRecipe recipe;
  recipe.signals = static_cast<int>(builder.signal_ports.size());
  recipe.rate = setup.sample_rate;
  recipe.signal_ports = builder.signal_ports;
  builder.name_parts(recipe);
  recipe.elements = std::move(builder.elements);
  auto network =
      Network::make(recipe.elements, recipe.signals, recipe.rate, layout.solver, layout.oversample);
  if (!network) return tl::unexpected(network.error());
  recipe.solver = network->solver();
  recipe.oversample = network->oversample();
  return std::make_unique<NetworkNode>(std::move(recipe), std::move(*network), builder.readings(),
                                       *setup.type);
}

}  // namespace tactus
