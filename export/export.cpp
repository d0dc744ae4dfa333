#include "export/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "engine/core/named.h"
#include "engine/core/port_name.h"
#include "export/c_names.h"
#include "export/fixed/fixed_program.h"
#include "export/read_plan.h"
#include "export/targets/memory.h"

namespace tactus {
namespace {

/// As the machine of the target has it: of an AVR a double is a float.
const NumberType* number_of(const ExportOptions& options) {
  const auto& machine = machine_types()[index(options.target->machine)];
  const bool narrow = options.number->bits == 0 && index(options.number->bytes) > machine.of_double;
  return narrow ? find_number_type("float") : options.number;
}

CProgram program_of(const GraphSpec& spec, const ExportOptions& options) {
  CProgram program;
  const std::filesystem::path file{spec.file.text()};
  program.title = spec.name.empty() ? file.stem().string() : spec.name;
  program.name = c_identifier(program.title);
  program.about = spec.about;
  program.source = spec.source;
  program.file = file.filename().string();
  program.sample_rate = options.sample_rate;
  program.system_delay = options.system_delay;
  program.recurrence = options.recurrence;
  program.number = number_of(options);
  program.guard = options.limits != nullptr;
  program.limits_from = options.limits_from;
  return program;
}

/// Unit and description of ports.
template <class Port>
void describe(std::vector<Port>& ports, const std::vector<PortSpec>& specs) {
  for (auto& port : ports) {
    const auto* spec = find_named(specs, port_of(port.name));
    if (spec == nullptr) continue;
    if (const auto* unit = find(spec->fields, "unit"); unit != nullptr && unit->text())
      port.unit = *unit->text();
    if (const auto* about = find(spec->fields, "about"); about != nullptr && about->text())
      port.about = *about->text();
  }
}

template <class Program>
void describe(Program& program, const Plan& plan, const GraphSpec& spec, const ExportOptions& options) {
  describe(program.inputs, spec.inputs);
  describe(program.outputs, spec.outputs);
  std::size_t output = 0;
  for (const auto& channel : plan.channels)
    if (channel.use != OutputUse::Tap && options.limits)
      program.outputs[output++].limits = options.limits(channel);
}

Error too_large(const CProgram& program, std::size_t bytes, std::size_t most) {
  return {Errc::OutOfRange, program.file,
          "its state takes " + std::to_string(bytes) + " bytes, and at most " + std::to_string(most) +
              " are allowed",
          "choose numbers with fewer bytes (--number), a lower --rate, or fewer and shorter nodes"};
}

std::size_t most_bytes(const ExportOptions& options) {
  return options.most_bytes.value_or(options.target->most_bytes);
}

/// On the processor of the target.
std::size_t state_bytes(const CProgram& program, const ExportOptions& options) {
  return state_bytes(program, machine_types()[index(options.target->machine)]);
}

/// What takes an eighth of the allowed memory or more, where all of it is too much.
std::vector<Error> too_large(const CProgram& program, const ExportOptions& options) {
  const auto bytes = state_bytes(program, options), most = most_bytes(options);
  if (bytes <= most) return {};
  std::vector<Error> errors{too_large(program, bytes, most)};
  std::map<std::pair<std::string, std::string>, std::size_t> nodes;
  for (const auto& member : program.members) nodes[{member.where, member.about}] += member.bytes;
  for (const auto& [node, numbers] : nodes)
    if (const auto own = numbers * static_cast<std::size_t>(program.number->bytes) / 8; 8 * own >= most)
      errors.push_back({Errc::OutOfRange, node.first,
                        node.second + " takes " + std::to_string(own) + " bytes",
                        "shorten it: a smaller longest time, a higher lowest pitch, fewer modes or masses"});
  return errors;
}

CompileOptions compiling(const ExportOptions& options) {
  CompileOptions compiling;
  compiling.sample_rate = options.sample_rate;
  compiling.system_delay = options.system_delay;
  compiling.controls = options.controls;
  compiling.vectorise = false;
  return compiling;
}

InputRanges input_ranges(const Plan& plan, const GraphSpec& spec) {
  InputRanges ranges;
  for (const auto& name : plan.input_names) {
    const auto* input = find_named(spec.inputs, port_of(name));
    ranges.push_back(input == nullptr ? std::nullopt : input->range);
  }
  return ranges;
}

/// Files of a board, behind those of the program that it runs.
Checked<std::vector<ExportedFile>> with_board(std::vector<ExportedFile> files, const BoardProgram& program,
                                              const ExportOptions& options, const GraphSpec& spec) {
  if (options.target->board == nullptr) return files;
  std::vector<Error> errors;
  for (const auto& input : program.inputs)
    if (options.target->converts && !input.range.bounded())
      errors.push_back({Errc::BadArgument, find_named(spec.inputs, port_of(input.name))->at.text(),
                        "input '" + input.name + "' has no range, so that the converter has no scale",
                        "give it one in [inputs], as in range = [\"-50 mm\", \"50 mm\"]"});
  if (!errors.empty()) return tl::unexpected(std::move(errors));
  // A board has a main of its own.
  std::erase_if(files, [](const ExportedFile& file) { return file.name == "example.c"; });
  for (auto& file : options.target->board(program)) {
    const auto same = std::ranges::find(files, file.name, &ExportedFile::name);
    if (same == files.end())
      files.push_back(std::move(file));
    else
      same->text += file.text;
  }
  return files;
}

/// A slew limit that is less than one step of an output's numbers a frame could only be exceeded, or hold the
/// output still. `step_of` an output: of its numbers.
template <class Output, class StepOf>
std::vector<Error> limits_too_fine(const CProgram& heading, const std::vector<Output>& outputs,
                                   StepOf step_of) {
  std::vector<Error> errors;
  for (const auto& output : outputs) {
    if (!heading.guard || output.limits->kind != DriveGuard::Kind::Drive) continue;
    const double slew = output.limits->limits.slew_per_second;
    const double least = step_of(output) * heading.sample_rate.value;
    if (slew < least)
      errors.push_back({Errc::OutOfRange, heading.file,
                        fmt::format("the slew limit of '{}', {:g} a second, is less than one step of its "
                                    "numbers a frame, {:.3g} a second",
                                    output.name, slew, least),
                        "choose numbers with more digits (--number) or a lower --rate"});
  }
  return errors;
}

Checked<CProgram> c_program(const Plan& plan, const RecordedNodes& recorded, const GraphSpec& spec,
                            const ExportOptions& options) {
  auto program = read_plan(program_of(spec, options), plan, recorded);
  if (!program) return program;
  describe(*program, plan, spec, options);
  const auto step_of = [&](const auto& output) {
    return spacing_below(output.limits->limits.ceiling, *program->number);
  };
  if (auto errors = limits_too_fine(*program, program->outputs, step_of); !errors.empty())
    return tl::unexpected(std::move(errors));
  return program;
}

Checked<FixedProgram> fixed_program(const Plan& plan, const RecordedNodes& recorded, const GraphSpec& spec,
                                    const ExportOptions& options) {
  auto program =
      read_fixed(program_of(spec, options), options.number->bits, plan, recorded, input_ranges(plan, spec));
  if (!program) return program;
  describe(*program, plan, spec, options);
  const auto step_of = [](const auto& output) { return std::ldexp(1.0, -output.value.exponent); };
  if (auto errors = limits_too_fine(program->heading, program->outputs, step_of); !errors.empty())
    return tl::unexpected(std::move(errors));
  return program;
}

Checked<std::vector<ExportedFile>> fixed_files(const FixedProgram& program, const GraphSpec& spec,
                                               const ExportOptions& options) {
  const auto& name = program.heading.name;
  BoardProgram board{&program.heading, {}, {}, state_bytes(program)};
  for (const auto& port : program.inputs)
    board.inputs.push_back({port.name, port.value.range, port.value.exponent});
  for (const auto& port : program.outputs)
    board.outputs.push_back({port.name, port.value.range, port.value.exponent});
  return with_board({{name + ".h", fixed_header(program)},
                     {name + "_numbers.h", fixed_numbers(program)},
                     {name + ".c", fixed_source(program)},
                     {"README.md", fixed_readme(program)}},
                    board, options, spec);
}

}  // namespace

Checked<CProgram> write_program(const LoadedGraph& graph, const NodeTable& nodes,
                                const ExportOptions& options) {
  const RecordedNodes recorded{nodes};
  const auto plan = compile(graph, recorded.table(), compiling(options));
  if (!plan) return tl::unexpected(plan.error());
  return c_program(**plan, recorded, *graph.spec, options);
}

Checked<FixedProgram> write_fixed_program(const LoadedGraph& graph, const NodeTable& nodes,
                                          const ExportOptions& options) {
  const RecordedNodes recorded{nodes};
  const auto plan = compile(graph, recorded.table(), compiling(options));
  if (!plan) return tl::unexpected(plan.error());
  return fixed_program(**plan, recorded, *graph.spec, options);
}

Checked<std::vector<ExportedFile>> export_graph(const LoadedGraph& graph, const NodeTable& nodes,
                                                const ExportOptions& options) {
  const RecordedNodes recorded{nodes};
  const auto plan = compile(graph, recorded.table(), compiling(options));
  if (!plan) return tl::unexpected(plan.error());
  if (options.number->bits > 0) {
    const auto program = fixed_program(**plan, recorded, *graph.spec, options);
    if (!program) return tl::unexpected(program.error());
    if (const auto bytes = state_bytes(*program); bytes > most_bytes(options))
      return tl::unexpected(std::vector{too_large(program->heading, bytes, most_bytes(options))});
    return fixed_files(*program, *graph.spec, options);
  }
  auto program = c_program(**plan, recorded, *graph.spec, options);
  if (!program) return tl::unexpected(program.error());
  if (auto errors = too_large(*program, options); !errors.empty()) return tl::unexpected(std::move(errors));
  BoardProgram board{&*program, {}, {}, state_bytes(*program, options)};
  const auto ranges = input_ranges(**plan, *graph.spec);
  for (std::size_t i = 0; i < program->inputs.size(); ++i)
    board.inputs.push_back({program->inputs[i].name, ranges[i].value_or(Interval{}), 0});
  for (const auto& output : program->outputs) board.outputs.push_back({output.name, {}, 0});
  return with_board(options.target->files(*program), board, options, *graph.spec);
}

}  // namespace tactus
