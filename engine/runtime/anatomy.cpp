#include "engine/runtime/anatomy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <unordered_map>
#include <unordered_set>

namespace tactus {
namespace {

class Describer {
 public:
  explicit Describer(const Schedule& schedule) : schedule_(schedule), done_(schedule.nodes.size(), false) {}

  Anatomy run() {
    name_sources();
    for (const auto& step : schedule_.steps) describe(step);
    for (std::size_t i = 0; i < found_.parts.size(); ++i) found_.index.emplace(found_.parts[i].name, i);
    for (const auto& channel : schedule_.channels) found_.channels.push_back(operand(channel.signal, -1));
    return std::move(found_);
  }

 private:
  const std::string& path(int index) const { return schedule_.paths[static_cast<std::size_t>(index)]; }

  void name_sources() {
    for (const auto& constant : schedule_.constants) constants_.insert(constant.get());
    for (const auto& values : schedule_.wide_constants) name_lanes(*values);
    for (std::size_t c = 0; c < schedule_.input_buffers.size(); ++c)
      source_.emplace(schedule_.input_buffers[c], "input " + schedule_.input_names[c]);
    for (const auto& control : schedule_.controls)
      source_.emplace(control.buffer, "control " + control.control.name);
    source_.emplace(schedule_.system_delay, "system.delay");
    for (const auto& step : schedule_.steps) {
      if (step.kind == Step::Kind::Outside) continue;
      if (step.kind == Step::Kind::Operations)
        for (int i = 0; i < step.operations; ++i) name_operation(step.first_operation + i);
      else
        name_node(step);
    }
  }

  /// Wide operations of one expression have one path as well.
  void name_node(const Step& step) {
    auto& name = node_names_[step.node];
    if (name.empty()) {
      const int nth = nodes_at_[step.path]++;
      name = "node " + path(step.path) + (nth == 0 ? "" : " " + std::to_string(nth));
    }
    for (int port = 0; port < step.outputs; ++port) {
      const double* out = schedule_.outputs[static_cast<std::size_t>(step.first_out + port)];
      if (out == nullptr) continue;
      for (int lane = 0; lane < step.width; ++lane)
        source_.emplace(out + lane, name + ":" + std::to_string(port) + "." + std::to_string(lane));
    }
  }

  /// One number for all lanes is a constant like any other; several are a source, which another one replaces.
  void name_lanes(const std::array<double, kWide>& values) {
    if (std::count(values.begin(), values.end(), values[0]) == kWide) {
      constants_.insert(values.data());
      return;
    }
    std::string name = "numbers";
    for (const double value : values) name += " " + std::to_string(std::bit_cast<std::uint64_t>(value));
    source_.emplace(values.data(), name + ":0");
  }

  /// The operations of one expression have one path: they are counted.
  void name_operation(int index) {
    const auto& operation = schedule_.operations[static_cast<std::size_t>(index)];
    const auto name =
        "operation " + path(operation.path) + " " + std::to_string(operations_at_[operation.path]++);
    source_.emplace(operation.out, name + ":0");
    operation_names_.emplace(index, name);
  }

  void describe(const Step& step) {
    if (step.kind == Step::Kind::Outside) return;
    if (step.kind == Step::Kind::Operations) {
      for (int i = step.first_operation; i < step.first_operation + step.operations; ++i) {
        const auto& operation = schedule_.operations[static_cast<std::size_t>(i)];
        add({operation_names_.at(i), -1, static_cast<std::uint64_t>(operation.op), step.pace_in, {}},
            operation.first_in, 2);
      }
      return;
    }
    const auto node = static_cast<std::size_t>(step.node);
    if (done_[node]) return;  // the other half of it
    done_[node] = true;
    add({node_names_.at(step.node), step.node, schedule_.fingerprints[node], step.pace_in, {}}, step.first_in,
        step.inputs);
  }

  void add(Anatomy::Part part, int first_in, int inputs) {
    for (int i = first_in; i < first_in + inputs; ++i)
      part.operands.push_back(operand(schedule_.inputs[static_cast<std::size_t>(i)], i));
    found_.parts.push_back(std::move(part));
  }

  Anatomy::Operand operand(const Signal& signal, int slot) const {
    const double* data = signal.data;  // the stride belongs to the audio thread
    if (constants_.contains(data)) return {slot, {}, *data};
    const auto source = source_.find(data);
    return {slot, source == source_.end() ? std::string{} : source->second, std::nullopt};
  }

  const Schedule& schedule_;
  std::vector<bool> done_;  ///< [node]
  std::unordered_set<const double*> constants_;
  std::unordered_map<const double*, std::string> source_;
  std::unordered_map<int, int> operations_at_, nodes_at_;  ///< [path] how many so far
  std::unordered_map<int, std::string> operation_names_, node_names_;
  Anatomy found_;
};

}  // namespace

Anatomy anatomy(const Schedule& schedule) { return Describer{schedule}.run(); }

}  // namespace tactus
