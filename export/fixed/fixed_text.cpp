#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "export/c_names.h"
#include "export/fixed/fixed_program.h"
#include "export/targets/c_text.h"
#include "export/targets/target_texts.h"

namespace tactus {
namespace {

bool mentions(const std::string& text, const std::string& name) {
  return text.find(name) != std::string::npos;
}

std::string number(const FixedProgram& program, double value, const FixedValue& of) {
  return FixedArithmetic{program.bits}.literal(std::clamp(value, of.range.low, of.range.high), of.exponent);
}

std::string scales(const FixedProgram& program) {
  std::string text = "/* Number = value * scale. */\n";
  const auto add = [&](const std::string& name, const FixedValue& value, const std::string& about) {
    text += fmt::format("#define TACTUS_{}_SCALE {:.17g}{} /* {:g} to {:g}{} */\n",
                        in_capitals(c_identifier(name)), std::ldexp(1.0, value.exponent),
                        value.exponent >= 0 ? ".0" : "", value.range.low, value.range.high,
                        about.empty() ? "" : "; " + about);
  };
  for (const auto& port : program.inputs) add(port.name, port.value, port.about);
  for (const auto& control : program.controls) add(control.name, control.value, control.about);
  for (const auto& port : program.outputs) add(port.name, port.value, port.about);
  return text + "\n";
}

std::string structs(const FixedProgram& program) {
  std::string text =
      "/* What the caller sets; values outside of the range count as its end. */\ntypedef struct "
      "tactus_controls {\n";
  for (const auto& control : program.controls) text += fmt::format("  tactus_real {};\n", control.name);
  if (program.controls.empty()) text += "  unsigned char none;\n";
  text +=
      "} tactus_controls;\n\n/* The whole program. */\ntypedef struct tactus {\n  tactus_controls controls, "
      "seen;\n  struct {\n";
  for (const auto& member : program.members)
    text += fmt::format("    {};{}\n", member.declaration,
                        member.about.empty() ? "" : " /* " + member.about + " */");
  if (program.members.empty()) text += "    unsigned char none;\n";
  text += "  } nodes;\n";
  if (program.heading.guard)
    text += fmt::format("  tactus_guard guards[{}];\n  tactus_switch alive;\n",
                        std::max<std::size_t>(1, program.outputs.size()));
  return text + "} tactus;\n\n";
}

std::string limits_table(const FixedProgram& program) {
  if (!program.heading.guard || program.outputs.empty()) return {};
  std::string text =
      "/* Ceiling, largest step, gain that a frame of soft start and of fade-out adds and takes. */\n"
      "static const tactus_limits tactus_output_limits[TACTUS_OUTPUTS] = {\n";
  const double rate = program.heading.sample_rate.value, full = std::ldexp(1.0, 30);
  for (const auto& output : program.outputs) {
    const auto& limits = output.limits->limits;
    const double most = std::ldexp(std::ldexp(1.0, program.bits - 1) - 1, -output.value.exponent);
    const bool drive = output.limits->kind == DriveGuard::Kind::Drive;
    const double step = drive ? limits.slew_per_second / rate : most;
    // Downwards: no limit is exceeded.
    const auto integer = [&](double value) {
      const double whole = std::floor(std::ldexp(std::min(value, most), output.value.exponent));
      return FixedArithmetic{program.bits}.literal(std::ldexp(whole, -output.value.exponent),
                                                   output.value.exponent);
    };
    const auto gain = [&](Seconds time) {
      return fmt::format("{:.0f}UL", std::max(1.0, std::min(full, full / std::max(1.0, time.value * rate))));
    };
    text += fmt::format("    {{{}, {}, {}, {}}}, /* {} */\n", integer(limits.ceiling), integer(step),
                        gain(limits.soft_start), gain(limits.fade_out), output.name);
  }
  return text + "};\n\n";
}

std::string of_nodes(std::string text) {
  std::string result;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool word = at > 0 && is_identifier_part(text[at - 1]);
    if (!word && text.compare(at, 3, "s->") == 0) {
      result += "self->nodes.";
      at += 2;
    } else {
      result += text[at];
    }
  }
  return result;
}

std::string follow_function(const FixedProgram& program) {
  if (program.controls.empty()) return {};
  std::string text = "/* What depends on controls alone. */\nstatic void tactus_follow(tactus* self) {\n";
  std::string body;
  for (const auto& control : program.controls)
    body += fmt::format("  self->nodes.{0} = tactus_larger({1}, tactus_smaller({2}, self->controls.{0}));\n",
                        control.name, number(program, control.value.range.low, control.value),
                        number(program, control.value.range.high, control.value));
  return text + "  self->seen = self->controls;\n" + body + of_nodes(indented(program.follow, 2)) + "}\n\n";
}

std::string changed(const FixedProgram& program) {
  std::string text;
  for (const auto& control : program.controls)
    text += fmt::format("{}self->controls.{} != self->seen.{}", text.empty() ? "" : " || ", control.name,
                        control.name);
  return text;
}

std::string functions(const FixedProgram& program) {
  std::string text;
  for (const auto& table : program.tables) text += wrapped(table) + "\n";
  text += (program.tables.empty() ? "" : "\n") + limits_table(program) + follow_function(program);
  text += "void tactus_init(tactus* self) {\n  memset(self, 0, sizeof *self);\n";
  for (const auto& control : program.controls)
    text += fmt::format("  self->controls.{} = {};\n", control.name,
                        number(program, control.start, control.value));
  if (!program.controls.empty()) text += "  tactus_follow(self);\n";
  text += of_nodes(indented(program.start, 2)) + "}\n\nvoid tactus_alive(tactus* self) {";
  text += program.heading.guard ? " self->alive.refreshes = (unsigned char)(self->alive.refreshes + 1); }\n\n"
                                : " (void)self; }\n\n";
  std::string body;
  if (program.heading.guard)
    body += fmt::format("  const unsigned char open = tactus_switch_step(&self->alive, {:.0f});\n",
                        std::nearbyint(0.5 * program.heading.sample_rate.value));
  if (!program.controls.empty())
    body += wrapped("  if (" + changed(program) + ") tactus_follow(self);") + "\n";
  body += of_nodes(indented(program.frame, 2));
  for (std::size_t i = 0; i < program.outputs.size(); ++i) {
    const auto value = of_nodes(program.outputs[i].value.text);
    body += wrapped(program.heading.guard ? fmt::format("  out[{0}] = tactus_guard_step(&self->guards[{0}], "
                                                        "&tactus_output_limits[{0}], open, {1});",
                                                        i, value)
                                          : fmt::format("  out[{}] = {};", i, value)) +
            "\n";
  }
  text += "void tactus_step(tactus* self, const tactus_real* in, tactus_real* out) {\n" + body;
  if (!mentions(body, "self->")) text += "  (void)self;\n";
  if (!mentions(body, "in[")) text += "  (void)in;\n";
  if (program.outputs.empty()) text += "  (void)out;\n";
  return text + "}\n";
}

/// What a member takes on a processor without padding.
std::size_t bytes_of(const FixedProgram& program, const std::string& declaration) {
  const auto bits = static_cast<std::size_t>(program.bits);
  const std::array<std::pair<std::string_view, std::size_t>, 7> sizes{{{"tactus_word ", bits / 8},
                                                                       {"tactus_wide ", bits / 4},
                                                                       {"unsigned char ", 1},
                                                                       {"uint16_t ", 2},
                                                                       {"uint32_t ", 4},
                                                                       {"tactus_threshold ", 6},
                                                                       {"tactus_biquad ", 16}}};
  const auto bracket = declaration.find('[');
  const std::size_t count = bracket == std::string::npos ? 1 : std::stoul(declaration.substr(bracket + 1));
  for (const auto& [type, size] : sizes)
    if (declaration.starts_with(type)) return size * count;
  return 0;
}
}  // namespace

std::size_t state_bytes(const FixedProgram& program) {
  const auto word = static_cast<std::size_t>(program.bits) / 8;
  std::size_t bytes = program.controls.empty() ? 2 : 2 * word * program.controls.size();
  for (const auto& member : program.members) bytes += bytes_of(program, member.declaration);
  if (program.members.empty()) bytes += 1;
  return bytes +
         (program.heading.guard ? 6 + (4 + word) * std::max<std::size_t>(1, program.outputs.size()) : 0);
}

namespace {

std::string port_rows(const std::vector<FixedProgram::Port>& ports, const char* what, bool bounds) {
  std::string text;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    const auto& value = ports[i].value;
    text += fmt::format("| `{}[{}]` | {} | {} | {:g} to {:g} | {:.3g} | {} | {} |\n", what, i, ports[i].name,
                        ports[i].unit, value.range.low, value.range.high, value.step(),
                        bounds ? fmt::format("{:.3g}", value.error) : "", ports[i].about);
  }
  return text;
}

std::string decisions_section(const FixedProgram& program) {
  std::string text;
  for (const auto& decision : program.decisions) {
    const auto row = fmt::format("- `{}`: {:.3g}\n", decision.path, decision.margin);
    if (!mentions(text, row)) text += row;
  }
  if (text.empty()) return "No comparison depends on rounding.\n";
  return "A comparison of two signals that are nearer to each other than their errors may turn out otherwise "
         "than in exact numbers; "
         "the bound is that of all other frames. These are the distances, in the unit of what is "
         "compared:\n" +
         text;
}

}  // namespace

std::string fixed_header(const FixedProgram& program) {
  const auto& heading = program.heading;
  return as_of_program(
      fmt::format(
          "/* {}{}\n   Exported by Tactus from {} for {:g} Hz, in integers of {} bits: see README.md. */\n",
          heading.title, heading.about.empty() ? "" : ": " + heading.about, heading.file,
          heading.sample_rate.value, program.bits) +
          header_begin({program.inputs.size(), program.outputs.size(), program.controls.size()},
                       heading.sample_rate, "#include \"" + heading.name + "_numbers.h\"\n\n") +
          "typedef tactus_word tactus_real;\n\n" + scales(program) + structs(program) +
          header_end("One frame. Inputs outside of their range count as its end."),
      heading);
}

std::string fixed_source(const FixedProgram& program) {
  const auto& heading = program.heading;
  return as_of_program("/* " + heading.title + ": see " + heading.name + ".h. */\n#include \"" +
                           heading.name + ".h\"\n\n#include <string.h>\n\n" + functions(program),
                       heading);
}

std::string fixed_numbers(const FixedProgram& program) {
  return as_of_program(
      "#define TACTUS_BITS " + std::to_string(program.bits) + "\n" + target_text("export/fixed/numbers.h.in"),
      program.heading);
}

std::string fixed_readme(const FixedProgram& program) {
  const auto& heading = program.heading;
  std::string controls, fixed;
  for (const auto& control : program.controls)
    controls +=
        fmt::format("| `{}` | {:g} to {:g} | {:.3g} | {:g} | {} |\n", control.name, control.value.range.low,
                    control.value.range.high, control.value.step(), control.start, control.about);
  for (const auto& control : heading.fixed_controls) fixed += "- " + control + "\n";
  return fmt::format(
      "# {title}\n\n{about}C99 in integers of {bits} bits, without heap, exported by Tactus from `{file}` "
      "for {rate:g} Hz. Each signal has a scale, "
      "a power of two, as fine as its range allows; no sum and no product can overflow.\n\n"
      "## Inputs and outputs\n\nA number is the value times `{NAME}_…_SCALE` of the header, that is the "
      "value divided by its step.\n\n"
      "| | name | unit | range | step | largest error | |\n|---|---|---|---|---|---|---|\n{inputs}{outputs}\n"
      "The largest error is that of all rounding together, compared to the same graph in exact numbers with "
      "the same inputs; it is a bound, not "
      "what is usual. {decisions}\n"
      "## Controls\n\n{controls}A control applies at once: there are no ramps.\n\n{fixed}"
      "## Memory\n\n| | bytes |\n|---|---|\n| state (`sizeof({name})`, without padding) | {state} |\n\n",
      fmt::arg("title", heading.title),
      fmt::arg("about", heading.about.empty() ? "" : heading.about + "\n\n"), fmt::arg("bits", program.bits),
      fmt::arg("file", heading.file), fmt::arg("rate", heading.sample_rate.value),
      fmt::arg("NAME", in_capitals(heading.name)), fmt::arg("inputs", port_rows(program.inputs, "in", false)),
      fmt::arg("outputs", port_rows(program.outputs, "out", true)),
      fmt::arg("decisions", decisions_section(program)), fmt::arg("name", heading.name),
      fmt::arg("controls",
               controls.empty()
                   ? "There are none. "
                   : "| member of `controls` | range | step | at first | |\n|---|---|---|---|---|\n" +
                         controls + "\n"),
      fmt::arg("fixed",
               fixed.empty()
                   ? ""
                   : "Fixed when the program was exported (`--set NAME=VALUE` gives other values):\n" +
                         fixed + "\n"),
      fmt::arg("state", state_bytes(program)));
}

}  // namespace tactus
