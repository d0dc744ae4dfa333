#pragma once

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <stdexcept>
#include <string>

#include "engine/nodes/table.h"
#include "export/export.h"
#include "tests/benchmarks/hand_written.h"
#include "tests/support/temporary_folder.h"

#ifndef TACTUS_C_COMPILER
#define TACTUS_C_COMPILER "cc"
#endif

namespace tactus::bench {

/// A graph as `tactus export --target library --recurrence plain --no-guard` writes it, compiled for this
/// processor and called frame by frame, from a file of its own as by a program that links the library.
class ExportedProgram {
 public:
  /// Throws what cannot be exported, or what the compiler says.
  explicit ExportedProgram(const LoadedGraph& graph) {
    const auto program = write_program(graph, standard_nodes(), options());
    if (!program) throw std::runtime_error(to_string(program.error()));
    name_ = program->name;
    for (const auto& file : options().target->files(*program)) folder_.write(file.name, file.text);
    folder_.write("caller.c", caller(*program));
  }
  ~ExportedProgram() {
    if (library_ != nullptr) dlclose(library_);
  }
  ExportedProgram(const ExportedProgram&) = delete;
  ExportedProgram& operator=(const ExportedProgram&) = delete;

  /// From the start; compiles it the first time.
  void start() {
    if (library_ == nullptr) compile();
    start_();
  }
  void process(const double* const* in, double* const* out, int frames) { process_(in, out, frames); }

 private:
  static ExportOptions options() {
    ExportOptions options;
    options.target = find_export_target("library");
    options.number = find_number_type("double");
    options.recurrence = RecurrenceForm::Plain;
    options.sample_rate = Hertz{kRate};
    return options;
  }

  /// One channel is handed on where it lies, several are gathered in a frame.
  static std::string caller(const CProgram& program) {
    const auto inputs = program.inputs.size(), outputs = program.outputs.size();
    return fmt::format(
        R"(#include "{0}.h"

void caller_start(void);
void caller_process(const double* const* in, double* const* out, int frames);

static {0} program;

void caller_start(void) {{ {0}_init(&program); }}

void caller_process(const double* const* in, double* const* out, int frames) {{
  for (int n = 0; n < frames; ++n) {{
{1}{2}    {0}_step(&program, {3}, {4});
{5}  }}
}}
)",
        program.name,
        inputs == 1
            ? ""
            : fmt::format("    double ins[{0} + 1];\n    for (int k = 0; k < {0}; ++k) ins[k] = in[k][n];\n",
                          inputs),
        outputs == 1 ? "" : fmt::format("    double outs[{} + 1];\n", outputs),
        inputs == 1 ? "in[0] + n" : "ins", outputs == 1 ? "out[0] + n" : "outs",
        outputs == 1 ? "" : fmt::format("    for (int k = 0; k < {}; ++k) out[k][n] = outs[k];\n", outputs));
  }

  /// Calls within the library are direct, as in a program that it is linked into.
  void compile() {
    const auto command = fmt::format(
        "cd {} && " TACTUS_C_COMPILER
        " -std=c99 -O3 -march=native -ffp-contract=off -fPIC -shared -Wl,-Bsymbolic {}.c caller.c -o "
        "library.so -lm",
        folder_.path().string(), name_);
    if (std::system(command.c_str()) != 0) throw std::runtime_error("cannot be compiled: " + command);
    library_ = dlopen((folder_.path() / "library.so").c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library_ == nullptr) throw std::runtime_error(dlerror());
    start_ = reinterpret_cast<void (*)()>(dlsym(library_, "caller_start"));
    process_ = reinterpret_cast<decltype(process_)>(dlsym(library_, "caller_process"));
  }

  test::TemporaryFolder folder_;
  std::string name_;
  void* library_ = nullptr;
  void (*start_)() = nullptr;
  void (*process_)(const double* const*, double* const*, int) = nullptr;
};

}  // namespace tactus::bench
