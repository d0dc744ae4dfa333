#pragma once

// Thread: [control].

#include <string>
#include <vector>

#include "engine/graph/plan/plan.h"
#include "export/fixed/arithmetic.h"
#include "export/program.h"
#include "export/recorded_nodes.h"

namespace tactus {

/// A graph in integers: what CProgram is in real numbers. Text is that of export/fixed/numbers.h.in.
struct FixedProgram {
  struct Port {
    std::string name, unit, about;
    FixedValue value;
    bool audio = false;
    std::optional<GuardedChannel> limits = {};
  };
  struct Control {
    std::string name, about;
    FixedValue value;  ///< its range is what it is limited to
    double start = 0;
  };

  CProgram heading;  ///< its names, and how it was exported; nothing else of it is used
  int bits = 16;
  std::vector<Port> inputs, outputs;
  std::vector<Control> controls;
  std::vector<ProgramMember> members;
  std::vector<std::string> tables;
  std::vector<std::string> start, follow, frame;
  std::vector<FixedDecision> decisions;
};

/// The ranges of the inputs, in the order of the plan; nullopt: the file gives none.
using InputRanges = std::vector<std::optional<Interval>>;

/// Errors: BadArgument for each input without a range, for each node that has no form in integers, and for
/// each signal of which no range is known.
Checked<FixedProgram> read_fixed(CProgram heading, int bits, const Plan& plan, const RecordedNodes& nodes,
                                 const InputRanges& ranges);

/// sizeof of the whole program, without padding.
std::size_t state_bytes(const FixedProgram& program);

/// Header, source and description.
std::string fixed_header(const FixedProgram& program);
std::string fixed_source(const FixedProgram& program);
/// The arithmetic that both need: NAME_numbers.h.
std::string fixed_numbers(const FixedProgram& program);
std::string fixed_readme(const FixedProgram& program);

}  // namespace tactus
