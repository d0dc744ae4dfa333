#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "export/targets/c_text.h"
#include "export/targets/memory.h"
#include "export/targets/target.h"

namespace tactus {
namespace {

std::string example(const CProgram& program) {
  return as_of_program(
      R"(/* Raw numbers from standard input through the program to standard output, frame by frame. */
#include <stdio.h>

#include ")" +
          program.name + R"(.h"

int main(void) {
  static tactus program;
  tactus_real in[TACTUS_INPUTS + 1], out[TACTUS_OUTPUTS + 1];
  tactus_init(&program);
  while (fread(in, sizeof *in, TACTUS_INPUTS, stdin) == TACTUS_INPUTS) {
    tactus_alive(&program);
    tactus_step(&program, in, out);
    if (fwrite(out, sizeof *out, TACTUS_OUTPUTS, stdout) != TACTUS_OUTPUTS) break;
  }
  return 0;
}
)",
      program);
}

std::string control_rows(const CProgram& program) {
  std::string text;
  for (const auto& control : program.controls)
    text += fmt::format("| `{}` | {} |\n", control.name, control.about);
  return text.empty() ? "There are none.\n" : "| member of `controls` | range |\n|---|---|\n" + text;
}

std::string port_rows(const char* what, const std::vector<ProgramPort>& ports) {
  std::string text;
  for (std::size_t i = 0; i < ports.size(); ++i)
    text +=
        fmt::format("| `{}[{}]` | {} | {} | {} |\n", what, i, ports[i].name, ports[i].unit, ports[i].about);
  return text;
}

std::string guard_section(const CProgram& program) {
  if (!program.guard) return limits_section(program);
  return fmt::format(
             "Each output passes: not finite becomes 0; ceiling; soft start and fade-out; slew limit. All "
             "outputs fade out when `{}_alive` was not called for 500 ms of frames, and start softly when it "
             "is called again.\n\n",
             program.name) +
         limits_section(program);
}

std::string memory_rows(const CProgram& program) {
  std::string text;
  for (const auto& machine : machine_types())
    text += fmt::format("| state, `sizeof({})`, {} | {} |\n", program.name, machine.name,
                        state_bytes(program, machine));
  return text;
}

std::string readme(const CProgram& program) {
  std::string name = program.name;
  return fmt::format(
      "# {title}\n\n{about}{newline}C99 without heap, exported by Tactus from `{file}` for {rate:g} Hz.\n\n"
      "## Use\n\n```c\nstatic {name} program;\n{name}_init(&program);            /* once */\n"
      "{name}_alive(&program);           /* at least every 500 ms, by what watches over the program */\n"
      "program.controls.… = …;        /* at any time, in SI units */\n"
      "{name}_step(&program, in, out);   /* each frame */\n```\n\n"
      "Compile with `-ffp-contract=off`, and never with `-ffast-math`: results are then those of the "
      "engine{bits}. "
      "On processors that are slow with denormal numbers, set \"flush to zero\".\n\n"
      "```sh\ncc -O2 -ffp-contract=off {name}.c example.c -lm -o example    # raw {type}s in, raw {type}s "
      "out\n```\n\n"
      "## Inputs and outputs\n\n| | name | unit | |\n|---|---|---|---|\n{inputs}{outputs}\n"
      "## Controls\n\n{controls}{fixed}\n## Guard\n\n{guard}\n"
      "## Memory\n\n| | bytes |\n|---|---|\n{state}"
      "| tables of constants | {tables} |\n\nCode: `cc -Os -ffp-contract=off -c {name}.c && size "
      "{name}.o`\n\n"
      "## Faults\n\nInputs that are not finite count as 0, and so do results of functions outside of their "
      "domain. If "
      "anything else becomes non-finite, all nodes start anew, and the outputs are 0 to the next multiple of "
      "64 frames. "
      "(The engine resets only the node or the loop.)\n",
      fmt::arg("title", program.title), fmt::arg("about", program.about),
      fmt::arg("newline", program.about.empty() ? "" : "\n\n"), fmt::arg("file", program.file),
      fmt::arg("rate", program.sample_rate.value), fmt::arg("name", name),
      fmt::arg("bits", program.recurrence == RecurrenceForm::Grid && program.number->exact_functions
                           ? " to the last bit"
                           : " but for rounding"),
      fmt::arg("type", program.number->c_type), fmt::arg("inputs", port_rows("in", program.inputs)),
      fmt::arg("outputs", port_rows("out", program.outputs)), fmt::arg("controls", control_rows(program)),
      fmt::arg("fixed", fixed_section(program)), fmt::arg("guard", guard_section(program)),
      fmt::arg("state", memory_rows(program)),
      fmt::arg("tables", program.table_bytes * static_cast<std::size_t>(program.number->bytes) / 8));
}

}  // namespace

std::string limits_section(const CProgram& program) {
  if (!program.guard)
    return "None: the program was exported with `--no-guard`. Never connect an actuator to it directly.\n";
  std::string text = "Limits: " + program.limits_from +
                     ".\n\n| output | ceiling | slew per second | soft start | fade-out |\n"
                     "|---|---|---|---|---|\n";
  for (const auto& output : program.outputs) {
    const auto& limits = output.limits->limits;
    text +=
        fmt::format("| {} | {:g} | {} | {:g} s | {:g} s |\n", output.name, limits.ceiling,
                    has_slew_limit(*output.limits) ? fmt::format("{:g}", limits.slew_per_second) : "no limit",
                    limits.soft_start.value, limits.fade_out.value);
  }
  return text +
         "\nThe engine's limits of heat, excursion and DC and its feedback detector are not part of the "
         "program.\n";
}

std::string fixed_section(const CProgram& program) {
  if (program.fixed_controls.empty()) return {};
  std::string text = "\nFixed when the program was exported (`--set NAME=VALUE` gives other values):\n";
  for (const auto& control : program.fixed_controls) text += "- " + control + "\n";
  return text;
}

std::vector<ExportedFile> c_files(const CProgram& program) {
  return {{program.name + ".h", c_header(program)},
          {program.name + ".c", c_source(program)},
          {"example.c", example(program)},
          {"README.md", readme(program)}};
}

}  // namespace tactus
