#include "export/export.h"

#include <filesystem>

#include "export/read_plan.h"
#include "export/targets/memory.h"

namespace tactus {
namespace {

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
  program.number = options.number;
  program.guard = options.limits != nullptr;
  program.limits_from = options.limits_from;
  return program;
}

/// Unit and description of ports; a lane of "strings" is called "strings[2]".
void describe(std::vector<ProgramPort>& ports, const std::vector<PortSpec>& specs) {
  for (auto& port : ports) {
    const auto name = port.name.substr(0, port.name.find('['));
    const auto* spec = find_named(specs, name);
    if (spec == nullptr) continue;
    if (const auto* unit = find(spec->fields, "unit"); unit != nullptr && unit->text())
      port.unit = *unit->text();
    if (const auto* about = find(spec->fields, "about"); about != nullptr && about->text())
      port.about = *about->text();
  }
}

/// What takes an eighth of the allowed memory or more, where all of it is too much.
std::vector<Error> too_large(const CProgram& program, const ExportOptions& options) {
  const auto& machine = machine_types()[index(options.target->machine)];
  const auto bytes = state_bytes(program, machine), most = *options.most_bytes;
  if (bytes <= most) return {};
  std::vector<Error> errors{{Errc::OutOfRange, program.file,
                             "its state takes " + std::to_string(bytes) + " bytes, and at most " +
                                 std::to_string(most) + " are allowed",
                             "choose --number float, a lower --rate, or fewer and shorter nodes"}};
  for (const auto& member : program.members)
    if (const auto own = member.bytes * static_cast<std::size_t>(program.number->bytes) / 8; 8 * own >= most)
      errors.push_back({Errc::OutOfRange, member.where,
                        member.about + " takes " + std::to_string(own) + " bytes",
                        "shorten it: a smaller longest time, a higher lowest pitch, fewer modes"});
  return errors;
}

}  // namespace

Checked<CProgram> write_program(const LoadedGraph& graph, const NodeTable& nodes,
                                const ExportOptions& options) {
  const RecordedNodes recorded{nodes};
  CompileOptions compiling;
  compiling.sample_rate = options.sample_rate;
  compiling.system_delay = options.system_delay;
  compiling.controls = options.controls;
  compiling.vectorise = false;
  const auto plan = compile(graph, recorded.table(), compiling);
  if (!plan) return tl::unexpected(plan.error());
  auto program = read_plan(program_of(*graph.spec, options), **plan, recorded);
  if (!program) return program;
  describe(program->inputs, graph.spec->inputs);
  describe(program->outputs, graph.spec->outputs);
  std::size_t output = 0;
  for (const auto& channel : (*plan)->channels)
    if (channel.use != OutputUse::Tap && options.limits)
      program->outputs[output++].limits = options.limits(channel);
  return program;
}

Checked<std::vector<ExportedFile>> export_graph(const LoadedGraph& graph, const NodeTable& nodes,
                                                const ExportOptions& options) {
  const auto program = write_program(graph, nodes, options);
  if (!program) return tl::unexpected(program.error());
  if (options.most_bytes)
    if (auto errors = too_large(*program, options); !errors.empty()) return tl::unexpected(std::move(errors));
  return options.target->files(*program);
}

}  // namespace tactus
