#pragma once

// Thread: [control].

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "export/operators.h"
#include "export/program.h"

namespace tactus {

/// An input of a node as the code around it has it.
struct WrittenInput {
  CExpression value;
  Pace pace = Pace::Frame;
  std::optional<double> constant = {};
  Interval range = {};  ///< as far as numbers, controls and the system delay decide it
};

/// Why a node cannot be exported as its file has it.
struct ExportRefusal {
  std::string reason, remedy;
};

/// What an exported node consists of. An entry of the table of node types fills it (see
/// export/nodes/table.h).
struct WrittenNode {
  std::vector<ProgramMember> members;
  std::vector<std::string> tables;
  std::size_t table_bytes = 0;
  std::vector<std::string> functions;  ///< at file scope
  std::vector<std::string> start;      ///< statements for a state of zeros
  std::vector<std::string> follow;     ///< whenever controls move
  std::vector<std::string> design;     ///< the same, at the start of a group of eight frames
  std::vector<std::string> variables;  ///< of a frame, declared at its start
  std::vector<std::string> step;       ///< of each frame
  std::vector<std::string> late;       ///< what reads late inputs; on a loop it follows later
  std::vector<std::string> values;     ///< [output] the expression; "": it is not read
  std::vector<int> last;               ///< outputs that are worked out behind the others
  std::optional<ExportRefusal> refusal;
};

/// Helps to write a node. `in` and `give` are in the order of the declaration. Text is that of kernels:
/// numbers are doubles, `s->` is the state.
class NodeWriter {
 public:
  /// Makes names of members and tables, which no other node has.
  using MakeName = std::function<std::string(const std::string& wanted, bool member)>;
  using WithInputs = std::function<std::string(const std::vector<std::string>& inputs)>;

  NodeWriter(const NodeSetup& setup, std::string kernel, std::string state, std::string name,
             std::vector<WrittenInput> inputs, std::vector<bool> read, bool halves, int divisor,
             RecurrenceForm recurrence, MakeName make_name, const Node* running = nullptr)
      : setup_(setup),
        kernel_(std::move(kernel)),
        state_(std::move(state)),
        name_(std::move(name)),
        inputs_(std::move(inputs)),
        read_(std::move(read)),
        halves_(halves),
        divisor_(divisor),
        recurrence_(recurrence),
        make_name_(std::move(make_name)),
        running_(running) {
    node_.values.resize(read_.size());
  }

  const NodeSetup& setup() const { return setup_; }
  /// The node as the engine runs it.
  const Node* running() const { return running_; }
  /// Of the entry of its type.
  const std::string& kernel() const { return kernel_; }
  const std::string& state_type() const { return state_; }
  void set_kernel(std::string kernel) { kernel_ = std::move(kernel); }
  const std::string& setting(std::string_view name) const { return setup_.setting(name).text; }
  /// It lies on a loop: what it gives must not depend on late inputs of the same frame, which `late` takes.
  bool halves() const { return halves_; }
  /// Recurrences run frame by frame.
  bool plain() const { return recurrence_ == RecurrenceForm::Plain; }
  bool reads(int output) const { return read_[index(output)]; }

  static std::string number(double value) { return c_number(value, *find_number_type("double")); }
  std::string rate() const { return number(setup_.sample_rate.value); }
  /// Of its frames, modulo 8; and their number since the start.
  std::string position() const {
    return divisor_ == 1 ? "group_position" : "group_position_" + std::to_string(divisor_);
  }
  std::string frame() const {
    return divisor_ == 1 ? "frame_number" : "frame_number_" + std::to_string(divisor_);
  }

  /// An input, as an argument or as an operand.
  const std::string& in(int input) const { return inputs_[index(input)].value.text; }
  std::string operand(int input) const { return inputs_[index(input)].value.within(CExpression::Operand); }
  Pace pace(int input) const { return inputs_[index(input)].pace; }
  std::optional<double> constant(int input) const { return inputs_[index(input)].constant; }
  Interval range(int input) const { return inputs_[index(input)].range; }
  /// The same where it is read several times.
  std::string variable(int input);

  /// A member of the state, `count` of them (0: one that is no array); returns how code refers to it.
  template <class Type>
  std::string state(const std::string& type, const std::string& suffix = "", int count = 0) {
    return add_member(type, suffix, count, sizeof(Type));
  }
  std::string state(const std::string& type, const std::string& suffix, int count, std::size_t bytes) {
    return add_member(type, suffix, count, bytes);
  }
  /// Numbers that never change; returns the name of the array.
  std::string table(const std::string& suffix, const std::vector<double>& values);
  /// The same of any type, with its text.
  std::string table(const std::string& type, const std::string& suffix, const std::string& text,
                    std::size_t bytes);

  /// The name of a function of this node alone.
  std::string function_name(const std::string& suffix);
  /// A function at file scope.
  void function(std::string text) { node_.functions.push_back(std::move(text)); }

  /// A name for a value of this frame.
  std::string local(const std::string& suffix, const std::string& value) {
    return local("tactus_real", suffix, value);
  }
  std::string local(const std::string& type, const std::string& suffix, const std::string& value);

  /// A variable of the frame that `step` and `late` may change; `value` is its value at the start.
  std::string frame_variable(const std::string& type, const std::string& suffix, const std::string& value);

  void start(std::string statement) { node_.start.push_back(std::move(statement)); }
  void step(std::string statement) { node_.step.push_back(std::move(statement)); }
  /// A statement that depends on controls alone.
  void follow(std::string statement) { node_.follow.push_back(std::move(statement)); }
  void late(std::string statement) { node_.late.push_back(std::move(statement)); }
  /// What an output is, behind the statements of `step`.
  void give(int output, std::string value) {
    if (reads(output)) node_.values[index(output)] = std::move(value);
  }

  /// The same of a call that changes the state, which must run also where its result is not read.
  void call(int output, const std::string& text) { reads(output) ? give(output, text) : step(text + ";"); }
  /// Where another output's call comes first although it is behind this one.
  void after(int output, const std::string& value) {
    give(output, value);
    if (reads(output)) node_.last.push_back(output);
  }
  void refuse(std::string reason, std::string remedy) {
    node_.refusal = {std::move(reason), std::move(remedy)};
  }

  /// A statement that depends on some inputs: once at the start if they are constant, else at the start of
  /// each group of eight frames in which one of them has changed. `statement` is given how to refer to the
  /// inputs, in their order.
  void design(const std::vector<int>& inputs, const WithInputs& statement);
  /// The same in each frame in which one of them has changed.
  void when_changed(const std::vector<int>& inputs, const WithInputs& statement,
                    const std::string& condition = {});

  WrittenNode& node() { return node_; }

 private:
  std::string add_member(const std::string& type, const std::string& suffix, int count, std::size_t bytes);

  const NodeSetup& setup_;
  std::string kernel_, state_;
  std::string name_;
  std::vector<WrittenInput> inputs_;
  std::vector<bool> read_;
  bool halves_;
  int divisor_;
  RecurrenceForm recurrence_;
  MakeName make_name_;
  const Node* running_;
  WrittenNode node_;
};

}  // namespace tactus
