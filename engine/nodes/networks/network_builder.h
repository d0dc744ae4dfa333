#pragma once

// Thread: [control]
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/index.h"
#include "engine/graph/node_type.h"
#include "engine/nodes/networks/network.h"
#include "engine/nodes/networks/network_elements.h"

namespace tactus {

/// `[networks.x]` with its names resolved: which element is joined to which. Numbers are not known yet.
struct NetworkLayout {
  std::vector<NetworkElement> elements;
  Solver solver = Solver::Passive;
  int oversample = 0;  ///< 0: not in the file
  bool turns = false;  ///< see kMotionSetting
};

/// Errors, all in one go: unknown types, keys and elements; ends that are missing, too many, or of
/// the wrong kind; options out of their range. `NetworkElement::ports` is filled later.
Checked<NetworkLayout> read_network_layout(const NetworkSpec& spec);

/// Builds the physical network of `[networks.x]`, as far as it matters to the outputs that are read.
class NetworkBuilder {
 public:
  NetworkBuilder(const NetworkLayout& layout, const NodeSetup& setup);

  /// One for each output of the declaration, in its order; 0 if a part that it reads has been left out.
  std::vector<NetworkReading> readings() const;
  /// Elements of which nothing is left, with the reason.
  const std::vector<LeftOut>& left_out() const { return left_out_; }
  /// Distinguishes what has been left out; 0: nothing.
  std::uint64_t variant() const;
  /// What the elements are called, by what they have become.
  void name_parts(NetworkRecipe& recipe) const;

  // For `ElementType::build`.

  /// Whether an optional field is in the file.
  bool has(const NetworkElement& element, std::string_view field) const { return port(element, field) >= 0; }
  /// 0 for an optional field that is not there.
  double number(const NetworkElement& element, std::string_view field) const;
  NetworkInput signal(const NetworkElement& element, std::string_view field);
  /// The point that an end names; -1: none.
  int end(const NetworkElement& element, std::size_t which) const;
  /// In how many axes an end moves.
  int axes_at(const NetworkElement& element, std::size_t which) const;
  int add_ground(double at);
  /// What another element has become.
  const ElementParts& parts(int element) const { return parts_[index(element)]; }
  /// The index of the new part in its list.
  template <class Part>
  static int append(std::vector<Part>& list, Part part) {
    list.push_back(std::move(part));
    return static_cast<int>(list.size()) - 1;
  }

  NetworkElements elements;
  std::vector<int> signal_ports;  ///< input of each signal of the network
  // Which of all parts and signals each one is, without anything left out.
  PartNumbers original_parts;
  std::vector<int> original_signals;

 private:
  int port(const NetworkElement& element, std::string_view field) const;
  std::vector<std::optional<double>> constants() const;
  PartMarks read_parts() const;
  void leave_out();
  void find_left_out(const PartMarks& needed);
  /// Whether that end is a marked mass.
  bool on_mass(const NetworkElement& element, std::size_t which, const PartMarks& marked) const;
  ElementParts kept(const ElementParts& parts) const;

  const NetworkLayout& layout_;
  const NodeSetup& setup_;
  std::vector<ElementParts> parts_;  ///< without anything left out
  PartNumbers now_;                  ///< where each of them is
  std::vector<LeftOut> left_out_;
};

}  // namespace tactus
