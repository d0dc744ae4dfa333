#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "export/targets/c_text.h"
#include "export/targets/target.h"
#include "export/targets/target_texts.h"

namespace tactus {
namespace {

constexpr int kMostPulses = 2;       ///< outputs of timer 1
constexpr int kMostConversions = 8;  ///< channels of the converter that all these processors have

std::string replaced(std::string text, const std::string& word, const std::string& value) {
  for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + value.size()))
    text.replace(at, word.size(), value);
  return text;
}

std::string of_target(const std::string& path, const BoardProgram& program) {
  return replaced(replaced(target_text("export/targets/" + path), "@NAME@", program.heading->name),
                  "@INPUTS@", std::to_string(std::min<std::size_t>(kMostConversions, program.inputs.size())));
}
std::string code(const std::string& path, const BoardProgram& program) {
  return as_of_program(of_target(path, program), *program.heading);
}

bool in_integers(const BoardProgram& program) { return program.heading->number->bits > 0; }

/// A value from 0 to 1023 of channel `c` as a number.
std::string conversion(const BoardProgram& program) {
  std::string text =
      "/* What the converter gives, 0 to 1023 of 1024, as a number. */\n"
      "static inline tactus_real tactus_of_converter(uint8_t c, uint16_t code) {\n  switch (c) {\n";
  for (int c = 0; c < std::min(kMostConversions, static_cast<int>(program.inputs.size())); ++c) {
    const auto& [name, range, exponent] = program.inputs[static_cast<std::size_t>(c)];
    std::string value;
    if (!in_integers(program)) {
      value = fmt::format("{} + code * {}", c_number(range.low, *find_number_type("double")),
                          c_number((range.high - range.low) / 1024, *find_number_type("double")));
    } else {
      // Of 1024 steps; as an unsigned product of which the upper word counts.
      const double low = std::ceil(std::ldexp(range.low, exponent)),
                   high = std::floor(std::ldexp(range.high, exponent));
      value = program.heading->number->bits == 16
                  ? fmt::format(
                        "(tactus_real)({:.0f} + (int32_t)(((uint32_t)(uint16_t)(code << 6) * "
                        "(uint16_t){:.0f}U) >> 16))",
                        low, high - low)
                  : fmt::format("(tactus_real)({:.0f}L + (int32_t)(((uint64_t)code * {:.0f}UL) >> 10))", low,
                                high - low);
    }
    text += fmt::format("    case {}: return {}; /* {} */\n", c, value, name);
  }
  return text + "    default: (void)code; return 0;\n  }\n}\n\n";
}

std::string pulses(const BoardProgram& program) {
  std::string text =
      "/* Timer cycles of a pulse, of `frame`. */\n"
      "static inline uint16_t tactus_pulse_width(uint8_t c, tactus_real y, uint16_t frame) {\n";
  if (!in_integers(program)) {
    text +=
        "  const tactus_real duty = 0.5 * (y + 1.0);\n  (void)c;\n"
        "  return (uint16_t)((duty < 0.0 ? 0.0 : duty > 1.0 ? 1.0 : duty) * frame + 0.5);\n";
  } else {
    const bool half = program.heading->number->bits == 16;
    text += "  int32_t width = frame / 2;\n  switch (c) {\n";
    for (std::size_t c = 0; c < std::min<std::size_t>(kMostPulses, program.outputs.size()); ++c) {
      const int by = program.outputs[c].exponent + 1 - (half ? 0 : 16);
      // A long shift is the upper word of what is shifted the other way.
      const auto scaled = by > 16               ? fmt::format("((int16_t)(product >> 16) >> {})", by - 16)
                          : by == 16 || by < 14 ? fmt::format("(product >> {})", by)
                                                : fmt::format("((product << {}) >> 16)", 16 - by);
      text += fmt::format(
          "    case {}: {{ const int32_t product = (int32_t)(int16_t){} * (int16_t)frame; width += {}; "
          "break; }} /* {} */\n",
          c, half ? "y" : "(y >> 16)", scaled, program.outputs[c].name);
    }
    text +=
        "    default: (void)y; break;\n  }\n  return (uint16_t)(width < 0 ? 0 : width > (int32_t)frame ? "
        "(int32_t)frame : width);\n";
  }
  return text + "}\n";
}

std::string board_header(const BoardProgram& program) {
  return as_of_program(
      fmt::format("/* The pins of the program, as its numbers. */\n#ifndef BOARD_H\n#define "
                  "BOARD_H\n\n#include <stdint.h>\n\n#include \"{}.h\"\n\n"
                  "#define TACTUS_CONVERSIONS {}\n#define TACTUS_PULSES {}\n\n",
                  program.heading->name, std::min<std::size_t>(kMostConversions, program.inputs.size()),
                  std::min<std::size_t>(kMostPulses, program.outputs.size())) +
          conversion(program) + pulses(program) + "\n#endif\n",
      *program.heading);
}

std::string pins(const BoardProgram& program) {
  std::string text = "\n## Pins\n\n| pin | | |\n|---|---|---|\n";
  for (std::size_t i = 0; i < std::min<std::size_t>(kMostConversions, program.inputs.size()); ++i)
    text += fmt::format("| A{} | {} | 0 V: {:g}, 5 V: {:g} |\n", i, program.inputs[i].name,
                        program.inputs[i].range.low, program.inputs[i].range.high);
  const char* const names[] = {"OC1A: 9 (Uno), 11 (Mega)", "OC1B: 10 (Uno), 12 (Mega)"};
  for (std::size_t i = 0; i < std::min<std::size_t>(kMostPulses, program.outputs.size()); ++i)
    text += fmt::format("| {} | {} | duty 0 %: -1, 50 %: 0, 100 %: 1 |\n", names[i], program.outputs[i].name);
  text += "| 2 | dead man's switch | the outputs are on while it is connected to ground |\n";
  for (std::size_t i = kMostPulses; i < program.outputs.size(); ++i)
    text += fmt::format("| none | {} | |\n", program.outputs[i].name);
  return text;
}

/// Whether an ATmega328P, with 2048 bytes, has room for the state and a stack.
bool is_small(const BoardProgram& program) { return program.state_bytes <= 1536; }

std::string memory(const BoardProgram& program) {
  return fmt::format("\nThe state takes {} bytes: {}.\n", program.state_bytes,
                     is_small(program)
                         ? "an ATmega328P, with 2048, has room for it"
                         : "too many for an ATmega328P, which has 2048. Use an ATmega2560, which has 8192");
}

const char* const kAvrDelay =
    "\nWhat is sampled at the start of a frame comes out at its end: the delay is one frame. A frame that "
    "takes "
    "longer is counted in `late`.\n";

}  // namespace

std::vector<ExportedFile> avr_files(const BoardProgram& program) {
  const std::string main =
      "\nint main(void) {\n  start_board();\n  sei();\n  for (;;) {\n    watch_switch();\n    "
      "sleep_mode();\n  }\n}\n";
  return {
      {"main.c", "/* The program on an AVR with 16 MHz, such as an ATmega328P, without an operating system." +
                     code("avr/board_head.c", program) + code("avr/board_main.c", program) + main},
      {"board.h", board_header(program)},
      {"Makefile", replaced(of_target("avr/Makefile.in", program), "@MCU@",
                            is_small(program) ? "atmega328p" : "atmega2560")},
      {"simulate.c", of_target("avr/simulate.c", program)},
      {"README.md",
       pins(program) + kAvrDelay + memory(program) +
           "\n## Flash, RAM and cost\n\n`make size` gives flash and RAM. `make cycles` runs the program in "
           "simavr and prints "
           "the cycles of the step, of a frame from its first sample to the pulse width, and from frame to "
           "frame, at 16 MHz.\n"}};
}

std::vector<ExportedFile> arduino_files(const BoardProgram& program) {
  return {{program.heading->name + "_export.ino",
           "/* A sketch for an Arduino with an ATmega328P or ATmega2560, 16 MHz: open it in the Arduino IDE, "
           "in a folder of its name." +
               code("avr/board_head.c", program) + code("avr/board_main.c", program) +
               "\nvoid setup() {\n  start_board();\n  interrupts();\n}\n\nvoid loop() { watch_switch(); }\n"},
          {"board.h", board_header(program)},
          {"README.md", pins(program) + kAvrDelay + memory(program)}};
}

std::vector<ExportedFile> cortex_m_files(const BoardProgram& program) {
  return {{"main.c", code("cortex_m/main.c", program)},
          {"startup.c", of_target("cortex_m/startup.c", program)},
          {"mps2_an386.ld", of_target("cortex_m/mps2_an386.ld", program)},
          {"Makefile", of_target("cortex_m/Makefile.in", program)},
          {"count_instructions.c", of_target("cortex_m/count_instructions.c", program)},
          {"README.md",
           "\n## In a simulator\n\n`make simulate` runs frames from `input.raw` in qemu and writes "
           "`output.raw`, raw numbers. `make size` gives flash "
           "and RAM, `make cycles` the instructions of a frame.\n"}};
}

}  // namespace tactus
