#include "export/targets/c_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "export/kernel_texts.h"

namespace tactus {
namespace {

constexpr std::size_t kWidth = 110;

constexpr const char* kSeldom =
    "/* What does not run in each frame stays apart, so that a frame saves no registers for it. */\n"
    "#ifdef __GNUC__\n#define TACTUS_SELDOM __attribute__((noinline, cold))\n"
    "#else\n#define TACTUS_SELDOM\n#endif\n\n";

std::string literal(double value) { return c_number(value, *find_number_type("double")); }

bool mentions(const std::vector<Statement>& statements, const std::string& name) {
  return std::ranges::any_of(statements,
                             [&](const Statement& s) { return identifiers_of(s.text).contains(name); });
}

/// A declaration with a comment behind it, or above it where that would be too long.
std::string commented(const std::string& declaration, const std::string& comment) {
  if (comment.empty()) return declaration + "\n";
  const auto text = "/* " + comment + " */";
  const bool behind = declaration.size() + 2 + text.size() <= kWidth;
  return behind ? declaration + "  " + text + "\n" : wrapped("  " + text) + "\n" + declaration + "\n";
}

std::string limits_comment(const CProgram& program) {
  if (!program.guard) return "Outputs are not limited: this program was exported without a guard.";
  std::string text = "Limits of the outputs, full scale = 1 (" + program.limits_from + "):";
  for (const auto& output : program.outputs) {
    const auto& limits = output.limits->limits;
    text += fmt::format("\n   {}: ceiling {:g}", output.name, limits.ceiling);
    if (has_slew_limit(*output.limits)) text += fmt::format(", slew {:g} per second", limits.slew_per_second);
    text +=
        fmt::format(", soft start {:g} s, fade-out {:g} s", limits.soft_start.value, limits.fade_out.value);
  }
  return text + "\n   All outputs fade out unless tactus_alive was called within the last 500 ms of frames.";
}

std::string ports_comment(const char* what, const std::vector<ProgramPort>& ports) {
  std::string text;
  for (std::size_t i = 0; i < ports.size(); ++i) {
    text += fmt::format("   {}[{}] {}", what, i, ports[i].name);
    if (!ports[i].unit.empty()) text += " [" + ports[i].unit + "]";
    if (!ports[i].about.empty()) text += ": " + ports[i].about;
    text += '\n';
  }
  return text;
}

std::string controls_struct(const CProgram& program) {
  std::string text =
      "/* What the caller sets, in SI units; each moves there smoothly. */\ntypedef struct tactus_controls "
      "{\n";
  for (const auto& control : program.controls)
    text += commented("  tactus_real " + control.name + ";", control.about);
  if (program.controls.empty()) text += "  unsigned char none; /* there are no controls */\n";
  return text + "} tactus_controls;\n\n";
}

std::string ramps_struct(const CProgram& program) {
  if (program.controls.empty()) return {};
  std::string text = "/* Where the controls are on their way. */\ntypedef struct tactus_ramps {\n";
  for (const auto& control : program.controls) text += "  tactus_control " + control.name + ";\n";
  return text + "} tactus_ramps;\n\n";
}

std::string nodes_struct(const CProgram& program) {
  std::string text =
      "/* State of the nodes, and values that depend on controls alone. */\ntypedef struct tactus_nodes {\n";
  for (const auto& member : program.members) {
    text += commented("  " + member.declaration + ";", member.about);
  }
  if (program.members.empty()) text += "  unsigned char none;\n";
  return text + "} tactus_nodes;\n\n";
}

std::string program_struct(const CProgram& program) {
  std::string text = "/* The whole program. */\ntypedef struct tactus {\n  tactus_controls controls;\n";
  if (!program.controls.empty()) text += "  tactus_ramps ramps;\n";
  text += "  tactus_nodes nodes;\n";
  if (program.guard)
    text += fmt::format("  tactus_guard guards[{}];\n  tactus_switch alive;\n",
                        std::max<std::size_t>(1, program.outputs.size()));
  if (program.needs_frame_number()) text += "  unsigned long long frame; /* since the start */\n";
  text +=
      "  unsigned char cell;    /* frames so far modulo 256 */\n"
      "  unsigned char silent;  /* frames left of the silence after a fault */\n";
  if (!program.controls.empty())
    text += "  unsigned char busy;    /* a control moves, or a design does not follow the controls yet */\n";
  if (!program.designs.empty())
    text += "  unsigned char stale;   /* a design does not follow the controls yet */\n";
  return text + "} tactus;\n\n";
}

/// Everything that is in the header's structs.
std::string structs(const CProgram& program) {
  return controls_struct(program) + ramps_struct(program) + nodes_struct(program) + program_struct(program);
}

KernelChoice choice_of(const CProgram& program) {
  const std::string plain = "export/kernels/plain_filter_kernel.h";
  return program.recurrence == RecurrenceForm::Plain ? KernelChoice{{plain}, {}} : KernelChoice{{}, {plain}};
}

/// The number type is defined by the program's own header.
std::vector<KernelItem> kernels_for(const std::string& text, const CProgram& program) {
  auto items = needed_kernel_items(identifiers_of(text), choice_of(program));
  std::erase_if(items, [](const KernelItem& item) { return item.names.front() == "tactus_real"; });
  return items;
}

std::string text_of(const std::vector<KernelItem>& items) {
  std::string text;
  for (const auto& item : items) text += item.text + "\n" + (item.text.starts_with("#define") ? "" : "\n");
  return text;
}

/// A limit that is not exceeded.
double rounded_down(double limit, const NumberType& type) {
  if (type.bytes != sizeof(float)) return limit;
  const auto nearest = static_cast<float>(limit);
  return static_cast<double>(static_cast<double>(nearest) > limit ? std::nextafter(nearest, 0.0F) : nearest);
}

/// The program compares differences of numbers, which are rounded too: one step of floats less is never
/// exceeded.
double largest_step(const DriveLimits& limits, Hertz rate, const NumberType& type) {
  const double step = limits.slew_per_second / rate.value;
  if (type.bytes != sizeof(float)) return step;
  const auto below = std::nextafter(static_cast<float>(rounded_down(step, type)), 0.0F);
  return std::max(static_cast<double>(below), spacing_below(limits.ceiling, type));
}

std::string limits_table(const CProgram& program) {
  if (!program.guard || program.outputs.empty()) return {};
  std::string text =
      "/* Ceiling, largest step, spacing of numbers, and frames of soft start and fade-out of each output. "
      "*/\n"
      "static const tactus_limits tactus_output_limits[TACTUS_OUTPUTS] = {\n";
  const double rate = program.sample_rate.value;
  const auto& type = *program.number;
  for (const auto& output : program.outputs) {
    const auto& limits = output.limits->limits;
    text += fmt::format(
        "    {{{}, {}, {}, {}, {}}}, /* {} */\n", literal(rounded_down(limits.ceiling, type)),
        has_slew_limit(*output.limits) ? literal(largest_step(limits, program.sample_rate, type))
                                       : "INFINITY",
        literal(spacing_below(limits.ceiling, type)), std::llround(limits.soft_start.value * rate),
        std::llround(limits.fade_out.value * rate), output.name);
  }
  return text + "};\n\n";
}

/// What statements call `s` and `c`.
std::string names_in(const std::string& statements) {
  const auto names = identifiers_of(statements);
  std::string text;
  if (names.contains("s")) text += "  tactus_nodes* const s = &self->nodes;\n";
  if (names.contains("c")) text += "  const tactus_ramps* const c = &self->ramps;\n";
  return text;
}

std::string follow_functions(const CProgram& program) {
  std::string text;
  if (!program.follow.empty()) {
    const auto body = indented(program.follow, 2);
    text +=
        "/* What depends on controls alone. */\nstatic TACTUS_SELDOM void tactus_follow(tactus* self) {\n" +
        names_in(body) + body + "}\n\n";
  }
  if (!program.designs.empty()) {
    const auto body = indented(program.designs, 2);
    text +=
        "/* Filters and strings follow the controls at the start of a group of eight frames. */\n"
        "static TACTUS_SELDOM void tactus_design(tactus* self) {\n" +
        names_in(body) + body + "  self->stale = 0;\n}\n\n";
  }
  return text;
}

std::string reset_function(const CProgram& program) {
  std::string text = "/* All nodes as they were at the start. */\nstatic void tactus_reset(tactus* self) {\n";
  if (!program.start.empty()) text += "  tactus_nodes* const s = &self->nodes;\n";
  text += "  memset(&self->nodes, 0, sizeof self->nodes);\n" + indented(program.start, 2);
  if (!program.follow.empty()) text += "  tactus_follow(self);\n";
  if (!program.designs.empty()) text += "  self->stale = self->busy = 1;\n";
  return text + "}\n\n";
}

/// Frames of parts with a rate of their own.
std::string divided_names(const CProgram& program) {
  std::set<int> divisors;
  for (const auto& statement : program.frame)
    if (statement.divisor > 1) divisors.insert(statement.divisor);
  std::string text;
  for (const int divisor : divisors) {
    const auto number = fmt::format("frame_number_{}", divisor),
               position = fmt::format("group_position_{}", divisor);
    const bool placed = mentions(program.frame, position);
    if (placed || mentions(program.frame, number))
      text += fmt::format("  const unsigned long long {} = frame_number / {};\n", number, divisor);
    if (placed) text += fmt::format("  const int {} = (int)({} % 8);\n", position, number);
  }
  return text;
}

std::string frame_statements(const CProgram& program) {
  std::string text;
  int divisor = 1;
  for (const auto& statement : program.frame) {
    if (statement.divisor != divisor) {
      if (divisor > 1) text += "  }\n";
      if (statement.divisor > 1) text += fmt::format("  if (frame_number % {} == 0) {{\n", statement.divisor);
      divisor = statement.divisor;
    }
    text += indented({statement.with_loop()}, divisor > 1 ? 4 : 2);
  }
  return text + (divisor > 1 ? "  }\n" : "");
}

/// In pairs, so that no addition waits for all those before it.
std::string sum_in_pairs(std::vector<std::string> terms) {
  while (terms.size() > 1) {
    std::vector<std::string> pairs;
    for (std::size_t i = 0; i + 1 < terms.size(); i += 2) pairs.push_back(terms[i] + " + " + terms[i + 1]);
    if (terms.size() > 2)
      for (auto& pair : pairs) pair = "(" + pair + ")";
    if (terms.size() % 2 != 0) pairs.push_back(terms.back());
    terms = std::move(pairs);
  }
  return terms.front();
}

/// Whether all that matters stayed finite: x - x is 0, or NaN where x is not finite.
std::string finite_check(const CProgram& program) {
  std::string faults;
  for (const auto& fault : program.faults) faults += (faults.empty() ? "" : " | ") + fault;
  if (program.checked.empty())
    return indented({"return " + (faults.empty() ? "1" : "!(" + faults + ")") + ";"}, 2);
  std::vector<std::string> terms;
  for (const auto& value : program.checked) terms.push_back(fmt::format("({0} - {0})", value));
  return indented({"const tactus_real check = " + sum_in_pairs(std::move(terms)) + ";  /* 0 or NaN */",
                   "return check == check" + (faults.empty() ? "" : " && !(" + faults + ")") + ";"},
                  2);
}

std::string frame_function(const CProgram& program) {
  const auto body = frame_statements(program), variables = indented(program.variables, 2);
  const auto names = identifiers_of(body + variables);
  std::string text =
      "/* One frame of all nodes. 0: something is not finite. */\n"
      "static int tactus_frame(tactus* self, const tactus_real* in, tactus_real* out) {\n" +
      names_in(body + variables);
  const bool positioned = names.contains("group_position");
  if (positioned) text += "  const int group_position = (self->cell + 7) % 8;  /* this frame is counted */\n";
  if (program.needs_frame_number()) text += "  const unsigned long long frame_number = self->frame;\n";
  text += divided_names(program) + variables;
  if (!names.contains("in")) text += "  (void)in;\n";
  if (program.outputs.empty()) text += "  (void)out;\n";
  if (!names.contains("s") && !names.contains("c") && !positioned && !program.needs_frame_number())
    text += "  (void)self;\n";
  return text + body + finite_check(program) + "}\n\n";
}

std::string init_function(const CProgram& program) {
  std::string text = "void tactus_init(tactus* self) {\n  memset(self, 0, sizeof *self);\n";
  for (const auto& control : program.controls)
    text += fmt::format("  self->controls.{0} = {1};\n  tactus_control_start(&self->ramps.{0}, {1});\n",
                        control.name, literal(control.value));
  return text + "  tactus_reset(self);\n}\n\n";
}

std::string alive_function(const CProgram& program) {
  return std::string{"void tactus_alive(tactus* self) {"} +
         (program.guard ? " tactus_switch_refresh(&self->alive); }\n\n" : " (void)self; }\n\n");
}

std::string control_steps(const CProgram& program) {
  std::string text;
  for (const auto& control : program.controls)
    text += indented(
        {fmt::format("moved |= tactus_control_{}step(&self->ramps.{}, self->controls.{}, {}, {}, {});",
                     control.decibel ? "decibel_" : "", control.name, control.name, literal(control.low),
                     literal(control.high), control.smooth_frames)},
        2);
  return text;
}

std::string silence_function(const CProgram& program) {
  std::string text =
      "/* After a fault: all nodes start anew, and outputs are 0 to the next multiple of 64 frames. */\n"
      "static TACTUS_SELDOM void tactus_silence(tactus* self, tactus_real* out) {\n"
      "  if (self->silent == 0) {\n"
      "    tactus_reset(self);\n"
      "    self->silent = (unsigned char)(64 - (self->cell + 63) % 64);\n"
      "  }\n"
      "  --self->silent;\n";
  return text +
         (program.outputs.empty() ? "  (void)out;\n" : "  memset(out, 0, TACTUS_OUTPUTS * sizeof *out);\n") +
         "}\n\n";
}

/// Nodes and guard.
std::string statements_of_step(const CProgram& program) {
  std::string text = "  ++self->cell;\n";
  if (program.guard)
    text += fmt::format("  const int open = tactus_switch_step(&self->alive, {});\n",
                        std::llround(0.5 * program.sample_rate.value));
  text += "  if (self->silent > 0 || !tactus_frame(self, in, out)) tactus_silence(self, out);\n";
  if (program.guard && !program.outputs.empty())
    text +=
        "  for (int k = 0; k < TACTUS_OUTPUTS; ++k)\n"
        "    out[k] = tactus_guard_step(&self->guards[k], &tactus_output_limits[k], open, out[k]);\n";
  if (program.guard && program.outputs.empty()) text += "  (void)open;\n";
  if (program.needs_frame_number()) text += "  ++self->frame;\n";
  return text;
}

/// Where a control moves, on the way to the same frame.
std::string attend_function(const CProgram& program) {
  const bool follows = !program.follow.empty(), designs = !program.designs.empty();
  std::string text =
      "/* A frame in which controls move. */\n"
      "static TACTUS_SELDOM void tactus_attend(tactus* self, const tactus_real* in, tactus_real* out) {\n"
      "  int moved = 0;\n" +
      control_steps(program);
  if (follows) text += "  if (moved) tactus_follow(self);\n";
  if (designs)
    text +=
        "  if (moved) self->stale = 1;\n"
        "  if (self->stale && self->cell % 8 == 0) tactus_design(self);\n";
  text += std::string{"  self->busy = (unsigned char)(moved"} + (designs ? " || self->stale" : "") + ");\n";
  return text + "  tactus_run(self, in, out);\n}\n\n";
}

std::string step_functions(const CProgram& program) {
  const std::string parameters = "(tactus* self, const tactus_real* in, tactus_real* out) {\n";
  const auto statements = statements_of_step(program);
  if (program.controls.empty()) return "void tactus_step" + parameters + statements + "}\n";
  std::string condition = "self->busy";
  for (const auto& control : program.controls)
    condition += fmt::format(" || self->controls.{0} != self->ramps.{0}.to", control.name);
  return "static void tactus_run" + parameters + statements + "}\n\n" + attend_function(program) +
         "void tactus_step" + parameters + indented({"if (" + condition + ")"}, 2) +
         "    tactus_attend(self, in, out);\n  else\n    tactus_run(self, in, out);\n}\n";
}

/// Each line for itself, but for comments.
std::string wrapped_lines(const std::string& text) {
  std::string lines;
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const auto line = text.substr(at, end - at);
    lines += (line.find("//") == line.npos ? wrapped(line) : line) + "\n";
    at = end + 1;
  }
  return lines;
}

std::string functions(const CProgram& program) {
  std::string text;
  for (const auto& table : program.tables) text += wrapped(table) + "\n";
  if (!program.tables.empty()) text += "\n";
  for (const auto& function : program.functions) text += wrapped_lines(function) + "\n";
  return text + limits_table(program) + follow_functions(program) + reset_function(program) +
         frame_function(program) + init_function(program) + alive_function(program) +
         silence_function(program) + step_functions(program);
}

}  // namespace

double spacing_below(double ceiling, const NumberType& type) {
  if (type.bytes != sizeof(float)) return 0.0;
  const auto limit = static_cast<float>(rounded_down(ceiling, type));
  return static_cast<double>(limit - std::nextafter(limit, 0.0F));
}

bool has_slew_limit(const GuardedChannel& channel) {
  return channel.kind == DriveGuard::Kind::Drive && std::isfinite(channel.limits.slew_per_second);
}

std::string in_capitals(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string indented(const std::vector<std::string>& statements, int spaces) {
  const std::string indent(static_cast<std::size_t>(spaces), ' ');
  std::string text;
  for (const auto& statement : statements)
    for (std::size_t at = 0; at <= statement.size();) {
      const auto end = std::min(statement.find('\n', at), statement.size());
      text += wrapped(indent + statement.substr(at, end - at)) + "\n";
      at = end + 1;
    }
  return text;
}

std::string header_begin(const HeaderCounts& counts, Hertz rate, const std::string& includes) {
  return "#ifndef TACTUS_H\n#define TACTUS_H\n\n" + includes +
         "#ifdef __cplusplus\nextern \"C\" {\n#endif\n\n#define TACTUS_RATE " + literal(rate.value) + "\n" +
         fmt::format("enum {{ TACTUS_INPUTS = {}, TACTUS_OUTPUTS = {}, TACTUS_CONTROLS = {} }};\n\n",
                     counts.inputs, counts.outputs, counts.controls);
}

std::string header_end(const std::string& about_step) {
  return "void tactus_init(tactus* self);\n"
         "/* The caller is alive: refreshes the dead man's switch. */\n"
         "void tactus_alive(tactus* self);\n/* " +
         about_step +
         " */\n"
         "void tactus_step(tactus* self, const tactus_real* in, tactus_real* out);\n\n"
         "#ifdef __cplusplus\n}\n#endif\n#endif\n";
}

std::string wrapped(const std::string& line) {
  if (line.size() <= kWidth || line.find('\n') != std::string::npos) return line;
  const auto indent = line.find_first_not_of(' ');
  std::string text, rest = line;
  std::string further(indent + 4, ' ');
  while (rest.size() > kWidth) {
    auto at = rest.rfind(' ', kWidth);
    if (at == std::string::npos || at <= rest.find_first_not_of(' ')) break;
    text += rest.substr(0, at) + "\n";
    rest = further + rest.substr(at + 1);
  }
  return text + rest;
}

std::string as_of_program(const std::string& text, const CProgram& program) {
  const auto converted = with_numbers(text, *program.number);
  const auto capitals = in_capitals(program.name);
  std::string result;
  for (std::size_t at = 0; at < converted.size();) {
    if (!is_identifier_start(converted[at]) || (at > 0 && is_identifier_part(converted[at - 1]))) {
      result += converted[at++];
      continue;
    }
    std::size_t end = at;
    while (end < converted.size() && is_identifier_part(converted[end])) ++end;
    const auto word = converted.substr(at, end - at);
    if (word == "tactus" || word == "TACTUS_H")
      result += word == "tactus" ? program.name : capitals + "_H";
    else if (word == "tactus_real")
      result += program.name + "_number";
    else if (word.starts_with("tactus_"))
      result += program.name + word.substr(6);
    else if (word.starts_with("TACTUS_"))
      result += capitals + word.substr(6);
    else
      result += word;
    at = end;
  }
  return result;
}

std::vector<std::string> type_declarations(const CProgram& program) {
  const auto text = structs(program);
  auto items = kernels_for(text, program);
  std::erase_if(items, [](const KernelItem& item) { return !item.is_type; });
  for (auto& item : kernel_items({"", text})) items.push_back(std::move(item));
  std::vector<std::string> declarations;
  for (const auto& item : items) declarations.push_back(item.code);
  return declarations;
}

std::string c_header(const CProgram& program) {
  const auto text = structs(program);
  std::string types;
  for (const auto& item : kernels_for(text, program))
    if (item.is_type) types += item.text + "\n" + (item.text.starts_with("#define") ? "" : "\n");
  const auto head = fmt::format(
      "/* {}{}{}\n   Exported by Tactus from {} for {:g} Hz; system delay {:g} s; recurrences {}.\n\n{}{}\n  "
      " {}\n*/\n",
      program.title, program.about.empty() ? "" : ": " + program.about,
      program.source.empty() ? "" : "\n   Source: " + program.source, program.file, program.sample_rate.value,
      program.system_delay.value,
      program.recurrence == RecurrenceForm::Grid ? "on a grid of eight frames" : "frame by frame",
      ports_comment("in", program.inputs), ports_comment("out", program.outputs), limits_comment(program));
  return as_of_program(
      head +
          header_begin({program.inputs.size(), program.outputs.size(), program.controls.size()},
                       program.sample_rate, "") +
          "typedef " + program.number->c_type + " tactus_real;\n\n" + types + text +
          header_end("One frame. Inputs and outputs in the order of the file, lanes one after the other."),
      program);
}

std::string c_source(const CProgram& program) {
  const auto own = functions(program), declared = structs(program);
  std::set<std::string> in_header;
  for (const auto& item : kernels_for(declared, program))
    if (item.is_type) in_header.insert(item.names.front());
  auto items = kernels_for(own + declared, program);
  std::erase_if(items, [&](const KernelItem& item) { return in_header.contains(item.names.front()); });
  return as_of_program("/* " + program.title + ": see " + program.name + ".h. */\n#include \"" +
                           program.name + ".h\"\n\n#include <math.h>\n#include <string.h>\n\n" + kSeldom +
                           text_of(items) + own,
                       program);
}

}  // namespace tactus
